"""One run of the lateral study: the plant and its filters, side by side in C."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from railgrip.estimation.run import Kind
from railgrip.estimators.belief import Array
from railgrip.loop.compiled import Beliefs, Record, run
from railgrip.studies.lateral.filters import FURTHER, NAMES, Name, literal_density, party
from railgrip.studies.lateral.wheelset import (
    CONDITIONS,
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
        wall: Seconds that the loop took.
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
    table = np.column_stack([realisation.inputs, realisation.track_rate, np.full(len(realisation.inputs), case.speed)])
    first_condition, kind = realisation.conditions[0], case.prediction
    parties = [party(name, first_condition, case.irregularity, sensors=vehicle.sensors, kind=kind) for name in names]
    records: list[Record] = []
    with wheelset(case.speed, vehicle.parameters) as plant:
        plant.start(realisation.inputs[0])
        begin = time.perf_counter()
        for (first, last), condition in zip(realisation.segments, realisation.conditions, strict=True):
            for one in parties:
                if one.name == "literal":  # the only one that is told
                    one.filter.retune(literal_density(condition))
            records.append(
                run(
                    plant,
                    table[first:last],
                    further=FURTHER,
                    readings=tuple(READINGS),
                    noise=realisation.noise[first:last],
                    observers=[one for one in parties if _alive(records, one.name)],
                    every=EVERY,
                )
            )
        wall = time.perf_counter() - begin
    return _trace(case, realisation, records, names, wall)


def _alive(records: Sequence[Record], name: str) -> bool:
    return all(name in record.beliefs and not record.beliefs[name].failure for record in records)


def _trace(case: Case, realisation: Course, records: Sequence[Record], names: Sequence[Name], wall: float) -> Trace:
    outputs = np.concatenate([record.outputs for record in records])
    sample = np.concatenate([record.sample for record in records])
    places = output_columns(
        ("yaw_rate", "lateral_position", "lateral_velocity", "yaw_angle", "creep", "creep_force",
         "friction")
    )  # fmt: skip
    inputs = realisation.inputs[sample - 1]
    numbers = [CONDITIONS.index(condition) for condition in realisation.conditions]
    return Trace(
        case=case,
        time=PERIOD * sample.astype(np.float64),
        period=EVERY * PERIOD,
        truth={name: outputs[:, place].mean(axis=1) for name, place in places.items()},
        mu0=inputs[:, 1],
        condition=np.concatenate([np.full(len(r.sample), n) for r, n in zip(records, numbers, strict=True)]),
        track=inputs[:, 0],
        changes=tuple(first * PERIOD for first, _ in realisation.segments),
        beliefs={name: _join(records, name) for name in names},
        wall=wall,
    )


def _join(records: Sequence[Record], name: str) -> Beliefs:
    """Return the beliefs of all stretches in a row; NaN where the filter no longer ran."""
    beliefs = [record.beliefs[name] for record in records if name in record.beliefs]
    n = beliefs[0].mean.shape[1]
    missing = sum(len(record.sample) for record in records if name not in record.beliefs)
    last = beliefs[-1]
    return Beliefs(
        mean=np.concatenate([*(b.mean for b in beliefs), np.full((missing, n), np.nan)]),
        covariance=np.concatenate([*(b.covariance for b in beliefs), np.full((missing, n, n), np.nan)]),
        squared_innovation=np.concatenate([*(b.squared_innovation for b in beliefs), np.full(missing, np.nan)]),
        failure=last.failure,
        failure_sample=last.failure_sample,
    )
