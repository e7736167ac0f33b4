"""The registry of parts: the modules and files in the folder of each kind, and those of installed packages."""

import ast
import os
import re
import sys
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import distributions
from importlib.util import find_spec
from pathlib import Path
from pkgutil import iter_modules
from types import MappingProxyType
from typing import Final, Literal, TypeVar, get_args

from railgrip.base.names import did_you_mean, nearest

_Part = TypeVar("_Part")

Role = Literal["controllers", "estimators", "sensors", "plants"]

LAWS = "railgrip.controllers.laws"
"""Package with a module for each control law."""

CREEP_CURVES = "railgrip.scenario.creep_curves"
"""Folder with a TOML file for each named creep curve."""

FILTERS = "railgrip.estimators.filters"
"""Package with a module for each kind of Kalman filter."""

SENSORS, FAULTS = "railgrip.simulate.sensors", "railgrip.simulate.faults"
"""Packages with a module for each kind of sensors and for the faults of each part of a train."""

DYNAMIC_BRAKES = "railgrip.rolling_stock.dynamic_brakes"
"""Package with a module for each kind of dynamic brake in train files."""


Shelf = Literal["scenarios", "campaigns", "estimations", "trains", "equipment", "curves"]
"""Kinds of files in this package."""

Kind = Literal[Shelf, "controllers", "estimators", "sensors", "studies"]
"""Kinds of parts with names that a user may write."""


@dataclass(frozen=True, slots=True)
class Section:
    """One kind of named parts.

    Attributes:
        singular: Noun for one of them, with its article.
        package: Package with a file or a module for each.
        use: Command that takes a name.
    """

    singular: str
    package: str
    use: str


_SET: Final = "railgrip run trapezoid --set "
SECTIONS: Final[Mapping[str, Section]] = MappingProxyType(
    {
        "scenarios": Section("a scenario", "railgrip.scenario.library", "railgrip run {}"),
        "campaigns": Section("a campaign", "railgrip.scenario.campaigns", "railgrip campaign {}"),
        "trains": Section("a train", "railgrip.scenario.trains", "railgrip train show {}"),
        "equipment": Section("a set of equipment", "railgrip.scenario.equipment", "railgrip run trapezoid --with {}"),
        "curves": Section("a creep curve", CREEP_CURVES, _SET + "adhesion.polach={}"),
        "controllers": Section("a controller", LAWS, _SET + "controller.kind={}"),
        "estimators": Section("an estimator", FILTERS, _SET + "estimator.kind={}"),
        "sensors": Section("a kind of sensors", SENSORS, _SET + "sensors.kind={}"),
        "estimations": Section("an estimation", "railgrip.estimation.library", "railgrip estimate {}"),
        "studies": Section("a study", "railgrip.studies", "railgrip study {}"),
    }
)
"""Kind → its section, in the order of `railgrip list`."""

ANALYSES: Final[Mapping[str, str]] = MappingProxyType(
    {
        "ideal_bound": "Highest adhesion that rail, brakes and alpha_max allow at any time: an analysis, not a law.",
        "ideal_tracking": "The same through the valves of the train: an analysis with the true state, not a law.",
    }
)
"""Controllers that know the true state, which give bounds rather than laws; with their meanings."""

_WITHOUT_MODULE: Final[Mapping[str, dict[str, str]]] = MappingProxyType(
    {
        "controllers": {**ANALYSES, "fmu": "A user's controller as a co-simulation FMU, named by `file`."},
        "estimators": {"none": "No estimator: the controller sees readings only."},
    }
)
_SHARED: Final = frozenset({"study"})
"""Modules that are shared by the others of their package."""


def shelf(kind: Shelf) -> dict[str, Path]:
    """Return the files of a kind in this package, by name."""
    return files(SECTIONS[kind].package)


def names(kind: str) -> list[str]:
    """Return all names of a kind, in this package and in installed ones."""
    package = SECTIONS[kind].package
    if kind in get_args(Shelf):
        return list(files(package))
    shipped = [name for name in modules(package) if name not in _SHARED]
    return [*shipped, *_WITHOUT_MODULE.get(kind, ()), *_read_installed(kind)]


def meanings(kind: str) -> dict[str, str]:
    """Return the meaning of each name of a kind, as a sentence."""
    package = SECTIONS[kind].package
    if kind in get_args(Shelf):
        return {name: _description(path) for name, path in files(package).items()}
    known = {name: f"Installed: {place}" for name, place in _read_installed(kind).items()} | _WITHOUT_MODULE.get(
        kind, {}
    )
    return {name: known.get(name) or summary(package, name) for name in names(kind)}


def _read_installed(kind: str) -> Mapping[str, str]:
    return next((installed_names(role) for role in get_args(Role) if role == kind), {})


def summary(package: str, name: str) -> str:
    """Return the first line of a module's docstring.

    The module is parsed, not imported, since that can take seconds.
    """
    spec = find_spec(f"{package}.{name}")
    source = Path(spec.origin).read_text(encoding="utf-8") if spec is not None and spec.origin else ""
    return (ast.get_docstring(ast.parse(source)) or "").partition("\n")[0]


def _description(path: Path) -> str:
    # The description is the key `description` or `source`, or else the first comment.
    text = path.read_text(encoding="utf-8")
    table = tomllib.loads(text)
    words = table.get("description") or table.get("source") or text.partition("\n")[0].lstrip("# ")
    return re.split(r"(?<=\.)\s", " ".join(words.split()))[0]


def not_one_of(kind: str, name: str) -> str:
    """Return a sentence on an unknown name of a kind: a part of another kind with that name, or the nearest names."""
    others = {other: section for other, section in SECTIONS.items() if other != kind}
    holders = [section for other, section in others.items() if name in names(other)]
    if holders:
        words = " and ".join(f"{section.singular}: `{section.use.format(name)}`" for section in holders)
        return f"that is {words}"
    sentence = f"there is no such file, and no {SECTIONS[kind].singular.partition(' ')[2]} of that name"
    if question := did_you_mean(name, names(kind), count=3, quote="", before="; "):
        return f"{sentence}{question}"
    for other, section in others.items():
        if near := nearest(name, names(other), cutoff=0.75):
            return f"{sentence}; did you mean {near[0]}, {section.singular}: `{section.use.format(near[0])}`?"
    return f"{sentence}; `railgrip list {kind}` shows all"


def modules(package: str) -> tuple[str, ...]:
    """Return the names of the modules in a package, without importing them."""
    return _modules(_folders(package))


def files(package: str) -> dict[str, Path]:
    """Return the TOML files in a package by their names without the suffix."""
    return _files(_folders(package))


def part(package: str, name: str, base: type[_Part]) -> type[_Part]:
    """Return the class with this base in a module of a package."""
    return _classes(f"{package}.{name}", base)[0]


def parts(package: str, base: type[_Part]) -> list[type[_Part]]:
    """Return the classes with this base in all modules of a package."""
    return [kind for name in modules(package) for kind in _classes(f"{package}.{name}", base)]


def _folders(package: str) -> tuple[str, ...]:
    return tuple(import_module(package).__path__)


# Cached, because a campaign reads thousands of scenarios.
@cache
def _modules(folders: tuple[str, ...]) -> tuple[str, ...]:
    # An editor may leave "copy of law.py", which no program could import.
    return tuple(module.name for module in iter_modules(folders) if module.name.isidentifier())


@cache
def _files(folders: tuple[str, ...]) -> dict[str, Path]:
    paths = (path for folder in folders for path in sorted(Path(folder).glob("*.toml")))
    return {path.stem: path for path in paths if re.fullmatch(r"[\w.-]+", path.stem)}


def _classes(module: str, base: type[_Part]) -> list[type[_Part]]:
    members = vars(import_module(module)).items()
    classes = [kind for name, kind in members if isinstance(kind, type) and not name.startswith("_")]
    return [kind for kind in classes if issubclass(kind, base) and kind.__module__ == module]


@cache
def installed_names(role: Role) -> dict[str, str]:
    """Return name → module:Class of the entry points of installed packages, from their metadata only.

    Metadata in the current folder is ignored, because a downloaded folder may contain some.
    """
    here = os.path.realpath(Path.cwd())
    path = [entry for entry in sys.path if entry and os.path.realpath(entry) != here]
    names: dict[str, str] = {}
    for package in distributions(path=path):
        for point in package.entry_points.select(group=f"railgrip.{role}"):
            names.setdefault(point.name, point.value)
    return names
