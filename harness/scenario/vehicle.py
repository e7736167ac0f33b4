"""The tables [vehicle] and [start]: which plant, with what values, from what speed."""

from typing import Any

from pydantic import Field, StrictBool, ValidationInfo, field_serializer, field_validator

from harness.scenario.file import NamedFile
from harness.scenario.table import WHEELSETS, Length, Parameters, Speed, Table, broken, scalars


class MappedVariable(Table):
    """A variable of a foreign FMU: its name there and, where the FMU does not declare it, its unit."""

    variable: str
    unit: str | None = Field(default=None, description="the FMU's unit, only if the FMU itself declares none")


Mapping = dict[str, MappedVariable]


class NameMap(Table):
    """Our name → the FMU's variable, for plants whose names are not ours."""

    inputs: Mapping = Field(default={}, description="what the plant is given")
    outputs: Mapping = Field(default={}, description="what it answers")
    parameters: Mapping = Field(default={}, description="what [vehicle.parameters] sets")

    @field_validator("inputs", "outputs", "parameters", mode="before")
    @classmethod
    def _short_form(cls, written: Any) -> Any:
        """Let `"speed" = "train.v"` mean `"speed" = { variable = "train.v" }`."""
        if not isinstance(written, dict):
            return written
        return {
            ours: {"variable": theirs} if isinstance(theirs, str) else theirs
            for ours, theirs in written.items()
        }


class Vehicle(Table):
    """The plant."""

    plant: str | NamedFile = Field(
        description="an FMU recipe of this project, or the path of an .fmu from the scenario's folder"
    )
    parameters: Parameters = Field(
        default={}, description="the plant's parameters that differ from its own values"
    )
    map: NameMap = Field(default=NameMap(), description="our name → variable of a foreign FMU")
    isolate: StrictBool = Field(default=False, description="run the FMU in a process of its own")
    wheelset_offsets: tuple[Length, ...] = Field(
        default=(),
        description="distance of each wheelset behind the first; wanted when adhesion is over distance",
    )

    _flat = field_validator("parameters", mode="before")(scalars)

    @field_validator("plant", mode="plain")
    @classmethod
    def _recipe_or_file(cls, written: Any, info: ValidationInfo) -> str | NamedFile:
        if isinstance(written, NamedFile) or (isinstance(written, str) and written.endswith(".fmu")):
            return NamedFile.find(written, info)
        if not isinstance(written, str) or not written.isidentifier():
            raise broken(
                f"is {written!r}, which is neither the name of an FMU recipe nor the path of an .fmu"
            )
        return written

    @field_serializer("plant")
    def _as_written(self, plant: str | NamedFile) -> str:
        return plant.written if isinstance(plant, NamedFile) else plant

    @field_validator("wheelset_offsets")
    @classmethod
    def _six_in_order(cls, offsets: tuple[float, ...]) -> tuple[float, ...]:
        if offsets and (len(offsets) != WHEELSETS or offsets[0] != 0 or list(offsets) != sorted(offsets)):
            raise broken(f"must be {WHEELSETS} rising distances that start with 0, got {list(offsets)}")
        return offsets


class Start(Table):
    """The state at the brake demand, t = 0."""

    speed: Speed
