"""[data]: which column of a user's file is which signal of the model, in which unit, and how to treat what is wrong.

[data]
time = { column = "t", unit = "ms" }        # unit = "timestamp" for dates with times of day
period = "10 ms"                            # of the even grid that the filter steps on
longest_gap = "100 ms"                      # missing samples are bridged up to here
frozen = "1 s"                              # a reading that repeats itself exactly for longer has died
spike = 8.0                                 # deviations from its neighbours that make a sample an outlier
separator = ";"                             # csv only, as is decimal = ","; both are found unless given

[data.columns]
speed = { column = "v_gps", unit = "km/h" }
"wheelset_speed[1]" = { column = "n1", unit = "rev/min", range = ["0 rad/s", "120 rad/s"] }
"cylinder_pressure[1]" = { column = "pC1", unit = "bar", offset = -1.013 }     # was absolute
track_force = { value = "0 N" }             # not measured, this value throughout
"""

from typing import Annotated, Literal, Self

from pydantic import Field, StrictBool, model_validator

from railgrip.scenario.quantity import Magnitude, Unit
from railgrip.scenario.table import Period, Table, broken

Time = Annotated[float, Unit("s", above=0, at_most=1e5, because="no recording of a braking lasts a day")]
Number = Annotated[float, Field(allow_inf_nan=False)]


class TimeColumn(Table):
    """Where the instants stand."""

    column: str = Field(description="name of the column; mf4 files bring their own time and may write 'time'")
    unit: str | None = Field(
        default=None, description="unit of the column, or 'timestamp'; may be left out where the header states it"
    )


class Column(Table):
    """One signal: a column of the file, or a constant value."""

    column: str | None = Field(default=None, description="name of the column")
    unit: str | None = Field(
        default=None, description="of the column; may be left out where the header or the file states it"
    )
    factor: Number = Field(default=1.0, description="of the column's numbers")
    offset: Number = Field(default=0.0, description="added after the factor, in the column's unit")
    range: tuple[Magnitude, Magnitude] | None = Field(default=None, description="samples outside are left out")
    holds: StrictBool = Field(default=False, description="repeats its last value until a new one comes")
    may_rest: StrictBool = Field(default=False, description="standing still exactly is normal for this signal")
    value: Magnitude | None = Field(default=None, description="instead of a column: this value throughout")

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.column is None) == (self.value is None):
            raise broken("wants either column or value")
        return self


class DataTable(Table):
    """The column map and how to treat what is wrong."""

    time: TimeColumn
    period: Period = Field(description="of the even grid that the filter steps on")
    longest_gap: Time = Field(description="missing samples are bridged up to here")
    frozen: Time = Field(description="a reading that repeats itself exactly for longer has died")
    spike: Annotated[float, Field(gt=2.0, allow_inf_nan=False)] = Field(
        description="deviations from its neighbours that make a sample an outlier"
    )
    begin: Annotated[float, Unit("s")] | None = Field(default=None, description="cut, on the file's own axis")
    end: Annotated[float, Unit("s")] | None = Field(default=None, description="likewise")
    separator: Annotated[str, Field(min_length=1, max_length=1)] | None = Field(
        default=None, description="of a csv file; found unless given"
    )
    decimal: Literal[".", ","] | None = Field(default=None, description="likewise")
    columns: dict[str, Column] = Field(description="by the name of the signal of the model")
