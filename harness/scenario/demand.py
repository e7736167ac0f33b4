"""The table [demand]: the driver's demands of brakes and traction; without it full brake from the start."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from itertools import cycle
from math import inf, nan
from pathlib import Path
from typing import Annotated, Any, Literal, Self, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from railgrip.base.errors import ScenarioError
from railgrip.scenario.curve import TabulatedQuantity, read_columns
from railgrip.scenario.file import NamedFile
from railgrip.scenario.quantity import Number, UnitRange
from railgrip.scenario.table import Delay, Duration, Length, Speed, Table, optional, table_error
from railgrip.scenario.track.table import LARGEST_FORCE

_PRESSURE = UnitRange("Pa", at_least=0, at_most=1e8, because="pneumatics and hydraulics of brakes stay below 1000 bar")

_Pressure = Annotated[float, _PRESSURE] | Literal["full"]

Deceleration = Annotated[
    float, UnitRange("m/s2", above=0, at_most=10, because="no wheel on a rail brakes by more than 1 g")
]


class PhaseEnd(Table):
    """The condition that ends a phase: exactly one key."""

    time: Delay | None = optional("since the start")
    duration: Duration | None = optional("of the phase")
    distance: Length | None = optional("travelled since the start")
    speed_below: Speed | None = optional("the train has no more than this")
    speed_above: Speed | None = optional("the train has this, or more")

    @model_validator(mode="after")
    def _one(self) -> Self:
        if len(self.model_fields_set) != 1:
            raise table_error(
                f"needs exactly one of {', '.join(type(self).model_fields)}, got {len(self.model_fields_set)}"
            )
        return self

    @property
    def kind(self) -> Literal["time", "duration", "distance", "speed_below", "speed_above"]:
        """Key of the condition."""
        return cast("Any", next(iter(self.model_fields_set)))

    @property
    def limit(self) -> float:
        """Value of the condition [s, m or m/s]."""
        return getattr(self, self.kind)


class Traction(Table):
    """A force that pushes the whole train, like the track force; it does not load the wheelsets."""

    force: Annotated[float, UnitRange("N", at_least=0, at_most=LARGEST_FORCE)] = Field(description="most, forward")
    power: Annotated[float, UnitRange("W", above=0, at_most=1e9)] | None = optional("its maximum, if it is limited")
    rate: Annotated[float, UnitRange("N/s", above=0, at_most=1e9)] | None = optional(
        "most that the force changes by, also after the end of the phase; at once where there is none"
    )


class StopAt(Table):
    """A driver who stops at a target on a braking curve of constant deceleration."""

    distance: Annotated[float, UnitRange("m", above=0, at_most=1e5)] = Field(description="of the target from the start")
    deceleration: Deceleration = Field(description="of the curve; before it there is no demand")
    full_deceleration: Deceleration = Field(description="that the driver expects of full brake")

    @model_validator(mode="after")
    def _check_phases(self) -> Self:
        if self.deceleration > self.full_deceleration:
            raise table_error(
                f"deceleration {self.deceleration:g} m/s2 is above full_deceleration {self.full_deceleration:g} m/s2, "
                "the most that the driver expects of the brakes"
            )
        return self


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

    @model_validator(mode="after")
    def _one_demand(self) -> Self:
        if (self.pressure is None) == (self.stop_at is None):
            wrong = "has neither" if self.pressure is None else "has both,"
            raise table_error(f"{wrong} pressure and stop_at; give one of them, pressure = 0 where nothing is braked")
        return self


class Demand(Table):
    """The driver's demands: phases in their order, or a profile over time in a file."""

    phases: tuple[Phase, ...] = optional("demands, one after the other", default=())
    file: NamedFile | None = optional(
        "a CSV with columns time, and pressure or pressure_1 … pressure_n; in s and Pa, or in stated units"
    )

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if bool(self.phases) == (self.file is not None):
            raise table_error("needs either phases or the file of a profile")
        for number, phase in enumerate(self.phases, start=1):
            if (phase.until is None) != (number == len(self.phases)):
                wrong = "is the last one and lasts to the end, leave out" if phase.until else "has no"
                raise table_error(f"phases[{number}] {wrong} 'until'")
        if self.file is not None:
            self.profile()
        return self

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
        assert self.file is not None
        try:
            return _read_profile(self.file.path, self.file.digest())
        except ValueError as problem:
            raise table_error(f"file {self.file.entry}: {problem}") from problem


_FAINTEST = 1e3
"""Smallest plausible pressure of a brake cylinder [Pa]: pads touch at some 0.2 bar."""


@lru_cache(maxsize=1)
def _read_profile(path: Path, digest: str) -> TabulatedQuantity:  # pyright: ignore[reportUnusedParameter]
    # Cached by digest, because the file is read for validation and for the stop.
    return read_columns(path, axes={"time": "s"}, name="pressure", si="Pa", span=(0.0, 1e8), example="kPa")


EndOfPhase = Literal["end", "time", "duration", "distance", "speed_below", "speed_above"]
"""Event that ends a phase, named as in the enum of the loop's driver.h; the last phase has no end."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DemandedPhase:
    """A phase in numbers.

    Attributes:
        until: Event that ends the phase.
        limit: Time or duration [s], distance [m] or speed [m/s] that ends it.
        begin: Time from which pressures change by their slopes [s].
        pressures: Brake cylinder pressure of each group at `begin` [Pa].
        slopes: Their change [Pa/s].
        target: Distance at which to stop [m]; NaN brakes by the pressures.
        deceleration: Deceleration of the braking curve to the target [m/s²].
        full_deceleration: Deceleration that the driver expects of full brake [m/s²].
        force: Maximum force of the traction [N].
        power: Maximum power of the traction [W]; may be infinite.
        rate: Maximum rate of change of the force [N/s]; may be infinite.
    """

    until: EndOfPhase = "end"
    limit: float = nan
    begin: float = 0.0
    pressures: tuple[float, ...]
    slopes: tuple[float, ...]
    target: float = nan
    deceleration: float = nan
    full_deceleration: float = nan
    force: float = 0.0
    power: float = inf
    rate: float = inf


def phases_of(demand: Demand, full: Sequence[float], origin: str) -> tuple[DemandedPhase, ...] | NDArray[np.void]:
    """Return the phases of a demand on brakes whose full pressures are `full`, shape (groups,) [Pa].

    Those of a file, which may have a million rows, are an array with the fields of `DemandedPhase`.

    Args:
        full: Full pressure of each group.
        origin: Name of the scenario, the opening word of messages.

    Raises:
        ScenarioError: The demand gives pressures for another number of groups, or above the maximum of a brake.
    """
    if demand.file is None:
        return tuple(_convert_phases(demand, full, f"{origin}: [demand.phases"))
    columns = demand.profile()
    times, pressures = columns.points, columns.values
    _require_pressures(pressures.shape[1], float(pressures.max()), full, f"{origin}: [demand] file {demand.file.entry}")
    return _from_points(times, np.minimum(pressures, full))


def _convert_phases(demand: Demand, full: Sequence[float], where: str) -> Iterator[DemandedPhase]:
    none, rate = (0.0,) * len(full), inf
    for number, phase in enumerate(demand.phases, start=1):
        pressures, target = none, {}
        if phase.pressure is not None:
            pressures = _of_groups(phase.pressure, full, f"{where}[{number}]] pressure")
        if phase.stop_at is not None:
            aim = phase.stop_at
            target = {"target": aim.distance, "deceleration": aim.deceleration}
            target |= {"full_deceleration": aim.full_deceleration}
        if phase.traction is not None:
            rate = phase.traction.rate or inf
        yield DemandedPhase(
            until=phase.until.kind if phase.until else "end",
            limit=phase.until.limit if phase.until else nan,
            pressures=pressures,
            slopes=none,
            force=phase.traction.force if phase.traction else 0.0,
            power=(phase.traction.power or inf) if phase.traction else inf,
            rate=rate,
            **target,
        )


def _from_points(times: NDArray[np.float64], pressures: NDArray[np.float64]) -> NDArray[np.void]:
    # Pressures are linear between points and constant outside.
    none = (0.0,) * pressures.shape[1]
    constant = DemandedPhase(pressures=none, slopes=none)
    names = [field.name for field in fields(DemandedPhase)]
    kinds = {"until": "U13"} | dict.fromkeys(("pressures", "slopes"), f"({len(none)},)f8")
    phases = np.full(
        len(times) + 1,
        np.array(tuple(getattr(constant, name) for name in names), dtype=[(n, kinds.get(n, "f8")) for n in names]),
    )
    phases["until"][:-1], phases["limit"][:-1] = "time", times
    phases["pressures"][0], phases["pressures"][1:] = pressures[0], pressures
    phases["begin"][1:-1] = times[:-1]
    phases["slopes"][1:-1] = np.diff(pressures, axis=0) / np.diff(times)[:, None]
    return phases


def _of_groups(entries: Sequence[float | Literal["full"]], full: Sequence[float], where: str) -> tuple[float, ...]:
    _require_pressures(len(entries), max((entry for entry in entries if entry != "full"), default=0.0), full, where)
    pressures = [most if entry == "full" else float(entry) for entry, most in zip(cycle(entries), full, strict=False)]
    return tuple(map(min, pressures, full))


def _require_pressures(count: int, highest: float, full: Sequence[float], where: str) -> None:
    if count not in (1, len(full)):
        raise ScenarioError(f"{where} is for {count} groups, the vehicle has {len(full)}")
    if 0.0 < highest < _FAINTEST:
        raise ScenarioError(
            f"{where} is {highest:g} Pa at most, at which no brake acts (full brake is {max(full):g} Pa); state the "
            "unit: '3 bar' in a scenario, 'pressure [kPa]', [bar] or [psi] in the first line of a file"
        )
    if highest > max(full):
        raise ScenarioError(f"{where} asks for {highest:g} Pa, full brake is {max(full):g} Pa; write 'full'")
