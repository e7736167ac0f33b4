"""What there is of each kind of part: the modules and files of its folder, and what installed packages offer."""

import os
import sys
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


def modules(package: str) -> tuple[str, ...]:
    """Return the names of the modules in a package, none of which is imported."""
    return tuple(module.name for module in iter_modules(import_module(package).__path__))


def files(package: str) -> dict[str, Path]:
    """Return the TOML files in a package by their names without the suffix."""
    folders = [Path(folder) for folder in import_module(package).__path__]
    return {path.stem: path for folder in folders for path in sorted(folder.glob("*.toml"))}


def part(package: str, name: str, base: type[_Part]) -> type[_Part]:
    """Return the class with this base in a module of a package."""
    module = import_module(f"{package}.{name}")
    kinds = (kind for kind in vars(module).values() if isinstance(kind, type) and kind.__module__ == module.__name__)
    return next(kind for kind in kinds if issubclass(kind, base))


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
