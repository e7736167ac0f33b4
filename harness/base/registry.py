"""What there is of each kind of part: the modules and files of its folder, and what installed packages offer."""

import os
import sys
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import distributions
from pathlib import Path
from pkgutil import iter_modules
from typing import Literal, TypeVar

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


_SHELVES = {
    "scenarios": "railgrip.scenario.library",
    "campaigns": "railgrip.scenario.campaigns",
    "trains": "railgrip.scenario.trains",
}


def shelf(kind: str) -> Mapping[str, Path]:
    """Return the files of a kind that come with this package, by name: scenarios, campaigns or trains."""
    return files(_SHELVES[kind])


def modules(package: str) -> tuple[str, ...]:
    """Return the names of the modules in a package, none of which is imported."""
    return _modules(_folders(package))


def files(package: str) -> Mapping[str, Path]:
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


# A campaign reads thousands of scenarios, so that each folder is listed once.
@cache
def _modules(folders: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(module.name for module in iter_modules(folders))


@cache
def _files(folders: tuple[str, ...]) -> Mapping[str, Path]:
    return {path.stem: path for folder in folders for path in sorted(Path(folder).glob("*.toml"))}


def _classes(module: str, base: type[_Part]) -> list[type[_Part]]:
    """Return the classes with this base that a module defines for others: those without a leading underscore."""
    members = vars(import_module(module)).items()
    classes = [kind for name, kind in members if isinstance(kind, type) and not name.startswith("_")]
    return [kind for kind in classes if issubclass(kind, base) and kind.__module__ == module]


@cache
def installed_names(role: Role) -> dict[str, str]:
    """Return name → module:Class of what installed packages offer; only their metadata is read.

    Metadata in the current folder is left out: a folder of files that somebody sent may hold some.
    """
    here = os.path.realpath(Path.cwd())
    path = [entry for entry in sys.path if entry and os.path.realpath(entry) != here]
    names: dict[str, str] = {}
    for package in distributions(path=path):
        for point in package.entry_points.select(group=f"railgrip.{role}"):
            names.setdefault(point.name, point.value)
    return names
