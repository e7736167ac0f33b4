"""The filter of the field test over one braking: 13 states, pressures and track force in, speeds seen."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from railgrip.estimation.run import by_name
from railgrip.estimation.spec import (
    LIBRARY,
    Specification,
    equations_for,
    load_specification,
    prediction_for,
    settings_for,
)
from railgrip.estimation.track.braking import Braking
from railgrip.estimators.belief import Array, Estimate
from railgrip.estimators.compiled import CompiledFilter, Estimates
from railgrip.estimators.consistency import loss_step
from railgrip.estimators.prediction import CasadiPrediction, PredictionInC
from railgrip.studies.field_test.noise import GROUPS, PHYSICAL, Noise
from railgrip.trace.samples import knows, period_of, samples, truth_of


@cache
def specification() -> Specification:
    """Return the estimation of the field test, whose model, start and gate stand in its file."""
    return load_specification(LIBRARY / "field.toml")


@dataclass(frozen=True, slots=True)
class Task:
    """A braking as arrays, once for many runs of the filter.

    Attributes:
        braking: What it is made of.
        inputs: Pressures and track force, the mean over each period, shape (k − 1, 5).
        readings: Speed and wheelset speeds at the end of each period, shape (k − 1, 5).
        start: Belief at the first sample.
        truth: Of all 13 states at the end of each period, shape (k − 1, 13), or None.
        period: [s].
    """

    braking: Braking
    inputs: Array
    readings: Array
    start: Estimate
    truth: Array | None
    period: float


def prediction() -> PredictionInC:
    """Return the prediction of the field test; equations (1) to (5), (10) to (12) of the paper."""
    return prediction_for(specification())


def equations() -> CasadiPrediction:
    """Return the same as equations, which threads may share."""
    return equations_for(specification())


def task_of(braking: Braking, model: PredictionInC) -> Task:
    """Return a braking as arrays, from its first sample of coasting.

    Raises:
        EstimationError: A reading is missing.
    """
    recording = braking.recording
    inputs = samples(recording, model.inputs, [*["Pa"] * GROUPS, "N"])
    readings = samples(recording, model.outputs, ["m/s", *["rad/s"] * GROUPS])
    has_truth = all(knows(recording, state) for state in model.states)
    truth = np.column_stack([truth_of(recording, state) for state in model.states])[1:] if has_truth else None
    start = specification().start
    frictions = by_name("start", start.mean, model.states[1 + GROUPS :])
    deviation = by_name("start deviation", start.deviation, model.states)
    return Task(
        braking=braking,
        inputs=0.5 * (inputs[1:] + inputs[:-1]),
        readings=readings[1:],
        start=Estimate(mean=np.concatenate([readings[0], frictions]), covariance=np.diag(deviation**2)),
        truth=truth,
        period=period_of(recording),
    )


def filter_of(model: PredictionInC, period: float, noise: Noise = PHYSICAL) -> CompiledFilter:
    """Return a compiled filter for brakings of one period."""
    gate = settings_for(specification(), period).gate
    return CompiledFilter(model, noise.process, noise.readings, period, gate)


def follow(task: Task, filter_: CompiledFilter, noise: Noise, start_scale: float = 1.0) -> Estimates:
    """Return the beliefs over a braking with given noises.

    Args:
        filter_: Of `filter_of`; used by this call alone.
        start_scale: Factor on the covariance at the start.

    Raises:
        FilterDiverged: The filter did.
    """
    filter_.retune(noise.process, noise.readings)
    start = Estimate(mean=task.start.mean, covariance=start_scale * task.start.covariance)
    return filter_.follow(start, task.inputs, task.readings)


def lost(task: Task, estimate: Estimates) -> float | None:
    """Return when innovations said that the beliefs mean nothing [s] from the first sample, None where they do not."""
    step = loss_step(estimate.squared_innovation, estimate.degrees)
    return None if step is None else (step + 1) * task.period
