"""The tables [vehicle] and [start]: the plant, its parameters, and the initial speed."""

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import (
    Field,
    PlainSerializer,
    PlainValidator,
    StrictBool,
    StrictInt,
    ValidationInfo,
    field_serializer,
    field_validator,
)
from pydantic_core import PydanticCustomError

from railgrip.base.registry import not_one_of, shelf
from railgrip.scenario.file import NamedFile
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.table import (
    Length,
    MapEntry,
    ModelicaClass,
    Parameters,
    Seed,
    StartSpeed,
    Table,
    optional,
    table_error,
)

_Wheelsets = Annotated[StrictInt, Field(ge=1, le=64)]


class FormationTable(Table):
    """Components of a plant that does not declare them; empty for those that it declares, or that are not required."""

    wheelsets_per_group: tuple[_Wheelsets, ...] = Field(
        default=(),
        max_length=256,
        description="number of wheelsets of each group that turns as one and shares a brake, leading group first",
    )
    wheelsets_per_car: tuple[_Wheelsets, ...] = Field(
        default=(),
        max_length=256,
        description="number of wheelsets of each car, leading car first; of a bogie under two cars each has its share",
    )
    groups_per_valve: tuple[_Wheelsets, ...] = optional(
        "number of groups that share each brake valve, leading one first; one each where it is left out",
        default=(),
        max_length=256,
    )
    wheelset_position: tuple[Length, ...] = Field(
        default=(),
        description="distance of each wheelset from the leading one; required when adhesion depends on distance",
    )
    wheelset_load: tuple[Annotated[float, UnitRange("N", above=0, at_most=1e6)], ...] = Field(
        default=(), description="static force of each wheelset on the rail"
    )
    track_brakes: Annotated[float, UnitRange("N", between=(0, 1e7))] = optional(
        "greatest force of brakes that act on the rail itself, magnetic or eddy current; train files have it",
        default=0.0,
    )
    brakes: Parameters = Field(
        default={},
        description="p_max, n_units, r_friction, r_wheel, J, A_piston, i_rigging, eta_rigging, F_spring, "
        "for all or each group; T_fill, T_vent, dead_fill, dead_vent of the valves",
    )


class Nudge(Table):
    """Random perturbation of every real parameter of the plant, which reveals the conditioning of a distance."""

    relative: Annotated[float, UnitRange("1", above=0, at_most=1e-2)] = Field(
        description="most that a parameter moves by, as a share of its value"
    )
    seed: Seed = Field(description="of what each parameter moves by")


def _is_class(entry: str) -> bool:
    # Only the module must be identifiers: Python writes `<locals>` in the name of a class inside a function.
    module, colon, name = entry.partition(":")
    return bool(colon and name) and all(part.isidentifier() for part in module.split("."))


@dataclass(frozen=True, slots=True)
class RecipePlant:
    """A built-in plant, by the name of its FMU recipe."""

    name: str


@dataclass(frozen=True, slots=True)
class TrainFile:
    """A built-in train or a train file, from which a Modelica class is generated."""

    file: NamedFile


@dataclass(frozen=True, slots=True)
class LibraryClass:
    """A user's Modelica class, by its full name, and its library."""

    name: str
    library: NamedFile


@dataclass(frozen=True, slots=True)
class FmuFile:
    """A foreign FMU."""

    file: NamedFile


@dataclass(frozen=True, slots=True)
class PythonClass:
    """A user's class in Python, module:Class."""

    name: str


LibraryPlant = RecipePlant | TrainFile
"""Plants of the library RailBraking only: their physics, such as mass and creep law, is known."""
ModelicaPlant = LibraryPlant | LibraryClass
"""Plants from Modelica: their code is trusted, and their parameters have the names of the library."""
Source = ModelicaPlant | FmuFile | PythonClass
"""Source of a plant."""


def find_train(entry: Any, info: ValidationInfo) -> NamedFile | None:
    """Return the file of a train: of this project by its name, or of the user by its path."""
    if isinstance(entry, str) and (path := shelf("trains").get(entry)):
        return NamedFile(entry=entry, path=path)
    try:
        return None if entry is None else NamedFile.find(entry, info)
    except PydanticCustomError:
        if isinstance(entry, str) and entry.isidentifier():  # a name, not a path
            raise table_error(f"is '{entry}': {not_one_of('trains', entry)}") from None
        raise


TrainName = Annotated[
    NamedFile | None,
    PlainValidator(find_train, json_schema_input_type=str),
    PlainSerializer(lambda train: train and train.entry, when_used="json"),
]
"""Annotation of a train, by its name in this project or by the path of its file."""


class Vehicle(Table):
    """The plant."""

    plant: str | NamedFile | None = optional(
        "an FMU recipe of this project, the path of an .fmu from the scenario's folder, or module:Class"
    )
    model: ModelicaClass | None = optional("in place of `plant`: a user-defined Modelica class, full name")
    library: NamedFile | None = optional("the package.mo of its library, or its .mo file")
    train: TrainName = optional(
        "in place of `plant`: a train of this project, such as emu387, or the path of a train file"
    )
    parameters: Parameters = Field(default={}, description="the plant's parameters that differ from its own values")
    map: dict[str, MapEntry] = Field(
        default={}, description="our name → variable of a foreign FMU: text with {i} for arrays, list, or table"
    )
    trust: StrictBool = Field(
        default=False, description="load your FMU into this process: faster, but a crash in it ends the run"
    )
    formation: FormationTable | None = Field(
        default=None, description="of a plant that does not declare coupling and positions of its wheelsets"
    )
    nudge: Nudge | None = Field(default=None, description="moves all real parameters of the plant a little")

    @field_validator("plant", mode="plain", json_schema_input_type=str)
    @classmethod
    def _recipe_or_file(cls, entry: Any, info: ValidationInfo) -> str | NamedFile | None:
        if entry is None:
            return None
        if isinstance(entry, NamedFile) or (isinstance(entry, str) and entry.lower().endswith((".fmu", ".ssp"))):
            return NamedFile.find(entry, info)
        if not isinstance(entry, str) or not (entry.isidentifier() or _is_class(entry)):
            raise table_error(
                f"is {entry!r}, which is neither the name of an FMU recipe nor the path of an .fmu nor module:Class"
            )
        return str(entry)

    @field_serializer("plant", when_used="json")
    def _as_written(self, plant: str | NamedFile | None) -> str | None:
        return plant.entry if isinstance(plant, NamedFile) else plant

    def _check(self) -> None:
        if (self.model is None) != (self.library is None):
            raise table_error("a user's Modelica class needs both 'model' and the 'library' that contains it")
        plants = sum(source is not None for source in (self.plant, self.model, self.train))
        if plants != 1:
            wrong = "has two plants" if plants else "has no plant"
            raise table_error(f"{wrong}; give 'plant', or 'model' and 'library' of your Modelica class, or 'train'")

    @property
    def source(self) -> Source:
        """Source of the plant."""
        if self.train is not None:
            return TrainFile(self.train)
        if self.model is not None and self.library is not None:
            return LibraryClass(self.model, self.library)
        if isinstance(self.plant, NamedFile):
            return FmuFile(self.plant)
        assert self.plant is not None  # `_check` rejects a table without a plant
        return PythonClass(self.plant) if _is_class(self.plant) else RecipePlant(self.plant)


class Start(Table):
    """The state at t = 0, the time of the brake demand unless [demand] delays it."""

    speed: StartSpeed = Field(description="initial speed; a train at rest (0) needs traction in [demand]")
