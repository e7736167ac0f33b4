"""[data]: which column of a user's file is which signal of the model, in which unit, and how errors are treated.

[data]
time = { column = "t", unit = "ms" }        # unit = "timestamp" for dates with times of day, "hhmmss" for these alone
period = "10 ms"                            # of the even grid that the filter steps on
longest_gap = "100 ms"                      # missing samples are bridged up to here
frozen = "1 s"                              # a reading that repeats itself exactly for longer has died
spike = 8.0                                 # deviations from its neighbours that make a sample an outlier
separator = ";"                             # csv only, as is decimal = ","; both are found unless given

[data.columns]
speed = { column = "v_gps", unit = "km/h" }
"wheelset_speed[1]" = { column = "n1", unit = "rev/min", range = ["0 rad/s", "120 rad/s"] }
"cylinder_pressure[1]" = { column = "pC1", unit = "bar", offset = -1.013 }     # was absolute
pad_force = { column = "p1", unit = "bar", factor = "8 kN/bar", offset = -4.0, minimum = "0 N" }   # offset [kN]
track_force = { value = "0 N" }             # not measured, this value throughout
"""

from typing import Annotated, Literal

from pydantic import Field, StrictBool, StrictInt, field_validator

from railgrip.base import units
from railgrip.base.errors import UnitError
from railgrip.base.names import state_name
from railgrip.base.units import conversion, quantity, turning_of, unit
from railgrip.scenario.quantity import Magnitude, Number, UnitRange
from railgrip.scenario.table import Period, Table, table_error

TRUTH = "true_"
"""Prefix of columns with a true state."""

Time = Annotated[float, UnitRange("s", above=0, at_most=1e5, because="no recording of a braking lasts a day")]


class TimeColumn(Table):
    """The column of the instants."""

    column: str = Field(description="name of the column; mf4 files bring their own time and may write 'time'")
    unit: str | None = Field(
        default=None,
        description="unit of the column, 'timestamp' for dates, or 'hhmmss' for times of day such as 130540.25; may be "
        "left out where the header states it",
    )
    order: Literal["day first", "month first"] | None = Field(
        default=None, description="of dates such as 04/01/2025; dates with dots are day first"
    )
    repeats: Literal["drop", "spread"] = Field(
        default="drop",
        description="rows with the instant of the row above: left out, or spread evenly up to the next instant, for "
        "stamps that were cut to seconds",
    )


def channel_label(name: str, group: int | None, index: int | None) -> str:
    """Return the name of a channel with its group and index, if they are given."""
    place = [f"{what} {number}" for what, number in (("group", group), ("index", index)) if number is not None]
    return f"{name} ({', '.join(place)})" if place else name


class Column(Table):
    """One signal: a column of the file, or a constant value."""

    column: str | None = Field(default=None, description="name of the column")
    unit: str | None = Field(
        default=None, description="of the column; may be left out where the header or the file states it"
    )
    factor: Magnitude = Field(
        default=Magnitude(1.0),
        description="of the column's numbers; with a unit, '8 kN/bar', it turns the column into another quantity",
    )
    offset: Number = Field(
        default=0.0, description="added after the factor, in the column's unit times that of the factor"
    )
    minimum: Magnitude | None = Field(
        default=None, description="smaller values become this, as the force of pads below the force of their spring"
    )
    range: tuple[Magnitude, Magnitude] | None = Field(default=None, description="samples outside are left out")
    holds: StrictBool = Field(default=False, description="repeats its last value until a new one comes")
    may_rest: StrictBool = Field(default=False, description="standing still exactly is normal for this signal")
    group: Annotated[StrictInt, Field(ge=0)] | None = Field(
        default=None, description="channel group of a name that occurs several times in an mf4 or mdf file"
    )
    index: Annotated[StrictInt, Field(ge=0)] | None = Field(
        default=None, description="index in that group of a name that occurs several times in it"
    )
    value: Magnitude | None = Field(default=None, description="instead of a column: this value throughout")

    def _check(self) -> None:
        if (self.column is None) == (self.value is None):
            raise table_error("needs either column or value")
        if self.index is not None and self.group is None:
            raise table_error("has an index without a group")

    @property
    def label(self) -> str:
        """Name of the column in the file, with group and index if they are given."""
        return channel_label(self.column or "", self.group, self.index)

    def expected_unit(self, target: str) -> units.Unit:
        """Return a unit of the dimension that the column must have, which times the factor gives `target`."""
        factor = self.factor.entry
        return unit(target) / quantity(factor)[1] if isinstance(factor, str) else unit(target)

    def conversion(self, source: units.Unit, target: str) -> tuple[float, float]:
        """Return (gain, shift) so that a signal in `target` = gain · number in the column + shift.

        Args:
            source: Unit of the column.
            target: Unit of the signal.

        Raises:
            UnitError: Column times factor has another dimension than the signal, or a factor with a unit multiplies
                degrees Celsius or Fahrenheit.
        """
        factor, wanted, times = self.factor.entry, self.expected_unit(target), ""
        number = float(factor) if not isinstance(factor, str) else quantity(factor)[0]
        if isinstance(factor, str):
            times = f" times factor '{factor}'"
            if source.offset:
                raise UnitError(f"'{source.name}'{times} depends on where the scale begins; write unit = 'K'.")
        try:
            gain, shift = conversion(source, wanted)
        except UnitError as problem:
            if turning_of(source, wanted):
                raise
            raise UnitError(
                f"'{source.name}' ({source.dimension}){times} cannot become '{target}' ({unit(target).dimension}); "
                f"map another column, or {factor_for(source, target)}."
            ) from problem
        return gain * number, gain * self.offset + shift


def factor_for(source: units.Unit, target: str) -> str:
    """Return how to write the factor that turns a column into another quantity, to end a sentence with."""
    ratio = unit(target) / source
    if ratio.dimension == "1":
        return "write the factor without a unit"
    return f"write a factor with its unit, such as factor = '2.5 {ratio.name}'"


class DataTable(Table):
    """The column map and the treatment of errors."""

    time: TimeColumn
    period: Period = Field(description="of the even grid that the filter steps on")
    longest_gap: Time = Field(description="missing samples are bridged up to here")
    frozen: Time = Field(description="a reading that repeats itself exactly for longer has died")
    spike: Annotated[float, Field(gt=2.0, allow_inf_nan=False)] = Field(
        description="deviations from its neighbours that make a sample an outlier"
    )
    begin: Annotated[float, UnitRange("s")] | None = Field(default=None, description="cut, on the file's own axis")
    end: Annotated[float, UnitRange("s")] | None = Field(default=None, description="likewise")
    separator: Annotated[str, Field(min_length=1, max_length=1)] | None = Field(
        default=None, description="of a csv file; found unless given"
    )
    decimal: Literal[".", ","] | None = Field(default=None, description="likewise")
    blank: Literal["unchanged", "missing"] | None = Field(
        default=None,
        description="meaning of blank cells of a table: the value above them, for logs of changes, or no sample",
    )
    contradictions: Literal["refuse", "warn"] = Field(
        default="refuse", description="signals that contradict each other as on no vehicle are refused or only reported"
    )
    columns: dict[str, Column] = Field(description="by the name of the signal of the model")

    @field_validator("columns")
    @classmethod
    def _by_name(cls, columns: dict[str, Column]) -> dict[str, Column]:
        # Older files have symbols of states, as in true_mu_b.
        names = {
            name: f"{TRUTH}{state_name(name.removeprefix(TRUTH))}" if name.startswith(TRUTH) else name
            for name in columns
        }
        if twice := [name for name, now in names.items() if now != name and now in columns]:
            raise table_error(f"has {twice[0]} and {names[twice[0]]}, which are the same state; keep the latter")
        return {names[name]: column for name, column in columns.items()}
