"""Brakes whose components disperse: their decelerations in steps of speed and stopping distances, over many draws."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import get_args

import numpy as np

from railgrip.base.groups import gather
from railgrip.estimators.belief import Array
from railgrip.rolling_stock.dispersion import EXTENTS, Dispersion, Quantity
from railgrip.rolling_stock.schema import Train
from railgrip.rolling_stock.stopping import (
    brakes_of,
    by_hand,
    developed_deceleration,
    developed_forces,
    law_of,
    rotating_masses,
    stage_shares,
)
from railgrip.vehicle.brake import piston_force

PARTS = 4
"""Integration steps in each step of speed, equal in v²: with eight, the error of the distance is below 1e-4."""

_LARGEST = 4_000
"""Draws at once: their arrays of a few megabytes stay in the cache."""

Deviations = Mapping[str, Array]
"""Quantity → factor on nominal, or difference of a pressure [Pa]; shape (n, 1), (n, groups) or (n, units)."""


class DispersedBrake(ABC):
    """A train under full brake.

    Attributes:
        units: Brake units of each group; a tuple stands for several like groups, which count together.
        dimension: Standard normal numbers of a draw.
        speeds: Limits of the steps of speed, falling to 0 [m/s].
        nominal: Deceleration in each step, from the slowest, and of the whole stop [m/s2].
        equivalent_time: Nominal [s].
        distance: Nominal [m].
        without: The same brake without its dynamic brakes, whose ratios are to the same nominal values; None without
            any.
    """

    units: tuple[int | tuple[int, ...], ...]
    nominal: Array
    equivalent_time: float
    distance: float
    without: "DispersedBrake | None" = None

    def __init__(
        self,
        units: Sequence[int | tuple[int, ...]],
        dispersion: Sequence[Dispersion],
        speeds: Sequence[float],
    ) -> None:
        """Create the brake from its units, dispersions, and limits of the steps of speed, falling to 0 [m/s]."""
        self.units, self.speeds, self._dispersion = tuple(units), tuple(speeds), tuple(dispersion)
        sizes = [(n,) if isinstance(n, int) else n for n in units]
        groups = [size for kind in sizes for size in kind]
        self._group = np.repeat(np.arange(len(groups)), groups)
        self._parts_of_groups = np.array(groups, dtype=float)[:, None] / sum(groups)
        self._kind = np.repeat(np.arange(len(sizes)), [sum(kind) for kind in sizes])
        self._place = np.concatenate([np.arange(sum(kind)) for kind in sizes])
        self._extents = dict(zip(EXTENTS, (1, len(groups), len(self._group)), strict=True))
        self._widths = [self._extents[one.per] for one in dispersion]
        self.dimension = sum(self._widths)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Quantities with a K: steps of speed, slowest first, and the whole stop with its equivalent time."""
        limits = [3.6 * speed for speed in reversed(self.speeds)]
        steps = [f"{low:g}–{high:g} km/h" for low, high in pairwise(limits)]
        return (*steps, f"stop from {limits[-1]:g} km/h")

    def equivalent_deceleration(self, distance: float | Array) -> float | Array:
        """Return the mean deceleration after the nominal equivalent time [m/s2], which includes a later build-up."""
        v = self.speeds[0]
        return v**2 / (2 * (distance - v * self.equivalent_time))

    def ratios(self, available: Sequence[int], standard: Array) -> Array:
        """Return deceleration over nominal, shape (n, outputs).

        Args:
            available: Units of each group, or of several like groups together, that brake.
            standard: Standard normal numbers, shape (n, dimension).
        """
        ratios = np.empty((len(standard), len(self.nominal)))
        for first in range(0, len(standard), _LARGEST):
            part = slice(first, first + _LARGEST)
            decelerations, distance, _ = self._stops(available, self._deviations(standard[part]))
            ratios[part, :-1], ratios[part, -1] = decelerations, self.equivalent_deceleration(distance)
        return ratios / self.nominal

    @abstractmethod
    def _stops(self, available: Sequence[int], deviations: Deviations) -> tuple[Array, Array, Array]:
        """Return the deceleration of each step, slowest first, shape (n, steps), distance and equivalent time."""

    def _finish(self) -> None:
        """Compute the nominal stop, after the subclass has its data."""
        whole = [int(np.sum(n)) for n in self.units]
        decelerations, distance, time = self._stops(whole, self._deviations(None))
        self.equivalent_time, self.distance = float(time[0]), float(distance[0])
        self.nominal = np.append(decelerations[0], self.equivalent_deceleration(self.distance))

    def _brakes(self, available: Sequence[int]) -> Array:
        """Return 1 for each unit that brakes, otherwise 0."""
        return (self._place < np.asarray(available)[self._kind]).astype(np.float64)

    def _deviations(self, standard: Array | None) -> Deviations:
        n, groups = 1 if standard is None else len(standard), self._extents["group"]
        extents = {"pressure": groups, "wheel_radius": groups, "mass": 1, "build_up": 1, "track_brake": 1}
        extents["dynamic_brake"] = 1
        deviations = {
            name: np.full((n, extents.get(name, len(self._group))), 0.0 if name == "pressure" else 1.0)
            for name in get_args(Quantity)
        }
        if standard is None:
            return deviations
        first = 0
        for dispersion, width in zip(self._dispersion, self._widths, strict=True):
            value, first = dispersion.of(standard[:, first : first + width]), first + width
            if dispersion.quantity == "build_up":
                # The equivalent time of the train is the mean over its brakes.
                value = value @ self._parts_of_groups if width > 1 else value
            elif width == groups < deviations[dispersion.quantity].shape[1]:
                value = value[:, self._group]
            if dispersion.quantity == "pressure":
                deviations[dispersion.quantity] += value
            else:
                deviations[dispersion.quantity] *= 1.0 + value
        return deviations


class TrainBrake(DispersedBrake):
    """The emergency brake of a train file.

    The nominal deceleration is that of the calculation by hand. Forces of friction brakes, magnets and dynamic brakes
    disperse; the running resistance is nominal. Where dynamic brakes relieve friction brakes, only the force that is
    left to these has their dispersion. Valves with like brakes are like groups: their units count together, and of
    units that differ the strongest fail first.
    """

    def __init__(
        self, train: Train, dispersion: Sequence[Dispersion], speeds: Sequence[float], *, dynamic: bool = True
    ) -> None:
        """Create the brake from the train, dispersions, and limits of the steps of speed, falling to 0 [m/s].

        Without `dynamic`, friction brakes replace electrodynamic and eddy-current brakes where these relieve them.

        Raises:
            InputError: The train does not stop within ten minutes.
        """
        kinds = gather(
            (tuple(sorted(train.bogies_in_train[train.axles[axle].bogie].kind for axle in axles)), axles)
            for axles in _units_of_valves(train)
        )
        acting = [one for one in dispersion if one.quantity != "dynamic_brake" or train.dynamic_groups]
        super().__init__([tuple(map(len, valves)) for valves in kinds.values()], acting, speeds)
        axles = np.array([axle for valves in kinds.values() for units in valves for axle in units])
        brakes, _ = brakes_of(train)
        self._unit = {name: values[axles] for name, values in brakes.items()}
        self._law = law_of(self._unit)
        self._turning = np.zeros(self._extents["group"])
        self._rest = 0.0
        group_of_axle = dict(zip(axles.tolist(), self._group.tolist(), strict=True))
        for number, turning in enumerate(rotating_masses(train)[1].tolist()):
            if number in group_of_axle:
                self._turning[group_of_axle[number]] += turning
            else:
                self._rest += turning
        self._dynamic = dynamic
        self._mass, self._build_up = train.mass, by_hand(train, speeds[0], dynamic=dynamic).equivalent_time
        nominal = self._deviations(None)
        whole = np.ones(len(axles))
        strength = self._unit_forces(nominal, whole, whole)[0][0]
        for kind in np.unique(self._kind):
            members = np.flatnonzero(self._kind == kind)
            self._place[members[np.argsort(strength[members], kind="stable")]] = np.arange(len(members))
        self._parts = [part for high, low in pairwise(self.speeds) for part in self._parts_of(train, axles, high, low)]
        self._finish()
        if dynamic and any(bogie.dynamic_brake for bogie in train.bogies_in_train):
            self.without = TrainBrake(train, dispersion, speeds, dynamic=False)
            self.without.nominal, self.without.equivalent_time = self.nominal, self.equivalent_time

    def service_decelerations(self) -> Array:
        """Return the deceleration without magnets in each step, from the slowest, shape (steps,) [m/s2]."""
        without = {**self._deviations(None), "track_brake": np.zeros((1, 1))}
        return self._stops([int(np.sum(n)) for n in self.units], without)[0][0]

    def _parts_of(self, train: Train, axles: Array, high: float, low: float) -> list["_ForcesAtSpeed"]:
        """Return the parts of a step of speed in a stop that begins just below its upper limit."""
        begin = high * (1 - 1e-9)  # at its upper threshold a distributor is in the high stage, below it is not
        speeds, decelerations = developed_deceleration(train, begin, dynamic=self._dynamic)
        inert = float(self._mass + self._turning.sum() + self._rest)
        indices: list[int] = axles.tolist()
        cars = [train.axles[axle].car for axle in indices]
        share = stage_shares(train.stages_of_car, begin, low)[cars]
        forces_at = developed_forces(train, begin, dynamic=self._dynamic)
        parts: list[_ForcesAtSpeed] = []
        for number in range(PARTS):
            speed = (high**2 - (number + 0.5) * (high**2 - low**2) / PARTS) ** 0.5
            whole = inert * float(np.interp(speed, speeds[::-1], decelerations[::-1]))
            forces = forces_at(speed)
            magnets, left, dynamic = sum(forces.rail.tolist()), forces.left[indices], float(forces.dynamic.sum())
            of_speed = self._speed_factor(speed)
            still, falling = (force[0] for force in self._unit_forces(self._deviations(None), share, left))
            friction = float(still @ of_speed - speed * falling.sum())
            others = whole - magnets - dynamic - friction
            parts.append(_ForcesAtSpeed(speed, share, left, of_speed, magnets, dynamic, others))
        return parts

    def _unit_forces(self, deviations: Deviations, share: Array, left: Array) -> tuple[Array, Array]:
        """Return the force at the rim of each unit at standstill [N], and its decrease with speed [N s/m].

        Both have the shape (n, units); `share` is that of the highest pressure in each unit, and `left` that of the
        pad force which dynamic brakes leave. That of blocks is for their nominal speed: `_speed_factor` has their law
        over speed.
        """
        unit = self._unit
        lever = unit["sliding"] * deviations["friction_radius"] / deviations["wheel_radius"][:, self._group]
        force = left * (
            unit["efficiency"]
            * unit["rigging"]
            * deviations["efficiency"]
            * piston_force(
                share * (unit["pressure_max"] + deviations["pressure"][:, self._group]),
                piston_area=unit["piston_area"],
                spring_force=unit["spring_force"],
            )
        )
        friction = unit["pad_friction"] * deviations["pad_friction"]
        law, v_nominal, f_nominal = self._law, unit["speed_nominal"], unit["force_nominal"]
        friction = friction * law.shape(v_nominal, force) / law.shape(v_nominal, f_nominal)
        nominal = lever * force * friction * (1 - unit["force_effect"] * (force / f_nominal - 1))
        effect = unit["speed_effect"]
        return nominal * (1 + effect), nominal * lever * (effect / v_nominal)

    def _speed_factor(self, speed: float) -> Array:
        """Return the friction of the blocks of each unit over that at their nominal speed, 1 for pads, (units,)."""
        unit, law = self._unit, self._law
        at_nominal = law.shape(unit["speed_nominal"], unit["force_nominal"])
        return law.shape(speed * unit["sliding"], unit["force_nominal"]) / at_nominal

    def _stops(self, available: Sequence[int], deviations: Deviations) -> tuple[Array, Array, Array]:
        brakes = self._brakes(available)
        inert = self._mass * deviations["mass"][:, 0] + self._rest
        inert = inert + (self._turning / deviations["wheel_radius"] ** 2).sum(axis=1)
        steps: list[Array] = []
        distance = np.zeros(len(inert))
        forces: dict[bytes, tuple[Array, Array]] = {}
        for number, (high, low) in enumerate(pairwise(self.speeds)):
            inverse = np.zeros(len(inert))
            for part in self._parts[PARTS * number : PARTS * (number + 1)]:
                pressed = part.share.tobytes() + part.left.tobytes()
                if pressed not in forces:
                    still, falling = self._unit_forces(deviations, part.share, part.left)
                    forces[pressed] = still, falling @ brakes
                still, falling = forces[pressed]
                force = still @ (brakes * part.of_speed) - part.speed * falling
                force = force + part.magnets * deviations["track_brake"][:, 0] + part.others
                inverse += inert / (force + part.dynamic * deviations["dynamic_brake"][:, 0])
            steps.append(PARTS / inverse)
            distance += (high**2 - low**2) / (2 * PARTS) * inverse
        time = self._build_up * deviations["build_up"][:, 0]
        return np.stack(steps[::-1], axis=1), distance + self.speeds[0] * time, time


@dataclass(frozen=True, slots=True, eq=False)
class _ForcesAtSpeed:
    """A part of a step of speed.

    Attributes:
        speed: Its speed [m/s].
        share: Share of the highest pressure in each unit.
        left: Share of the pad force of each unit that dynamic brakes leave.
        of_speed: Factor of speed on the friction of blocks of each unit.
        magnets: Force of all brakes on the rail [N].
        dynamic: Force of all electrodynamic and rotating eddy-current brakes [N].
        others: All other forces [N].
    """

    speed: float
    share: Array
    left: Array
    of_speed: Array
    magnets: float
    dynamic: float
    others: float


def _units_of_valves(train: Train) -> list[list[int]]:
    """Return the axle of each brake unit of each valve; valves without units are left out."""
    groups = iter(train.groups)
    valves = [[axle for _ in range(count) for axle in next(groups)] for count in train.groups_per_valve]
    units = [[axle for axle in axles for _ in range(round(train.axles[axle].units))] for axles in valves]
    return [axles for axles in units if axles]


def speed_steps(train: Train, speed: float) -> tuple[float, ...]:
    """Return limits for steps of speed from a speed down to 0 [m/s].

    There are at most seven, 40 km/h wide or wider, which also end where distributors change between their stages.
    """
    stages = {v for part in train.stages_of_car if part is not None for v in (part.speed_up, part.speed_down)}
    width = max(40 / 3.6, speed / (5 if stages else 6))
    inner = {v for v in np.arange(1, 6) * width if v < 0.95 * speed and all(abs(v - s) > 0.25 * width for s in stages)}
    return (speed, *sorted(inner | {s for s in stages if s < speed}, reverse=True), 0.0)
