"""The filter of the field test over one braking: 13 states, pressures and track force in, speeds seen."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.belief import Estimate
from estimators.compiled import CompiledFilter, Followed
from estimators.gate import Gate
from estimators.prediction import CasadiPrediction
from harness.estimate.recording import columns, period_of, truth_of
from harness.estimate.run import BUILD
from harness.estimate.selection import prediction_seeing
from harness.field.braking import Braking
from harness.field.noise import GROUPS, PHYSICAL, Noise

Array = NDArray[np.float64]

MODEL = "TrainPredictionReduced"
SEEN = ("speed", "wheelset_speed")

RELEASED = 0.45e5
"""Cylinder pressure below which pad friction is held still [Pa]: 1.5 kN of the 56 kN of a full brake; below, the pads
tell nothing of themselves, and the paper's filter would let their variance grow."""

START_MU_B, START_DEVIATION = 0.35, (0.03, *[0.1] * GROUPS, *[0.04] * GROUPS, *[0.02] * GROUPS)
"""Pads as new; standard deviations of v [m/s], w [rad/s], μ_B and α at the first sample: sensors, the spread of pads
between lots (10 %), and a train that coasts."""


@dataclass(frozen=True, slots=True)
class Task:
    """A braking as arrays, once for many runs of the filter.

    Attributes:
        braking: What it is made of.
        held: Pressures and track force, the mean over each period, shape (k − 1, 5).
        seen: Speed and wheelset speeds at the end of each period, shape (k − 1, 5).
        start: Belief at the first sample.
        truth: Of all 13 states at the end of each period, shape (k − 1, 13), or None.
        period: [s].
    """

    braking: Braking
    held: Array
    seen: Array
    start: Estimate
    truth: Array | None
    period: float


def prediction() -> CasadiPrediction:
    """Return the prediction of the field test; equations (1) to (5), (10) to (12) of the paper."""
    return prediction_seeing(MODEL, SEEN)


def task_of(braking: Braking, model: CasadiPrediction) -> Task:
    """Return a braking as arrays, from its first sample of coasting.

    Raises:
        EstimationError: A reading is missing.
    """
    recording = braking.recording
    held = columns(recording, model.inputs, [*["Pa"] * GROUPS, "N"])
    seen = columns(recording, model.outputs, ["m/s", *["rad/s"] * GROUPS])
    known = all(f"true_{state}" in recording for state in model.states)
    truth = np.column_stack([truth_of(recording, state) for state in model.states])[1:] if known else None
    mean = np.concatenate([seen[0], np.full(GROUPS, START_MU_B), np.zeros(GROUPS)])
    return Task(
        braking=braking,
        held=0.5 * (held[1:] + held[:-1]),
        seen=seen[1:],
        start=Estimate(mean=mean, covariance=np.diag(np.array(START_DEVIATION) ** 2)),
        truth=truth,
        period=period_of(recording),
    )


def filter_of(model: CasadiPrediction, period: float, noise: Noise = PHYSICAL) -> CompiledFilter:
    """Return a compiled filter for brakings of one period."""
    gate = Gate(
        states=tuple(f"mu_b[{i + 1}]" for i in range(GROUPS)),
        inputs=tuple(f"cylinder_pressure[{i + 1}]" for i in range(GROUPS)),
        threshold=RELEASED,
    )
    return CompiledFilter(model, noise.process, noise.readings, period, gate, directory=BUILD)


def follow(task: Task, filter_: CompiledFilter, noise: Noise, start_scale: float = 1.0) -> Followed:
    """Return the beliefs over a braking with given noises.

    Args:
        task: The braking.
        filter_: Of `filter_of`; used by this call alone.
        noise: For this run.
        start_scale: Factor on the covariance at the start.

    Raises:
        FilterDiverged: The filter did.
    """
    filter_.retune(noise.process, noise.readings)
    start = Estimate(mean=task.start.mean, covariance=start_scale * task.start.covariance)
    return filter_.follow(start, task.held, task.seen)
