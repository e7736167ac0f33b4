"""The brake calculation of a train by mean values, as one signs it: forces, times, distances, adhesion, energy.

Source: EN 14531-1, mean values; the stop by time steps next to it is that of `railgrip.rolling_stock.stopping`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import inf, isclose, sqrt
from types import MappingProxyType
from typing import Final

import numpy as np

from railgrip.base.units import GRAVITY
from railgrip.rolling_stock.schema import Train
from railgrip.rolling_stock.stopping import (
    DevelopedForces,
    HandCalculation,
    Vector,
    by_hand,
    developed_forces,
    parking_forces,
    response_times,
    rotating_masses,
)

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_PARTS = 8
"""Parts of a range of speeds, each with a rule of its own: forces of dynamic brakes have kinks."""

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

PARKING_SLOPE: Final = 0.040
"""Gradient on which a unit must be kept immobilised; LOC&PAS TSI (EU 1302/2014), 4.2.4.5.5."""

PARKING_ADHESION: Final = 0.12
"""Maximum adhesion in the design of a parking brake; LOC&PAS TSI, 4.2.4.6.1."""

RANGES: Final[Mapping[bool, tuple[float, float]]] = MappingProxyType({True: (50, 140), False: (40, 250)})
"""Range of λ [%] of the assessment from 100 km/h, and from other speeds; from the same source."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeanStop:
    """A stop by mean values.

    Attributes:
        speed: Initial speed [m/s].
        distance: v te + v²/(2 a) [m].
        equivalent_time: Σ te F/Σ F over all brakes, with the running resistance in the lower sum [s].
        deceleration: Equivalent deceleration (Σ F)/(mass with rotating parts) [m/s2].
        resistance: Mean running resistance [N].
        force: Mean force of the friction brakes at the rim of each axle, shape (axles,) [N].
        force_dynamic: The same of the electrodynamic and rotating eddy-current brakes.
        force_rail_brakes: Mean force of each brake on the rail itself [N].
        adhesion: Required adhesion of each axle, shape (axles,); coupled axles share their forces.
        energy, energy_dynamic: Energy that friction and dynamic brakes of each axle take, shape (axles,) [J].
        distance_without_dynamic: Distance by mean values if no electrodynamic or eddy-current brake acts, and friction
            brakes replace those that relieve them [m]; None for a train without any.
        power: Mean force of the friction brakes of each axle times the initial speed, shape (axles,) [W].
        steps: Upper speed, lower speed [m/s] and deceleration with developed brakes [m/s2] of each speed step.
        braked_weight_percentage_train: As a train; None where the source has no values.
        braked_weight_percentage_vehicle: As a single vehicle; likewise.
        time_steps: The stop by time steps.
        full_force: `force` with full pressure, which dynamic brakes do not relieve.
    """

    speed: float
    distance: float
    equivalent_time: float
    deceleration: float
    resistance: float
    force: Vector
    force_dynamic: Vector
    force_rail_brakes: Vector
    adhesion: Vector
    energy: Vector
    energy_dynamic: Vector
    distance_without_dynamic: float | None
    power: Vector
    steps: tuple[tuple[float, float, float], ...]
    braked_weight_percentage_train: float | None
    braked_weight_percentage_vehicle: float | None
    time_steps: HandCalculation
    full_force: Vector


@dataclass(frozen=True, slots=True, kw_only=True)
class Parking:
    """What the parking brake holds.

    Attributes:
        force: Force of all parking brakes at the rims [N].
        usable: The part of it that needs an adhesion of `PARKING_ADHESION` or less [N].
        slope: Tangent of the steepest gradient on which that part holds the train; infinite if it holds its weight.
        adhesion: Maximum adhesion of an axle on `PARKING_SLOPE`, if all parking brakes share the downhill force in
            proportion to their forces; infinite without a parking brake.
    """

    force: float
    usable: float
    slope: float
    adhesion: float


def parking(train: Train) -> Parking:
    """Return force, gradient and adhesion of the parking brake of a train; groups of coupled axles share their forces.

    Running resistance is neglected, and load is that on level track.
    """
    members = [list(group) for group in train.groups]
    forces = np.array([parking_forces(train)[each].sum() for each in members])
    load = np.array([GRAVITY * sum(train.axles[i].mass for i in each) for each in members])
    total, usable = float(forces.sum()), float(np.minimum(forces, PARKING_ADHESION * load).sum())
    sine, needed = usable / float(load.sum()), float(load.sum()) * PARKING_SLOPE / sqrt(1 + PARKING_SLOPE**2)
    return Parking(
        force=total,
        usable=usable,
        slope=sine / sqrt(1 - sine**2) if sine < 1 else inf,
        adhesion=float(np.max(forces / load)) * needed / total if total > 0 else inf,
    )


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
    forces_at = developed_forces(train, speed)
    mean = _mean(forces_at, speed, 0.0)
    deceleration, time = _total(mean) / inert, _equivalent_time(train, mean)
    distance = speed * time + speed**2 / (2 * deceleration)
    full, without = mean, None
    if train.dynamic_brakes:
        full = _mean(developed_forces(train, speed, dynamic=False), speed, 0.0)
        without = speed * _equivalent_time(train, full) + speed**2 * inert / (2 * _total(full))
    way = distance - speed * time
    edges = [*np.arange(speed, step / 2, -step).tolist(), 0.0]
    steps = tuple((upper, lower, _total(_mean(forces_at, upper, lower)) / inert) for upper, lower in pairwise(edges))
    # The running resistance of bearings and rolling acts at the wheels, too, but no standard counts it as adhesion.
    return MeanStop(
        speed=speed,
        distance=distance,
        equivalent_time=time,
        deceleration=deceleration,
        resistance=mean.resistance,
        force=mean.friction,
        force_dynamic=mean.dynamic,
        force_rail_brakes=mean.rail,
        adhesion=shares @ (mean.friction + mean.dynamic - turning * deceleration),
        energy=mean.friction * way,
        energy_dynamic=mean.dynamic * way,
        distance_without_dynamic=without,
        power=mean.friction * speed,
        steps=steps,
        braked_weight_percentage_train=braked_weight_percentage(speed, distance, BRAKED_WEIGHT),
        braked_weight_percentage_vehicle=braked_weight_percentage(speed, distance, BRAKED_WEIGHT_OF_VEHICLES),
        time_steps=by_hand(train, speed),
        full_force=full.friction,
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


def _total(mean: DevelopedForces) -> float:
    """Return the sum of all forces [N]."""
    return float(mean.friction.sum() + mean.dynamic.sum() + mean.rail.sum() + mean.resistance)


def _equivalent_time(train: Train, mean: DevelopedForces) -> float:
    """Return Σ te F/Σ F [s]; blended forces have the time of the pressure, since friction brakes provide the rest."""
    times, rail_times = response_times(train)
    of_dynamic = times.copy()
    for each in train.dynamic_groups:
        if each.brake.blending == "added":
            of_dynamic[list(train.groups[each.group])] += each.brake.time_constant
    weighted = mean.friction @ times + mean.dynamic @ of_dynamic + mean.rail @ rail_times
    return float(weighted) / _total(mean)


def _mean(forces_at: Callable[[float], DevelopedForces], upper: float, lower: float) -> DevelopedForces:
    """Return the means of forces over the square of the speed in a range of speeds [m/s]."""
    # Gauss-Legendre over the speed, weighted with it: exact for polynomials of the speed.
    edges = np.linspace(lower, upper, _PARTS + 1)
    speeds = np.add.outer(edges[:-1], (edges[1] - edges[0]) * (_POINTS + 1) / 2).ravel()
    weights = np.tile(_WEIGHTS, _PARTS) * speeds * (edges[1] - edges[0]) / (upper**2 - lower**2)
    parts = [forces_at(float(speed)) for speed in speeds]

    def mean(name: str) -> Vector:
        return np.asarray(sum(w * getattr(part, name) for w, part in zip(weights, parts, strict=True)))

    return DevelopedForces(
        friction=mean("friction"), dynamic=mean("dynamic"), left=mean("left"), rail=mean("rail"),
        resistance=float(mean("resistance")),
    )  # fmt: skip
