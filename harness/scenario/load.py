"""From a TOML file and overrides to a `Scenario`, or to sentences that say what to correct."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal, TypeVar

from railgrip.base.errors import InputError, ScenarioError
from railgrip.base.files import read_text
from railgrip.base.registry import shelf
from railgrip.base.units import cut, place, short
from railgrip.scenario.file import Elsewhere, is_file, located
from railgrip.scenario.merge import merged, parsed, read_overrides, with_another_plant
from railgrip.scenario.schema import Scenario
from railgrip.scenario.validation import Layers, validated

Kind = Literal["scenario", "campaign", "estimation", "train"]
_MARKS: Final[tuple[tuple[Kind, tuple[str, ...]], ...]] = (
    ("campaign", ("scenarios",)),
    ("estimation", ("model", "noise")),
    *(("estimation", ("extends", key)) for key in ("data", "model", "noise", "gate", "course", "source")),
    ("train", ("cars",)),
    ("scenario", ("vehicle", "controller")),
    ("scenario", ("extends",)),
)
"""Keys that only files of this kind have together."""
_COMMANDS: Final[Mapping[str, str]] = {
    "scenario": "run", "campaign": "campaign", "estimation": "estimate", "train": "train show",
}  # fmt: skip

_Scenario = TypeVar("_Scenario", bound=Scenario)

_LONGEST_CHAIN = 30
"""Files that extend each other; the longest chain of the library has three."""


def load(path: Path, overrides: Sequence[str] = (), equipment: Sequence[str] = ()) -> Scenario:
    """Return the scenario of a TOML file, or of the package by its name.

    Args:
        path: File or name.
        overrides: `table.key=value` texts, laid over all else.
        equipment: Files or names of ours, whose tables are laid over the scenario.

    Raises:
        ScenarioError: A file is missing, not TOML, or not a scenario; each problem in one sentence.
    """
    tables = read_scenario(path)
    for part in equipment:
        tables = _equipped(tables, located(part, "equipment"))
    return tables.laid(tables.origin, read_overrides(overrides)).value(Scenario)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tables:
    """The tables of a scenario file, laid over those of the files that it extends.

    Attributes:
        origin: Name of the file.
        directory: From where the files it names are found.
        table: All, as one.
        layers: Each with the name of its file, the uppermost first.
    """

    origin: str
    directory: Path
    table: dict[str, Any]
    layers: Layers

    @classmethod
    def of(cls, table: Mapping[str, Any], directory: Path, origin: str) -> "Tables":
        """Return tables of one source."""
        return cls(origin=origin, directory=directory, table=dict(table), layers=((origin, table),))

    def named(self, origin: str) -> "Tables":
        """Return them with other words for their file in sentences."""
        return replace(self, origin=origin, layers=((origin, self.layers[0][1]), *self.layers[1:]))

    def laid(self, name: str, change: Mapping[str, Any]) -> "Tables":
        """Return them with others on top."""
        return replace(self, table=merged(self.table, change), layers=((name, change), *self.layers))

    def value(self, kind: type[_Scenario]) -> _Scenario:
        """Return the scenario that they describe.

        Raises:
            ScenarioError: They describe none.
        """
        return validated(kind, self.table, directory=self.directory, origin=self.origin, layers=self.layers)


def read_scenario(path: Path) -> Tables:
    """Return the tables of a scenario file or name; its name is that of the file unless it has another.

    Raises:
        ScenarioError: It cannot be read, is of another kind, or extends what cannot be read.
    """
    path = located(path, "scenarios")
    return _tables_in(path, (path,))


def extended(table: Mapping[str, Any], folder: Path, origin: str, chain: Sequence[Path] = ()) -> Tables:
    """Return tables laid over those of the scenario that their key `extends` names.

    Args:
        table: With or without that key.
        folder: From where its files are found.
        origin: What to call the source in a sentence.
        chain: Files that have been read on the way here.

    Raises:
        ScenarioError: There is no such scenario, or it is one of the chain.
    """
    keys = {key: value for key, value in table.items() if key != "extends"}
    if "extends" not in table:
        return Tables.of(keys, folder, origin)
    entry = table["extends"]
    if not isinstance(entry, str) or not entry:
        raise ScenarioError(f"{origin}: extends is {short(entry)}; wanted is the name or the path of a scenario")
    path = located(entry, "scenarios", folder, f"{origin}: extends: ")
    if not is_file(path):
        raise ScenarioError(
            f"{origin}: extends names '{cut(entry)}', but there is no file {place(path)}; the path starts at the "
            f"folder of {origin}"
        )
    require_straight(path, chain, origin)
    base = _tables_in(path, (*chain, path))
    below: dict[str, Any] = Elsewhere.within(base.table, base.directory)
    if isinstance(below.get("vehicle"), dict) and isinstance(keys.get("vehicle"), dict):
        below["vehicle"] = with_another_plant(below["vehicle"], keys["vehicle"])
    return Tables(origin=origin, directory=folder, table=merged(below, keys), layers=((origin, keys), *base.layers))


def require_straight(path: Path, chain: Sequence[Path], origin: str) -> None:
    """Check that the next file of a chain of `extends` is not one of the chain, and that the chain is not too long.

    Raises:
        ScenarioError: The chain is circular or has more than `_LONGEST_CHAIN` files.
    """
    if path.resolve() in [file.resolve() for file in chain]:
        circle = " → ".join(file.name for file in (*chain, path))
        raise ScenarioError(f"{origin}: extends goes round in a circle: {circle}; leave it out of one of them")
    if len(chain) >= _LONGEST_CHAIN:
        raise ScenarioError(
            f"{chain[0].name}: extends a chain of more than {_LONGEST_CHAIN} files, one after the other; copy the keys "
            "of some of them into one file"
        )


def _tables_in(path: Path, chain: Sequence[Path]) -> Tables:
    table = read_toml(path)
    require_kind(table, "scenario", path)
    return extended({"name": path.stem} | table, path.parent, path.name, chain)


def _equipped(tables: Tables, file: Path) -> Tables:
    """Return tables with those of a file of equipment on top.

    Its plant is for scenarios of the train that equipment comes in variants of; others keep theirs. What it says of an
    estimator is for scenarios that have one.
    """
    table, variants = read_toml(file), [read_toml(path).get("vehicle") for path in shelf("equipment").values()]
    if tables.table.get("vehicle") not in (None, *variants):
        table.pop("vehicle", None)
    if tables.table.get("estimator", {"kind": "none"}) == {"kind": "none"} and "kind" not in table.get("estimator", {}):
        table.pop("estimator", None)
    return tables.laid(file.name, Elsewhere.within(table, file.parent))


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Raises:
        ScenarioError: Missing, unreadable, or not TOML.
    """
    try:
        return parsed(read_text(path))
    except tomllib.TOMLDecodeError as problem:
        raise ScenarioError(f"{cut(path.name)}: is not TOML: {cut(str(problem))}") from problem
    except InputError as problem:
        is_missing = isinstance(problem.__cause__, FileNotFoundError)
        hint = ", or use a name that `railgrip list` shows" if is_missing else ""
        raise ScenarioError(f"{problem}{hint}") from problem


def require_kind(table: Mapping[str, Any], kind_of_command: Kind, path: Path) -> None:
    """Refuse a file of another kind, in one sentence in place of one for each of its keys.

    Raises:
        ScenarioError: It says which command is for the file.
    """
    kind_of_file = next((kind for kind, keys in _MARKS if all(key in table for key in keys)), kind_of_command)
    if kind_of_file != kind_of_command:
        raise ScenarioError(
            f"{path.name}: is a file of the kind {kind_of_file}; use `railgrip {_COMMANDS[kind_of_file]} {path.name}`"
        )


def scenario_of(table: Mapping[str, Any], *, directory: Path, origin: str) -> Scenario:
    """Return the scenario that plain tables describe.

    Args:
        table: As TOML or `Scenario.resolved` give it.
        directory: From where the files it names are found.
        origin: What to call the source in a sentence.

    Raises:
        ScenarioError: Not a scenario.
    """
    return Tables.of(table, directory, origin).value(Scenario)
