"""The table [demand]: the driver's demands of brakes and traction; without it full brake from the start."""

from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, Self, cast

from pydantic import Field, field_validator, model_validator

from railgrip.scenario.curve import TabulatedQuantity, read_columns
from railgrip.scenario.file import NamedFile
from railgrip.scenario.quantity import Number, UnitRange
from railgrip.scenario.table import Delay, Duration, Length, Speed, Table, optional, table_error
from railgrip.scenario.track.table import LARGEST_FORCE

_PRESSURE = UnitRange("Pa", at_least=0, at_most=1e8, because="pneumatics and hydraulics of brakes stay below 1000 bar")

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

    force: Annotated[
        float,
        UnitRange(
            "N", at_least=0, at_most=LARGEST_FORCE, or_zero=True, usual=(1e3, 1e6), because="trains are pulled with kN"
        ),
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


@lru_cache(maxsize=1)
def _read_profile(path: Path, digest: str) -> TabulatedQuantity:  # pyright: ignore[reportUnusedParameter]
    # Cached by digest, because the file is read for validation and for the stop.
    return read_columns(path, axes={"time": "s"}, name="pressure", si="Pa", span=(0.0, 1e8), example="kPa")
