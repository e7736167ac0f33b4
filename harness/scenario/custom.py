"""A class named in place of a kind, and its arguments."""

import os
import sys
from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import distributions
from pathlib import Path
from typing import Any, Literal, cast

from pydantic import Field

from railgrip.scenario.table import Table

Role = Literal["controllers", "estimators", "sensors", "plants"]

OURS, CUSTOM = "of this project", "of one's own"
"""Tags of the two sorts of table; no key of a file has such a name."""


class Custom(Table):
    """A class of the user's own; see `railgrip.custom` for what it is asked.

    `railgrip.assemble.importing` says from where it is imported.
    """

    kind: str = Field(description="module:Class, or the name of an entry point in the group railgrip.<table>s")
    parameters: dict[str, Any] = Field(default={}, description="arguments of the class, by keyword")


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


def whose(role: Role, ours: frozenset[str]) -> Callable[[Any], str]:
    """Return what tells the tables of this project, of the kinds `ours`, from those of a class of one's own."""

    def tag(entry: Any) -> str:
        if isinstance(entry, Mapping):
            kind: object = cast("Mapping[str, object]", entry).get("kind")
        else:
            kind = getattr(entry, "kind", None)
        if not isinstance(kind, str) or kind in ours:
            return OURS
        return CUSTOM if ":" in kind or kind in installed_names(role) else OURS

    return tag
