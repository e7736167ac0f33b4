"""The open loop: a plant whose inputs are known before, sensors that read it, an estimator beside it; no controller."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from railgrip.loop.ports import Estimator, Plant, Sensors

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Watched:
    """What happened, a row for each sample that was read.

    Attributes:
        truth: Outputs of the plant, shape (n, outputs).
        reading: Of the sensors, shape (n, readings).
        mean: Of the belief, shape (n, states).
        variance: Diagonal of its covariance, shape (n, states).
    """

    truth: Array
    reading: Array
    mean: Array
    variance: Array


def watch(
    *,
    plant: Plant,
    inputs: Array,
    sensors: Sensors,
    estimator: Estimator,
    estimator_inputs: Array,
    lead_in: int = 0,
    progress: Callable[[int], None] | None = None,
) -> Watched:
    """Step a plant through a course of inputs; sensors read and the estimator steps at every sample.

    Args:
        plant: Not yet started.
        inputs: Of the plant, a row for each sample, shape (k, inputs); row 0 at the start.
        sensors: Instruments; their sample 0 is the first one that is read.
        estimator: At its start; given every reading, missing entries NaN.
        estimator_inputs: What the estimator knows beside its readings, for the whole run.
        lead_in: Samples at the beginning that are not read: the plant settles.
        progress: Called with the sample now and then.

    Raises:
        PlantFailed: The plant refused a step.
        ArithmeticError: The estimator failed.
    """
    count = len(inputs) - lead_in
    truth = plant.start(inputs[0])
    truths = np.empty((count, len(truth)))
    reading: Array | None = None
    mean, variance = np.empty((count, len(estimator.mean))), np.empty((count, len(estimator.mean)))
    estimator.inputs[:] = estimator_inputs
    for k in range(len(inputs)):
        if k > 0:
            truth = plant.step(inputs[k])
        row = k - lead_in
        if row < 0:
            continue
        latest = estimator.readings[:] = sensors.read(row, truth)
        estimator.advance()
        if reading is None:
            reading = np.empty((count, len(latest)))
        truths[row], reading[row] = truth, latest
        mean[row], variance[row] = estimator.mean, np.diagonal(estimator.covariance)
        if progress is not None and row % 512 == 0:
            progress(row)
    return Watched(truth=truths, reading=np.empty((0, 0)) if reading is None else reading, mean=mean, variance=variance)
