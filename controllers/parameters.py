"""Parameters of sampled functions, each with its unit and meaning, and the tuned sets of the control laws.

The sets are TOML files next to each law, with values from a search or a paper. A file has a table for each kind of
actuation and source of the slip, such as `[pneumatic.estimated]`, or only values, which apply to all of them.
Parameters that are not in any set follow from physics or from a regulation; their values are the defaults of the
dataclass.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, get_type_hints

from railgrip.controllers.sampled import Expression, FormulaBuilder


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters:
    """Parameters of a sampled function; the type of each is `Annotated[float, unit, meaning]`."""

    @classmethod
    @cache
    def meanings(cls) -> Mapping[str, tuple[Any, ...]]:
        """Return the unit, the meaning and, if there is one, the largest value of each parameter, by name.

        Raises:
            TypeError: The type of a field has no unit and meaning.
        """
        types = get_type_hints(cls, include_extras=True)
        notes = {field.name: getattr(types[field.name], "__metadata__", ()) for field in fields(cls)}
        if bare := [name for name, note in notes.items() if len(note) < 2]:
            raise TypeError(f"{cls.__name__}: {', '.join(bare)}: write Annotated[float, 'unit', 'meaning'] as the type")
        return notes

    @classmethod
    def declare(cls, draft: FormulaBuilder) -> dict[str, Expression]:
        """Declare all parameters in a draft, and return their symbols by name."""
        return {name: draft.parameter(name, *meaning) for name, meaning in cls.meanings().items()}


SlipSource = Literal["read", "estimated"]
"""Source of a law's slip: readings alone, or an estimator."""

SEARCHED = "searched"
"""Name of the set that `railgrip maintain tune-control` writes on the training rails."""

TYPE_TEST = MappingProxyType({1: "type_test", 2: "type_test_2"})
"""Names of the sets searched on the training cases of a version of the type test, for laws whose `SEARCHED` set must
stay as it is because tables that compare them with the papers, or version 1, use it."""


def file_of(kind: str, name: str) -> str:
    """Return the name of the file of a law's set."""
    return f"{kind}.toml" if name == SEARCHED else f"{kind}.{name}.toml"


def tuned_values(file: Path, name: str, actuation: str, slip: SlipSource) -> Mapping[str, float]:
    """Return the values of the set `name` in a file for an actuation and a source of the slip.

    Without a table for this source of the slip, the actuation's first table is used. Without one for this actuation, a
    file of `SEARCHED` values is used with its first actuation.

    Raises:
        ValueError: The set has another name than `SEARCHED`, and no values for this actuation.
    """
    sets = tomllib.loads(file.read_text(encoding="utf-8"))
    if not any(isinstance(entry, dict) for entry in sets.values()):
        return sets
    if actuation not in sets and name != SEARCHED:
        known = ", ".join(f"{kind} actuation and {source} slip" for kind, sources in sets.items() for source in sources)
        law = file.name.partition(".")[0]
        raise ValueError(
            f"tuning '{name}': {law} has no set for {actuation} actuation and {slip} slip; there is {known}"
        )
    by_slip = sets.get(actuation, next(iter(sets.values())))
    return by_slip.get(slip, next(iter(by_slip.values())))
