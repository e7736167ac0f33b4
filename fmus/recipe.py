"""Recipes of FMUs: recipes.toml as validated values, and lock.toml.

lock.toml has the interfaces and digests of all FMUs, so that a change of the models is visible in review.
"""

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from railgrip.base.errors import InputError
from railgrip.base.names import did_you_mean
from railgrip.base.tables import JsonObject
from railgrip.fmus.native.library import MODELICA

if TYPE_CHECKING:
    from railgrip.fmus.native.system import System
    from railgrip.fmus.native.variables import Scalar

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


LOCK = Path(__file__).with_name("lock.toml")

Entry = JsonObject


def interface_of(recipe: Recipe, system: "System", digest: str) -> Entry:
    """Return the entry of an FMU in lock.toml.

    Keys: class; digest of C code and XML; states, inputs, outputs as name = unit; nonlinear_loops as lists of
    their unknowns; parameters (public ones), event_indicators, time_events, clocks, discretes, assertions as counts;
    compiled_in as name = value of the class's own Integer and Boolean parameters, which no parameter decides.
    """
    # CasADi takes half a second to import; recipes are read without it.
    from railgrip.fmus.native.code import groups_of
    from railgrip.fmus.native.equations import output_scalars

    groups = groups_of(system)
    every = (s for scalars in system.variables.of_id.values() for s in scalars)
    compiled_in = [
        s
        for s in every
        if s.kind == "parameter"
        and s.type != "real"
        and "." not in s.name
        and not s.protected
        and s.binding.is_constant()
    ]
    return {
        "class": recipe.class_name,
        "digest": digest,
        "parameters": sum(not p.protected for p in system.variables.free),
        "discretes": len(groups["discretes"]),
        "event_indicators": system.indicators.numel(),
        "time_events": system.instants.numel(),
        "clocks": len(system.clocks),
        "assertions": len(system.assertions),
        "nonlinear_loops": [list(block) for block in system.loops.blocks],
        "states": _units(groups["states"]),
        "inputs": _units(groups["inputs"]),
        "outputs": _units(output_scalars(system)),
        "compiled_in": {s.name: bool(s.start) if s.type == "boolean" else int(s.start) for s in compiled_in},
    }


def _units(scalars: "list[Scalar]") -> dict[str, str]:
    return {s.name: s.attributes.get("unit") or "" for s in scalars}


def read_lock(file: Path = LOCK) -> Mapping[str, Entry]:
    """Return the entries of a lock file by FMU, and `tools`; empty without a file."""
    return tomllib.loads(file.read_text(encoding="utf-8")) if file.exists() else {}


def write_lock(book: Cookbook, entries: Mapping[str, Entry], file: Path = LOCK) -> None:
    """Write a lock file."""
    lines = [
        "# Written by `railgrip build --check --update`; a change here is a change of the models' faces.",
        "",
        "[tools]",
    ]
    lines += [f"{tool} = {_toml(version(tool))}" for tool in ("rumoca", "casadi")]
    for name in book.recipes:
        lines += ["", f"[{name}]"]
        tables: list[str] = []
        for key, value in entries[name].items():
            if isinstance(value, dict):
                tables += ["", f"[{name}.{key}]", *(f"{_toml(k)} = {_toml(v)}" for k, v in value.items())]
            else:
                lines.append(f"{key} = {_toml(value)}")
        lines += tables
    file.write_text("\n".join([*lines, ""]), encoding="utf-8")


def _toml(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)  # of texts, numbers and lists of them the same in TOML


def differences(name: str, lock: Mapping[str, Entry], entry: Entry) -> list[str]:
    """Return the differences from the lock file.

    The digest is compared only under the same tool versions: another version of CasADi may write other C code.
    """
    if name not in lock:
        return ["is not in lock.toml"]
    same_tools = all(lock.get("tools", {}).get(tool) == version(tool) for tool in ("rumoca", "casadi"))
    out: list[str] = []
    for key, value in entry.items():
        before = lock[name].get(key)
        if before == value or (key == "digest" and not same_tools):
            continue
        if isinstance(value, dict) and isinstance(before, dict):
            for k in [*before, *(k for k in value if k not in before)]:
                if before.get(k) != value.get(k):
                    out.append(f"{key}: {k} was {before.get(k)!r}, is {value.get(k)!r}")
            if list(before) != list(value) and not out:
                out.append(f"{key}: the order has changed")
        else:
            out.append(f"{key} was {before!r}, is {value!r}")
    return out
