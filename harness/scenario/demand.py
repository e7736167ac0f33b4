"""The table [demand], and the driver who follows it: brake pressures and traction; without it full brake at once."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import cycle
from math import inf, nan
from pathlib import Path
from typing import Annotated, Any, Literal, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from railgrip.base.arrays import Vector
from railgrip.base.errors import ScenarioError
from railgrip.kernel import kernel
from railgrip.scenario.curve import TabulatedQuantity, read_columns
from railgrip.scenario.file import NamedFile
from railgrip.scenario.quantity import Number, UnitRange
from railgrip.scenario.table import Delay, Duration, Length, Speed, Table, optional, table_error
from railgrip.scenario.track import LARGEST_FORCE
from railgrip.vehicle.signals import Layout

_PRESSURE = UnitRange("Pa", between=(0, 1e8), because="pneumatics and hydraulics of brakes stay below 1000 bar")

_Pressure = Annotated[float, _PRESSURE] | Literal["full"]

Deceleration = Annotated[
    float,
    UnitRange("m/s2", above=0, at_most=10, usual=(0.1, 3.0), because="no wheel on a rail brakes by more than 1 g"),
]


class PhaseEnd(Table):
    """The condition that ends a phase: exactly one key."""

    time: Delay | None = optional("since the start")
    duration: Duration | None = optional("of the phase")
    distance: Length | None = optional("travelled since the start")
    speed_below: Speed | None = optional("the train has no more than this")
    speed_above: Speed | None = optional("the train has this, or more")

    def _check(self) -> None:
        if len(self.model_fields_set) != 1:
            raise table_error(
                f"needs exactly one of {', '.join(type(self).model_fields)}, got {len(self.model_fields_set)}"
            )

    @property
    def kind(self) -> Literal["time", "duration", "distance", "speed_below", "speed_above"]:
        """Key of the condition."""
        return cast("Any", next(iter(self.model_fields_set)))

    @property
    def value(self) -> float:
        """Value of the condition [s, m or m/s]."""
        return getattr(self, self.kind)


class Traction(Table):
    """A force that pushes the whole train, like the track force; it does not load the wheelsets."""

    force: Annotated[
        float,
        UnitRange("N", between=(0, LARGEST_FORCE), or_zero=True, usual=(1e3, 1e6), because="trains are pulled with kN"),
    ] = Field(description="most, forward")
    power: (
        Annotated[float, UnitRange("W", above=0, at_most=1e9, usual=(1e4, 3e7), because="trains have 100 kW to 20 MW")]
        | None
    ) = optional("its maximum, if it is limited")
    rate: (
        Annotated[
            float, UnitRange("N/s", above=0, at_most=1e9, usual=(1e3, 1e7), because="force builds up over seconds")
        ]
        | None
    ) = optional("most that the force changes by, also after the end of the phase; at once where there is none")


class StopAt(Table):
    """A driver who stops at a target on a braking curve of constant deceleration."""

    distance: Annotated[float, UnitRange("m", above=0, at_most=1e5)] = Field(description="of the target from the start")
    deceleration: Deceleration = Field(description="of the curve; before it there is no demand")
    full_deceleration: Deceleration = Field(description="that the driver expects of full brake")

    def _check(self) -> None:
        if self.deceleration > self.full_deceleration:
            raise table_error(
                f"deceleration {self.deceleration:g} m/s2 is above full_deceleration {self.full_deceleration:g} m/s2, "
                "the most that the driver expects of the brakes"
            )


class Phase(Table):
    """A demand that holds until a condition is met."""

    pressure: tuple[Number | Literal["full"], ...] | None = optional(
        "most that a controller may send, for all groups or for each: 'full', 0 to release, or a pressure; "
        "none gets more than its full one"
    )
    stop_at: StopAt | None = optional("in place of `pressure`")
    traction: Traction | None = optional("a force that pushes the train")
    until: PhaseEnd | None = optional("the last phase has none")

    @field_validator("pressure", mode="before", json_schema_input_type=_Pressure | list[_Pressure])
    @classmethod
    def _one_or_each(cls, entry: Any) -> Any:
        if entry is None:
            return None
        each = tuple(entry) if isinstance(entry, list | tuple) else (entry,)
        if not each:
            raise table_error("is an empty list; give one pressure, or one for each group")
        return tuple("full" if value == "full" else _PRESSURE.read(value) for value in each)

    def _check(self) -> None:
        if (self.pressure is None) == (self.stop_at is None):
            wrong = "has neither" if self.pressure is None else "has both,"
            raise table_error(f"{wrong} pressure and stop_at; give one of them, pressure = 0 where nothing is braked")


class Demand(Table):
    """The driver's demands: phases in their order, or a profile over time in a file."""

    phases: tuple[Phase, ...] = optional("demands, one after the other", default=())
    file: NamedFile | None = optional(
        "a CSV with columns time, and pressure or pressure_1 … pressure_n; in s and Pa, or in stated units"
    )

    def _check(self) -> None:
        if bool(self.phases) == (self.file is not None):
            raise table_error("needs either phases or the file of a profile")
        for number, phase in enumerate(self.phases, start=1):
            if (phase.until is None) != (number == len(self.phases)):
                wrong = "is the last one and lasts to the end, leave out" if phase.until else "has no"
                raise table_error(f"phases[{number}] {wrong} 'until'")
        if self.file is not None:
            self.profile()

    @property
    def has_traction(self) -> bool:
        """Whether a phase pushes the train."""
        return any(phase.traction is not None and phase.traction.force > 0 for phase in self.phases)

    @property
    def has_target(self) -> bool:
        """Whether the driver stops at a target."""
        return any(phase.stop_at is not None for phase in self.phases)

    def profile(self) -> TabulatedQuantity:
        """Return the times [s] of the file and pressures [Pa], for all groups or for each.

        Raises:
            PydanticCustomError: The file is not a profile.
        """
        file = self.file
        assert file is not None
        return file.read(lambda path: _read_profile(path, file.digest()))


@lru_cache(maxsize=1)
def _read_profile(path: Path, digest: str) -> TabulatedQuantity:  # pyright: ignore[reportUnusedParameter]
    # Cached by digest, because the file is read for validation and for the stop.
    return read_columns(path, axes={"time": "s"}, name="pressure", si="Pa", span=(0.0, 1e8), example="kPa")


Phases = NDArray[np.void]
"""Structs `Phase` of driver.h."""

_MIN_PRESSURE = 1e3
"""Smallest plausible pressure of a brake cylinder [Pa], far below the 0.2 bar at which pads touch."""


class Driver:
    """Follows the phases of a demand; a scenario without one has no driver, and full brake from the first instant on.

    Distance and speed are those of the plant: a scenario states where an event happens, not where a driver assumes it.

    To stop at a target, the demand is 0 until a = v²/(2 d), with d the remaining distance to the target, reaches the
    deceleration a0 of the braking curve. Then it is the share (a + 2 (a - a0)) / `full_deceleration` of the force of
    full brake, which corrects for a train that decelerates other than expected. Beyond the target it is full brake.

    The formulas are in `kernel/driver.c`.

    Attributes:
        struct: `Driver` of driver.h.
    """

    def __init__(
        self, layout: Layout, period: float, *, full: Vector, release_pressure: Vector, phases: Phases,
        binding: bool = True,
    ) -> None:  # fmt: skip
        """Set up the driver of a vehicle.

        Args:
            layout: Layout of the plant's outputs.
            period: Period of the samples [s].
            full: Pressure of full brake, shape (groups,) [Pa].
            release_pressure: Pressure at which pads touch the disc, shape (groups,) [Pa].
            phases: Phases in their order.
            binding: Whether commands are limited to the driver's demand; else the controller limits itself to it.
        """
        self.struct = kernel(layout).struct("Driver", phases=phases, count=len(phases), period=period, binding=binding,
            release_pressure=np.array(release_pressure), full=np.array(full),
        )  # fmt: skip


def driver_of(layout: Layout, demand: Demand, period: float, *, binding: bool) -> Driver:
    """Return the driver who follows a demand with the nominal brakes of a layout; arguments are those of both."""
    full = layout.formation.pressure_max
    release_pressure = np.array([brake.pressure_of(0.0) for brake in layout.formation.brakes])
    phases = phases_of(layout, demand, full.tolist())
    return Driver(layout, period, full=full, release_pressure=release_pressure, phases=phases, binding=binding)


def blank_phases(layout: Layout, count: int) -> Phases:
    """Return `count` phases without brake demand, traction and end."""
    phases = kernel(layout).records("Phase", count)
    for name, value in {"end": nan, "target": nan, "power": inf, "rate": inf}.items():
        phases[name] = value
    return phases


def phases_of(layout: Layout, demand: Demand, full: Sequence[float]) -> Phases:
    """Return the phases of a demand.

    Args:
        layout: Layout of the vehicle.
        demand: Table of the scenario.
        full: Pressure of full brake, shape (groups,) [Pa]; pressures are limited to it.

    Raises:
        ScenarioError: The demand gives pressures for another number of groups, or above the maximum of a brake.
    """
    if demand.file is not None:
        return _phases_of_profile(layout, demand, full, f"[demand] file {demand.file.entry}")
    phases, rate = blank_phases(layout, len(demand.phases)), inf
    for number, (row, phase) in enumerate(zip(phases, demand.phases, strict=True), start=1):
        if phase.until is not None:
            row["until"], row["end"] = _end(layout, phase.until.kind), phase.until.value
        if phase.pressure is not None:
            row["pressure"] = _of_groups(phase.pressure, full, f"[demand.phases[{number}]] pressure")
        if (aim := phase.stop_at) is not None:
            row["target"], row["deceleration"] = aim.distance, aim.deceleration
            row["full_deceleration"] = aim.full_deceleration
        if phase.traction is not None:
            rate = phase.traction.rate or inf  # also of the phases that follow, in which the force falls to 0
            row["force"], row["power"] = phase.traction.force, phase.traction.power or inf
        row["rate"] = rate
    return phases


def _end(layout: Layout, kind: str) -> int:
    return getattr(kernel(layout).functions, f"AT_{kind.upper()}")


def _phases_of_profile(layout: Layout, demand: Demand, full: Sequence[float], where: str) -> Phases:
    # Pressures are linear between points and constant outside.
    columns = demand.profile()
    times, pressures = columns.points, columns.values
    _require_pressures(pressures.shape[1], float(pressures.max()), full, where)
    pressures = np.minimum(pressures, full)
    phases = blank_phases(layout, len(times) + 1)
    phases["until"][:-1], phases["end"][:-1] = _end(layout, "time"), times
    phases["pressure"][0], phases["pressure"][1:] = pressures[0], pressures
    phases["begin"][1:-1] = times[:-1]
    phases["slope"][1:-1] = np.diff(pressures, axis=0) / np.diff(times)[:, None]
    return phases


def _of_groups(entries: Sequence[float | Literal["full"]], full: Sequence[float], where: str) -> list[float]:
    _require_pressures(len(entries), max((entry for entry in entries if entry != "full"), default=0.0), full, where)
    # One entry is for all groups.
    each = zip(cycle(entries), full, strict=False)
    return [most if entry == "full" else min(float(entry), most) for entry, most in each]


def _require_pressures(count: int, highest: float, full: Sequence[float], where: str) -> None:
    if count not in (1, len(full)):
        raise ScenarioError(f"{where} is for {count} groups, the vehicle has {len(full)}")
    if 0.0 < highest < _MIN_PRESSURE:
        raise ScenarioError(
            f"{where} is {highest:g} Pa at most, at which no brake acts (full brake is {max(full):g} Pa); state the "
            "unit: '3 bar' in a scenario, 'pressure [kPa]', [bar] or [psi] in the first line of a file"
        )
    if highest > max(full):
        raise ScenarioError(f"{where} asks for {highest:g} Pa, but full brake is {max(full):g} Pa; write 'full'")
