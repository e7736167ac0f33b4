"""The filters of the lateral study and what each is told.

literal        the five states of Mal et al. (2020) by forward Euler; knows the track, the condition, and a Q for it
known_track    well posed, friction a random walk; knows the track, not the condition; one Q
unknown_track  as before, and of the track only its spectrum
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from math import log
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from railgrip.errors import FilterDiverged
from railgrip.estimation.run import Kind, prediction_of
from railgrip.estimators.belief import Array, Estimate, Vector, seal
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.prediction import PredictionInC
from railgrip.studies.lateral.wheelset import (
    CONDITIONS,
    INPUTS,
    OUTPUTS,
    PAPER_SENSORS,
    PERIOD,
    PLANTS,
    READINGS,
    Condition,
    Course,
    Irregularity,
    Trial,
    course,
    output_columns,
    wheelset,
)

Name = Literal["literal", "known_track", "unknown_track"]
NAMES: Final[tuple[Name, ...]] = get_args(Name)

READING_NOISE: Final = (PAPER_SENSORS[0] ** 2, PAPER_SENSORS[1] ** 2)

# What one step of 50 µs adds, for dy, dpsi, gamma, U, F; Mal et al. (2020), eq. (38) to (40).
LITERAL_NOISE: Final[Mapping[str, tuple[float, ...]]] = {
    "dry": (5e-14, 1e-14, 1e-14, 1e-14, 1e-14),
    "wet": (0.5e-12, 9e-17, 1e-12, 1e-12, 1e-12),
    "poor": (1e-13, 9e-17, 1e-12, 1e-12, 1e-12),
    "worst": (1e-13, 9e-17, 1e-12, 1e-12, 1e-12),
}

MOTION_NOISE: Final = (0.0, 1e-6**2, 0.0, 1e-7**2)
"""Density for y, dy, psi, dpsi [unit²/s]: the dynamics hold nearly exactly. Much more of it, and friction above 0.2 is
no longer told apart: a slope of the contact that is wrong by a part in a thousand looks like another friction."""

FRICTION_NOISE: Final = 0.2**2
"""Density of the random walk of the friction's logarithm [1/s]: 20 % in a second; creep must show a step."""

TRACK_DEVIATION: Final = 2.5e-3
"""Standard deviation of the track [m] that the filter of unknown track believes in: a third of the peak."""

FIRST_FRICTION: Final = (0.25, 0.6)
"""Median of mu0 and deviation of its logarithm before anything is known: from 0.08 to 0.83 with 95 %."""

FIRST_MOTION: Final = (1e-5**2, 1e-4**2, 1e-6**2, 1e-5**2)
"""Variances of y, dy, psi, dpsi at the start: the wheelset starts centred and at rest, but for these."""

FIRST_CREEP: Final = 1e-7
"""Creep at which the literal filter starts; at zero its equations are singular."""

CLASSES: Final[Mapping[Name, str]] = {
    "literal": "RailBraking.Predictions.LateralLiteral",
    "known_track": "RailBraking.Predictions.LateralPrediction",
    "unknown_track": "RailBraking.Predictions.LateralPredictionUnknownTrack",
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Observer:
    """A filter at its start.

    Attributes:
        name: Of the filter.
        filter: Its outputs are the readings.
        first: Belief at the start.
        columns: Column of the run's table for each input of the filter; "" for an integral.
        integrals: Input of the filter → state that it is the integral of.
    """

    name: Name
    filter: CompiledFilter
    first: Estimate
    columns: tuple[str, ...]
    integrals: Mapping[str, str] = field(default_factory=dict)


@cache
def prediction(name: Name, kind: Kind = "fmu") -> PredictionInC:
    """Return the model inside a filter, with the parameters of Table 1."""
    return prediction_of(CLASSES[name], kind=kind)


def literal_density(condition: Condition) -> Vector:
    """Return the process noise of the literal filter as a density, shape (5,)."""
    return np.array(LITERAL_NOISE[condition.name]) / PERIOD


def observer(
    name: Name,
    first: Condition,
    irregularity: Irregularity,
    sensors: tuple[float, float] = PAPER_SENSORS,
    kind: Kind = "fmu",
) -> Observer:
    """Return a filter at its start.

    Args:
        first: Condition at the start; only the literal filter is told.
        irregularity: Of the track; only the filter of unknown track uses it, for the spectrum.
        sensors: Standard deviations of the readings.
        kind: What it evaluates.
    """
    model = prediction(name, kind)
    noise = np.square(sensors)
    if name == "literal":
        filter_ = CompiledFilter(model, literal_density(first), noise, PERIOD, order=1)
        # The paper gives no covariance for the start; one step of its process noise, since all is known.
        start = filter_.start([0, 0, FIRST_CREEP, first.mu0, 0], LITERAL_NOISE[first.name])
        filter_.inputs[:] = 0.0
        integrals = {"lateral_position": "dy", "yaw_angle": "dpsi"}
        columns = tuple("" if input_ in integrals else input_ for input_ in filter_.design.inputs)
        return Observer(name=name, filter=filter_, first=start, columns=columns, integrals=integrals)
    density = [*MOTION_NOISE, FRICTION_NOISE]
    mean, variance = [0.0, 0.0, 0.0, 0.0, log(FIRST_FRICTION[0])], [*FIRST_MOTION, FIRST_FRICTION[1] ** 2]
    if name == "unknown_track":
        density += [0.0, irregularity.acceleration_density(TRACK_DEVIATION)]
        mean += [0.0, 0.0]
        variance += [1e-5**2, 1e-5**2]
    filter_ = CompiledFilter(model, density, noise, PERIOD)
    return Observer(name=name, filter=filter_, first=filter_.start(mean, variance), columns=filter_.design.inputs)


EVERY: Final = 20
"""Samples from one recorded instant to the next: 1 ms."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """What decides a run.

    Attributes:
        test: Which conditions, when.
        speed: Along the track [m/s].
        plant: Name in `PLANTS`: what the filters' model leaves out, and how good the sensors are.
        seed: Of track and sensors.
        irregularity: Of the track.
        prediction: What the filters evaluate: FMUs, or their equations.
    """

    test: Trial
    speed: float
    plant: str
    seed: int
    irregularity: Irregularity = field(default_factory=Irregularity)
    prediction: Kind = "fmu"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Beliefs:
    """What a filter believed at the recorded instants; NaN after it diverged.

    Attributes:
        mean: Shape (k, n).
        covariance: Shape (k, n, n).
        squared_innovation: NIS, shape (k,).
        failure_sample: Sample of 50 µs at which it diverged; None if it did not.
    """

    mean: Array
    covariance: Array
    squared_innovation: Array
    failure_sample: int | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trace:
    """What happened, at every recorded instant.

    Attributes:
        time: Shape (k,) [s].
        period: Between instants [s].
        truth: Of the plant by name, shape (k,); creep, force and friction are means of both wheels.
        mu0: Maximum friction coefficient, shape (k,).
        condition: Number of the true condition in `CONDITIONS`, shape (k,).
        track: Position [m], shape (k,).
        changes: Instants at which a condition begins [s].
        wall: Seconds that plant and filters took.
    """

    case: Case
    time: Array
    period: float
    truth: Mapping[str, Array]
    mu0: Array
    condition: NDArray[np.intp]
    track: Array
    changes: tuple[float, ...]
    beliefs: Mapping[Name, Beliefs]
    wall: float


def simulate(case: Case, names: Sequence[Name] = NAMES) -> Trace:
    """Run the plant with filters beside it.

    Raises:
        railgrip.fmu.PlantFailed: The plant could not be stepped. A filter that diverges is a result.
    """
    vehicle = PLANTS[case.plant]
    realisation = course(case.test, case.seed, case.irregularity, sensors=vehicle.sensors)
    table = dict(zip(INPUTS, realisation.inputs.T, strict=True))
    table |= {"track_rate": realisation.track_rate, "speed": np.full(len(realisation.inputs), case.speed)}
    observers = [
        observer(name, realisation.conditions[0], case.irregularity, sensors=vehicle.sensors, kind=case.prediction)
        for name in names
    ]
    begin = time.perf_counter()
    with wheelset(case.speed, vehicle.parameters) as plant:
        plant.start(realisation.inputs[0])
        outputs = plant.follow(realisation.inputs)
    places = output_columns(tuple(OUTPUTS))
    readings = np.column_stack([outputs[:, places[name]] for name in READINGS]) + realisation.noise
    beliefs: dict[Name, Beliefs] = {one.name: _followed(one, table, readings, realisation) for one in observers}
    wall = time.perf_counter() - begin
    sample = np.concatenate(
        [first + EVERY * np.arange(1, (last - first) // EVERY + 1) for first, last in realisation.segments]
    )
    inputs, shown = realisation.inputs[sample - 1], outputs[sample - 1]
    numbers = [CONDITIONS.index(condition) for condition in realisation.conditions]
    true = ("yaw_rate", "lateral_position", "lateral_velocity", "yaw_angle", "creep", "creep_force", "friction")
    return Trace(
        case=case,
        time=PERIOD * sample.astype(np.float64),
        period=EVERY * PERIOD,
        truth={name: shown[:, places[name]].mean(axis=1) for name in true},
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


def _followed(one: Observer, table: Mapping[str, Array], readings: Array, realisation: Course) -> Beliefs:
    """Return what a filter believes of the readings, stretch by stretch of one condition."""
    filter_, n = one.filter, one.filter.mean.size
    inputs = np.column_stack([table[column] if column else np.zeros(len(readings)) for column in one.columns])
    prior, failure_sample = one.first, None
    parts: list[tuple[Array, Array, Array]] = []
    for (first, last), condition in zip(realisation.segments, realisation.conditions, strict=True):
        rows = (last - first) // EVERY
        mean, covariance, nis = np.full((rows, n), np.nan), np.full((rows, n, n), np.nan), np.full(rows, np.nan)
        parts.append((mean, covariance, nis))
        if failure_sample is not None:
            continue
        if one.name == "literal":  # the only one that is told
            filter_.retune(literal_density(condition))
        last_good, start = last, filter_.inputs.copy()
        follow = partial(filter_.follow, prior, every=EVERY, integrals=one.integrals, with_covariance=True)
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
