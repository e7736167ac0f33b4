"""One run of the lateral study: the plant, and then its filters on what was read."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from railgrip.errors import FilterDiverged
from railgrip.estimation.run import Kind
from railgrip.estimators.belief import Array, seal
from railgrip.studies.lateral.filters import NAMES, Name, Observer, literal_density, observer
from railgrip.studies.lateral.wheelset import (
    CONDITIONS,
    INPUTS,
    OUTPUTS,
    PERIOD,
    PLANTS,
    READINGS,
    Course,
    Irregularity,
    Trial,
    course,
    output_columns,
    wheelset,
)

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
