"""One run of the lateral study: the plant, then its filters on the readings.

reconstruction  the five states that Mal et al. (2020) name, by forward Euler; knows the track, the condition, and a Q
                for it; our derivation, because the equations of the paper were not available
known_track     well posed, friction is a random walk; knows the track, not the condition; one Q
unknown_track   as before, but knows only the spectrum of the track

The last two also exist with the creep stiffness as a further state: known_track_stiffness, unknown_track_stiffness.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from math import log
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import FilterDiverged
from railgrip.estimation.lateral.wheelset import (
    ALL_PLANTS,
    COLUMNS,
    CONDITIONS,
    INPUTS,
    OUTPUTS,
    PERIOD,
    PLANTS,
    READINGS,
    Condition,
    LateralInputs,
    PlantVariant,
    SurfaceTest,
    course,
    track_acceleration_density,
    wheelset,
)
from railgrip.estimation.models import Kind, of_class
from railgrip.estimators.belief import Array, GaussianEstimate, Vector, seal
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.observability import linearised_bound
from railgrip.estimators.prediction import PredictionInC

Name = Literal["reconstruction", "known_track", "unknown_track", "known_track_stiffness", "unknown_track_stiffness"]
NAMES: Final[tuple[Name, ...]] = ("reconstruction", "known_track", "unknown_track")
"""Filters of every run of the study."""
STIFFNESS_NAMES: Final[tuple[Name, ...]] = (
    "known_track", "known_track_stiffness", "unknown_track", "unknown_track_stiffness",
)  # fmt: skip
"""Filters without and with an estimate of the creep stiffness."""

# Covariance added in one step of 50 µs, for dy, dpsi, gamma, U, F; Mal et al. (2020), eq. (38) to (40).
PAPER_NOISE: Final[Mapping[str, tuple[float, ...]]] = {
    "dry": (5e-14, 1e-14, 1e-14, 1e-14, 1e-14),
    "wet": (0.5e-12, 9e-17, 1e-12, 1e-12, 1e-12),
    "poor": (1e-13, 9e-17, 1e-12, 1e-12, 1e-12),
    "worst": (1e-13, 9e-17, 1e-12, 1e-12, 1e-12),
}

MOTION_NOISE: Final[Mapping[str, float]] = {"dy": 1e-6**2, "dpsi": 1e-7**2}
"""Densities [unit²/s]: the dynamics are nearly exact. With much more noise, friction above 0.2
is not determined: an error of 0.1 % of the slope of the contact looks like another friction."""

FRICTION_NOISE: Final = 0.2**2
"""Density of the random walk of the logarithm of friction [1/s]: 20 % in a second."""

TRACK_DEVIATION: Final = 2.5e-3
"""Standard deviation of the track [m] in the filter of unknown track: a third of the peak."""

FIRST_FRICTION: Final = (0.25, 0.6)
"""Median of mu0 and deviation of its logarithm at the start: from 0.08 to 0.83 with 95 %."""

STIFFNESS_NOISE: Final = 1e-4**2
"""Density of the random walk of the logarithm of the creep stiffness [1/s]."""

FIRST_STIFFNESS: Final = 0.1
"""Deviation of the logarithm of the creep stiffness at the start, from that of the parameters."""

FIRST_DEVIATION: Final[Mapping[str, float]] = {
    "y": 1e-5, "dy": 1e-4, "psi": 1e-6, "dpsi": 1e-5, "log_mu0": FIRST_FRICTION[1], "log_stiffness": FIRST_STIFFNESS,
    "track": 1e-5, "track_rate": 1e-5,
}  # fmt: skip
"""Standard deviations at the start: the wheelset is centred and at rest."""

PROCESS_NOISE: Final[Mapping[str, float]] = {
    **MOTION_NOISE,
    "log_mu0": FRICTION_NOISE,
    "log_stiffness": STIFFNESS_NOISE,
    "track_rate": track_acceleration_density(TRACK_DEVIATION),
}
"""Densities of the well-posed filters [unit²/s], on the track of the paper; those of other states are 0."""

FIRST_CREEP: Final = 1e-7
"""Creep at the start of the reconstruction; its equations are singular at zero."""

CLASSES: Final[Mapping[Name, str]] = {
    "reconstruction": "RailBraking.Predictions.LateralReconstruction",
    "known_track": "RailBraking.Predictions.LateralPrediction",
    "unknown_track": "RailBraking.Predictions.LateralPredictionUnknownTrack",
    "known_track_stiffness": "RailBraking.Predictions.LateralPredictionStiffness",
    "unknown_track_stiffness": "RailBraking.Predictions.LateralPredictionStiffnessUnknownTrack",
}

INTEGRALS: Final[Mapping[Name, Mapping[str, str]]] = {
    "reconstruction": {"lateral_position": "dy", "yaw_angle": "dpsi"},
}
"""Inputs of a filter that are integrals of its states; the others are columns of the run's table."""


@cache
def prediction(name: Name, kind: Kind = "fmu") -> PredictionInC:
    """Return the model inside a filter, with the parameters of Table 1."""
    return of_class(CLASSES[name]).prediction({}, kind=kind)


def paper_density(condition: Condition) -> Vector:
    """Return the process noise of the reconstruction as a density, shape (5,)."""
    return np.array(PAPER_NOISE[condition.name]) / PERIOD


def process_density(states: Sequence[str], variant: PlantVariant) -> Vector:
    """Return the process noise of a well-posed filter as a density [unit²/s], shape (n,)."""
    scale = {"track_rate": variant.irregularity**2}
    return np.array([PROCESS_NOISE.get(state, 0.0) * scale.get(state, 1.0) for state in states])


def observer(
    name: Name, first: Condition, variant: PlantVariant = PLANTS["paper"], kind: Kind = "fmu"
) -> tuple[CompiledFilter, GaussianEstimate]:
    """Return a compiled filter with the readings as outputs, and its initial estimate.

    Args:
        name: Name of the filter.
        first: Condition at the start; only the reconstruction knows it.
        variant: The plant, whose sensors and size of the irregularity the filters know.
        kind: Form of the prediction.
    """
    model = prediction(name, kind)
    noise = np.square(variant.sensors)
    if name == "reconstruction":
        filter_ = CompiledFilter(model, paper_density(first), noise, PERIOD, order=1)
        filter_.inputs[:] = 0.0
        # The paper specifies no covariance for the start; one step of process noise, because the state is known.
        return filter_, filter_.start([0, 0, FIRST_CREEP, first.mu0, 0], PAPER_NOISE[first.name])
    density = process_density(model.states, variant)
    filter_ = CompiledFilter(model, density, noise, PERIOD)
    mean = [log(FIRST_FRICTION[0]) if state == "log_mu0" else 0.0 for state in model.states]
    variance = [FIRST_DEVIATION[state] ** 2 for state in model.states]
    return filter_, filter_.start(mean, variance)


EVERY: Final = 20
"""Samples from one recorded instant to the next: 1 ms."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LateralCase:
    """Inputs of a run.

    Attributes:
        test: Conditions of the rail over time.
        speed: Initial speed along the track [m/s].
        plant: Name in `ALL_PLANTS`.
        seed: Seed of track and sensors.
        prediction: Form of the prediction in the filters.
    """

    test: SurfaceTest
    speed: float
    plant: str
    seed: int
    prediction: Kind = "fmu"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Beliefs:
    """Estimates of a filter at the recorded instants; NaN after it diverged.

    Attributes:
        mean: Shape (k, n).
        covariance: Shape (k, n, n).
        squared_innovation: NIS, shape (k,).
        failure_sample: Sample of 50 µs at which the filter diverged, or None.
    """

    mean: Array
    covariance: Array
    squared_innovation: Array
    failure_sample: int | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trace:
    """A run at the recorded instants.

    Attributes:
        time: Shape (k,) [s].
        period: Time between instants [s].
        truth: True values by name, shape (k,); creep, force and friction are means of both wheels.
        mu0: Maximum friction coefficient, shape (k,).
        condition: Number of the true condition in `CONDITIONS`, shape (k,).
        track: Position [m], shape (k,).
        changes: Instants at which a condition begins [s].
        wall: Computing time of plant and filters [s].
    """

    case: LateralCase
    time: Array
    period: float
    truth: Mapping[str, Array]
    mu0: Array
    condition: NDArray[np.intp]
    track: Array
    changes: tuple[float, ...]
    beliefs: Mapping[Name, Beliefs]
    wall: float


def simulate(case: LateralCase, names: Sequence[Name] = NAMES) -> Trace:
    """Simulate the plant, and run the filters on its readings.

    Raises:
        railgrip.base.errors.PlantFailed: The plant could not be stepped. A filter that diverges is a result.
    """
    variant = ALL_PLANTS[case.plant]
    realisation = course(case.test, case.seed, variant)
    observers: dict[Name, tuple[CompiledFilter, GaussianEstimate]] = {
        name: observer(name, realisation.conditions[0], variant, case.prediction) for name in names
    }
    begin = time.perf_counter()
    outputs, table = _roll(case, realisation)
    readings = np.column_stack([outputs[:, COLUMNS[name]] for name in READINGS]) + realisation.noise
    beliefs: dict[Name, Beliefs] = {
        name: _follow(name, *filter_and_first, table, readings, realisation)
        for name, filter_and_first in observers.items()
    }
    wall = time.perf_counter() - begin
    sample = np.concatenate(
        [first + EVERY * np.arange(1, (last - first) // EVERY + 1) for first, last in realisation.segments]
    )
    inputs, shown = realisation.inputs[sample - 1], outputs[sample - 1]
    numbers = [CONDITIONS.index(condition) for condition in realisation.conditions]
    true = [name for name in OUTPUTS if name != "lateral_acceleration"]
    return Trace(
        case=case,
        time=PERIOD * sample.astype(np.float64),
        period=EVERY * PERIOD,
        truth={name: shown[:, COLUMNS[name]].mean(axis=1) for name in true},
        mu0=inputs[:, 1],
        condition=np.concatenate(
            [
                np.full((last - first) // EVERY, number)
                for (first, last), number in zip(realisation.segments, numbers, strict=True)
            ]
        ),
        track=inputs[:, 0],
        changes=tuple(first * PERIOD for first, _ in realisation.segments),
        beliefs=beliefs,
        wall=wall,
    )


def _roll(case: LateralCase, realisation: LateralInputs) -> tuple[Array, dict[str, Array]]:
    """Return the outputs of the plant after each step, and the columns from which filters take their inputs."""
    with wheelset(case.speed, ALL_PLANTS[case.plant]) as plant:
        plant.start(realisation.inputs[0])
        outputs = plant.follow(realisation.inputs)
    # The filters get the true speed at the beginning of each step.
    speed = np.concatenate([[case.speed], outputs[:-1, COLUMNS["speed"]].ravel()])
    columns = dict(zip(INPUTS, realisation.inputs.T, strict=True))
    return outputs, columns | {"track_rate": realisation.track_rate, "speed": speed}


def bound_of_run(case: LateralCase, name: Name) -> Beliefs:
    """Return the true states of a well-posed filter at the recorded instants, and their bound as covariances.

    The bound is that of the filter's prediction linearised along the true states, with its noises and its start; every
    reading of the run counts, not only those at the recorded instants.
    """
    variant, model = ALL_PLANTS[case.plant], prediction(name)
    realisation = course(case.test, case.seed, variant)
    outputs, table = _roll(case, realisation)
    moving = {"y": "lateral_position", "dy": "lateral_velocity", "psi": "yaw_angle", "dpsi": "yaw_rate"}
    columns = {state: outputs[:, COLUMNS[output]].ravel() for state, output in moving.items()}
    columns |= {"log_mu0": np.log(table["mu0"]), "track": table["track"], "track_rate": table["track_rate"]}
    columns["log_stiffness"] = np.full(len(outputs), log(variant.parameters.get("k_A", 1.0)))
    states = np.column_stack([columns[state] for state in model.states])
    start = np.where([state in moving for state in model.states], 0.0, states[0])
    bound = linearised_bound(
        model,
        process_density(model.states, variant),
        np.square(variant.sensors),
        PERIOD,
        np.diag([FIRST_DEVIATION[state] ** 2 for state in model.states]),
        np.vstack([start, states]),
        np.column_stack([table[name] for name in model.inputs]),
        EVERY,
    )
    nothing = np.full(len(bound), np.nan)
    return Beliefs(mean=states[EVERY - 1 :: EVERY], covariance=bound, squared_innovation=nothing, failure_sample=None)


def _follow(
    name: Name, filter_: CompiledFilter, first_belief: GaussianEstimate, table: Mapping[str, Array], readings: Array,
    realisation: LateralInputs,
) -> Beliefs:  # fmt: skip
    n, integrals = filter_.mean.size, INTEGRALS.get(name, {})
    unused = np.zeros(len(readings))
    inputs = np.column_stack([unused if input_ in integrals else table[input_] for input_ in filter_.design.inputs])
    prior, failure_sample = first_belief, None
    parts: list[tuple[Array, Array, Array]] = []
    for (first, last), condition in zip(realisation.segments, realisation.conditions, strict=True):
        rows = (last - first) // EVERY
        mean, covariance, nis = np.full((rows, n), np.nan), np.full((rows, n, n), np.nan), np.full(rows, np.nan)
        parts.append((mean, covariance, nis))
        if failure_sample is not None:
            continue
        if name == "reconstruction":  # the only filter that knows the condition
            filter_.retune(paper_density(condition))
        last_good, start = last, filter_.inputs.copy()
        follow = partial(filter_.follow, prior, every=EVERY, integrals=integrals, with_covariance=True)
        try:
            followed = follow(inputs[first:last], readings[first:last])
        except FilterDiverged as diverged:
            last_good = first + diverged.after
            failure_sample = last_good + 1
            filter_.inputs[:] = start
            followed = follow(inputs[first:last_good], readings[first:last_good])
        done = (last_good - first) // EVERY
        mean[:done], covariance[:done], nis[:done] = followed.mean, followed.covariance, followed.squared_innovation
        prior = seal(filter_.mean.copy(), filter_.covariance.copy())
    means, covariances, squares = (np.concatenate(values) for values in zip(*parts, strict=True))
    return Beliefs(mean=means, covariance=covariances, squared_innovation=squares, failure_sample=failure_sample)
