"""Recipes of FMUs: recipes.toml as validated values."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from railgrip.base.errors import InputError
from railgrip.base.names import did_you_mean
from railgrip.fmus.native.library import MODELICA

RECIPES = Path(__file__).with_name("recipes.toml")

FmiType = Literal["me", "cs", "me_cs"]
"""Interfaces of the FMU of a user's class: a prediction by Model Exchange, a plant, or a prediction by both."""


class Recipe(BaseModel):
    """Recipe of one FMU.

    Attributes:
        class_name: Modelica class, `class` in the file.
        interfaces: "me", "cs" or both.
        solver: Solver of co-simulation, in the built-in compiler.
        tolerance: Relative error of an internal step.
        step: Communication step that the FMU suggests [s].
        curve: Whether the class has the parameter `curve`, which becomes an input on a rail with several creep curves.
        restarts: Whether its co-simulation is the prediction of a filter, whose steps begin in a saved state and are
            differentiated.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    class_name: str = Field(alias="class")
    interfaces: tuple[Literal["me", "cs"], ...] = Field(min_length=1)
    solver: Literal["rodas3", "rodas4"]
    tolerance: float = Field(gt=0, lt=1)
    step: float = Field(gt=0)
    curve: bool = False
    restarts: bool = False

    @classmethod
    def of_class(cls, class_name: str, interface: FmiType) -> "Recipe":
        """Return the recipe of a user's class: a plant (cs) or a prediction (me, me_cs), like those of railgrip."""
        solver, tolerance = ("rodas3", 1e-5) if interface == "cs" else ("rodas4", 1e-6)
        table = {"class": class_name, "interfaces": interface.split("_"), "solver": solver, "tolerance": tolerance}
        return cls.model_validate(table | {"step": 1e-3, "restarts": interface == "me_cs"})

    @property
    def library(self) -> Path:
        """Folder of the Modelica library that the class belongs to."""
        return MODELICA / self.class_name.partition(".")[0]


@dataclass(frozen=True, slots=True)
class Cookbook:
    """The recipes of one file, by name."""

    file: Path
    recipes: Mapping[str, Recipe]

    def __getitem__(self, name: str) -> Recipe:
        """Return a recipe.

        Raises:
            InputError: The file has no recipe with that name.
        """
        if name not in self.recipes:
            hint = did_you_mean(name, self.recipes, quote="", before="; ") or f"; it has {', '.join(self.recipes)}."
            raise InputError(f"{self.file} has no FMU named '{name}'{hint}")
        return self.recipes[name]


def read_recipes(file: Path = RECIPES) -> Cookbook:
    """Return the recipes of a file.

    Raises:
        InputError: The file is missing, is not TOML, or has an unknown key or an invalid value.
    """
    try:
        tables = tomllib.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError(f"there is no file {file}.") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{file} is not TOML: {error}.") from error
    recipes: dict[str, Recipe] = {}
    keys = [field.alias or key for key, field in Recipe.model_fields.items()]
    for name, table in tables.items():
        for key in table if isinstance(table, dict) else ():
            if key not in keys:
                raise InputError(f"{file}: [{name}] has no key '{key}'; it has {', '.join(keys)}.")
        try:
            recipes[name] = Recipe.model_validate(table)
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"])
            raise InputError(f"{file}: [{name}] {where}: {first['msg']}, got {first['input']!r}.") from error
    return Cookbook(file=file, recipes=recipes)
