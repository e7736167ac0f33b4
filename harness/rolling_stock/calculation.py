"""The brake calculation of a train by mean values, as one signs it: forces, times, distances, adhesion, energy.

Source: EN 14531-1, mean values; the stop by time steps next to it is that of `railgrip.rolling_stock.stopping`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import isclose
from types import MappingProxyType
from typing import Final

import numpy as np

from railgrip.rolling_stock.schema import Train
from railgrip.rolling_stock.stopping import (
    HandCalculation,
    Vector,
    by_hand,
    developed_forces,
    response_times,
    rotating_masses,
)

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(24)

BRAKED_WEIGHT: Final[Mapping[int, tuple[float, float]]] = MappingProxyType(
    {100: (61300, 8.9), 120: (91633, 11.6), 140: (130995, 11.6), 150: (152640, 11.6), 160: (176714, 11.6),
     180: (228219, 11.6), 200: (287620, 11.6)}
)  # fmt: skip
"""Initial speed [km/h] → C [m %] and D [%] of λ = C/s − D for trains.

Source: UIC 544-1, as in RailProfAC/RailwayBrakeCalculation; verify there.
"""

BRAKED_WEIGHT_OF_VEHICLES: Final[Mapping[int, tuple[float, float]]] = MappingProxyType(
    {100: (52840, 10), 120: (83634, 19), 140: (119179, 19), 160: (161280, 19)}
)
"""The same for single vehicles."""

RANGES: Final[Mapping[bool, tuple[float, float]]] = MappingProxyType({True: (50, 140), False: (40, 250)})
"""Range of λ [%] of the assessment from 100 km/h, and from other speeds; from the same source."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeanStop:
    """A stop by mean values.

    Attributes:
        speed: Initial speed [m/s].
        forces: Mean brake force at the rim of each axle, shape (axles,) [N].
        rail_forces: Mean force of the track brakes of each bogie that has them [N].
        resistance: Mean running resistance [N].
        equivalent_time: Σ te F/Σ F over all brakes, with the running resistance in the lower sum [s].
        deceleration: Equivalent deceleration (Σ F)/(mass with rotating parts) [m/s2].
        distance: v te + v²/(2 a) [m].
        adhesion: Required adhesion of each axle, shape (axles,); coupled axles share their forces.
        energy: Energy that the brakes of each axle take, shape (axles,) [J].
        power: Maximum power of the brakes of each axle, at the initial speed, shape (axles,) [W].
        time_steps: The stop by time steps.
        steps: Upper speed, lower speed [m/s] and deceleration with developed brakes [m/s2] of each speed step.
        percentages: Braked weight percentage as a train and as a single vehicle; None where the source has no values.
    """

    speed: float
    forces: Vector
    rail_forces: Vector
    resistance: float
    equivalent_time: float
    deceleration: float
    distance: float
    adhesion: Vector
    energy: Vector
    power: Vector
    time_steps: HandCalculation
    steps: tuple[tuple[float, float, float], ...]
    percentages: tuple[float | None, float | None]


def mean_stop(train: Train, speed: float, step: float = 20 / 3.6) -> MeanStop:
    """Return the stop of a train on level dry track by mean values.

    A mean is taken over the distance at constant deceleration, that is over the square of the speed, so that
    A + B v + C v² has the mean A + 2/3 B v0 + C v0²/2 of EN 14531-1.

    Args:
        train: The train.
        speed: Speed at the brake demand [m/s].
        step: Width of the speed steps of the deceleration [m/s].

    Raises:
        InputError: The train does not stop within ten minutes.
    """
    mass, turning, shares = rotating_masses(train)
    inert = float(mass.sum() + turning.sum())
    forces, rail, resistance = _mean(train, speed, 0.0, speed)
    times, rail_times = response_times(train)
    braking = float(forces.sum() + rail.sum() + resistance)
    time = float(forces @ times + rail @ rail_times) / braking
    deceleration = braking / inert
    distance = speed * time + speed**2 / (2 * deceleration)
    edges = [*np.arange(speed, step / 2, -step).tolist(), 0.0]
    steps = tuple(
        (upper, lower, float(sum(np.sum(part) for part in _mean(train, upper, lower, speed))) / inert)
        for upper, lower in pairwise(edges)
    )
    # The running resistance of bearings and rolling acts at the wheels, too, but no standard counts it as adhesion.
    return MeanStop(
        speed=speed,
        forces=forces,
        rail_forces=rail,
        resistance=resistance,
        equivalent_time=time,
        deceleration=deceleration,
        distance=distance,
        adhesion=shares @ (forces - turning * deceleration),
        energy=forces * (distance - speed * time),
        power=forces * speed,
        time_steps=by_hand(train, speed),
        steps=steps,
        percentages=(
            braked_weight_percentage(speed, distance, BRAKED_WEIGHT),
            braked_weight_percentage(speed, distance, BRAKED_WEIGHT_OF_VEHICLES),
        ),
    )


def braked_weight_percentage(
    speed: float, distance: float, coefficients: Mapping[int, tuple[float, float]]
) -> float | None:
    """Return λ = C/s − D [%]; None at a speed without coefficients, or outside of the range of the assessment.

    Args:
        speed: Initial speed [m/s].
        distance: Stopping distance on level track [m].
        coefficients: Initial speed [km/h] → C and D.
    """
    at = next((entry for entry in coefficients if isclose(3.6 * speed, entry, rel_tol=1e-9)), None)
    if at is None:
        return None
    over, less = coefficients[at]
    low, high = RANGES[at == 100]
    percentage = over / distance - less
    return percentage if low <= percentage <= high else None


def _mean(train: Train, upper: float, lower: float, start: float) -> tuple[Vector, Vector, float]:
    """Return the means over the square of the speed of brake forces, track brakes and running resistance [N]."""
    # Gauss-Legendre over the speed, weighted with it: exact for polynomials of the speed.
    speeds = lower + (upper - lower) * (_POINTS + 1) / 2
    weights = _WEIGHTS * speeds * (upper - lower) / (upper**2 - lower**2)
    parts = [developed_forces(train, float(speed), start) for speed in speeds]
    forces, rail, resistance = (sum(w * part[i] for w, part in zip(weights, parts, strict=True)) for i in range(3))
    return np.asarray(forces), np.asarray(rail), float(np.sum(resistance))
