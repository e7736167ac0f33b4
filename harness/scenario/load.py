"""Load a `Scenario` from a TOML file and overrides, with one sentence for each error."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal, TypeVar

from railgrip.base.errors import InputError, ScenarioError
from railgrip.base.files import read_text
from railgrip.base.registry import shelf
from railgrip.base.units import cut, place, short
from railgrip.scenario.file import OtherFileString, is_file, locate
from railgrip.scenario.merge import merge, parse_toml, read_overrides, with_another_plant
from railgrip.scenario.schema import Scenario
from railgrip.scenario.validation import Layers, validate_table

Kind = Literal["scenario", "campaign", "estimation", "train"]
_MARKS: Final[tuple[tuple[Kind, tuple[str, ...]], ...]] = (
    ("campaign", ("scenarios",)),
    ("estimation", ("model", "noise")),
    *(("estimation", ("extends", key)) for key in ("data", "model", "noise", "gate", "course", "source")),
    ("train", ("cars",)),
    ("scenario", ("vehicle", "controller")),
    ("scenario", ("extends",)),
)
"""Keys that identify a kind of file: only files of this kind have all of them."""
_COMMANDS: Final[Mapping[str, str]] = {
    "scenario": "run", "campaign": "campaign", "estimation": "estimate", "train": "train show",
}  # fmt: skip

_Scenario = TypeVar("_Scenario", bound=Scenario)

_LONGEST_CHAIN = 30
"""Maximum length of a chain of files that extend each other; the longest chain of the library has three."""


def load(path: Path, overrides: Sequence[str] = (), equipment: Sequence[str] = ()) -> Scenario:
    """Return the scenario of a TOML file, or of the library by its name.

    Args:
        path: Path or name of the file.
        overrides: Strings `table.key=value`, applied last.
        equipment: Files or names of equipment, whose tables override those of the scenario.

    Raises:
        ScenarioError: A file is missing, not TOML, or not a scenario; one sentence per problem.
    """
    tables = read_scenario(path)
    for part in equipment:
        tables = _add_equipment(tables, locate(part, "equipment"))
    return tables.overlay(tables.origin, read_overrides(overrides)).value(Scenario)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tables:
    """The tables of a scenario file, merged with those of the files that it extends.

    Attributes:
        origin: Name of the file.
        directory: Folder that the file's paths are relative to.
        table: The merged tables.
        layers: The tables of each file with its name, the uppermost first.
    """

    origin: str
    directory: Path
    table: dict[str, Any]
    layers: Layers

    @classmethod
    def of(cls, table: Mapping[str, Any], directory: Path, origin: str) -> "Tables":
        """Return tables of one source."""
        return cls(origin=origin, directory=directory, table=dict(table), layers=((origin, table),))

    def rename(self, origin: str) -> "Tables":
        """Return the tables with other words for their file in messages."""
        return replace(self, origin=origin, layers=((origin, self.layers[0][1]), *self.layers[1:]))

    def overlay(self, name: str, change: Mapping[str, Any]) -> "Tables":
        """Return the tables with changes on top."""
        return replace(self, table=merge(self.table, change), layers=((name, change), *self.layers))

    def value(self, kind: type[_Scenario]) -> _Scenario:
        """Return the scenario of these tables.

        Raises:
            ScenarioError: They are not a valid scenario.
        """
        return validate_table(kind, self.table, directory=self.directory, origin=self.origin, layers=self.layers)


def read_scenario(path: Path) -> Tables:
    """Return the tables of a scenario file or name; the scenario's name defaults to that of the file.

    Raises:
        ScenarioError: The file cannot be read, is of another kind, or extends a file that cannot be read.
    """
    path = locate(path, "scenarios")
    return _tables_in(path, (path,))


def extend_tables(table: Mapping[str, Any], folder: Path, origin: str, chain: Sequence[Path] = ()) -> Tables:
    """Return tables merged with those of the scenario that their key `extends` names.

    Args:
        table: Tables, with or without that key.
        folder: Folder that their paths are relative to.
        origin: Name of the source in messages.
        chain: Files that have been read before this one.

    Raises:
        ScenarioError: The scenario does not exist, or is already in the chain.
    """
    keys = {key: value for key, value in table.items() if key != "extends"}
    if "extends" not in table:
        return Tables.of(keys, folder, origin)
    entry = table["extends"]
    if not isinstance(entry, str) or not entry:
        raise ScenarioError(f"{origin}: extends is {short(entry)}; expected is the name or the path of a scenario")
    path = locate(entry, "scenarios", folder, f"{origin}: extends: ")
    if not is_file(path):
        raise ScenarioError(
            f"{origin}: extends names '{cut(entry)}', but there is no file {place(path)}; the path starts at the "
            f"folder of {origin}"
        )
    require_straight(path, chain, origin)
    base = _tables_in(path, (*chain, path))
    below: dict[str, Any] = OtherFileString.within(base.table, base.directory)
    if isinstance(below.get("vehicle"), dict) and isinstance(keys.get("vehicle"), dict):
        below["vehicle"] = with_another_plant(below["vehicle"], keys["vehicle"])
    return Tables(origin=origin, directory=folder, table=merge(below, keys), layers=((origin, keys), *base.layers))


def require_straight(path: Path, chain: Sequence[Path], origin: str) -> None:
    """Check that the next file of a chain of `extends` is not in the chain, and that the chain is not too long.

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
    return extend_tables({"name": path.stem} | table, path.parent, path.name, chain)


def _add_equipment(tables: Tables, file: Path) -> Tables:
    # The plant of the equipment replaces only that of the train that the equipment is made for; other plants are kept.
    # Its keys of an estimator apply only to scenarios with an estimator.
    table, variants = read_toml(file), [read_toml(path).get("vehicle") for path in shelf("equipment").values()]
    if tables.table.get("vehicle") not in (None, *variants):
        table.pop("vehicle", None)
    if tables.table.get("estimator", {"kind": "none"}) == {"kind": "none"} and "kind" not in table.get("estimator", {}):
        table.pop("estimator", None)
    return tables.overlay(file.name, OtherFileString.within(table, file.parent))


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Raises:
        ScenarioError: The file is missing, unreadable, or not TOML.
    """
    try:
        return parse_toml(read_text(path))
    except tomllib.TOMLDecodeError as problem:
        raise ScenarioError(f"{cut(path.name)}: is not TOML: {cut(str(problem))}") from problem
    except InputError as problem:
        is_missing = isinstance(problem.__cause__, FileNotFoundError)
        hint = ", or use a name that `railgrip list` shows" if is_missing else ""
        raise ScenarioError(f"{problem}{hint}") from problem


def require_kind(table: Mapping[str, Any], kind_of_command: Kind, path: Path) -> None:
    """Raise an error for a file of another kind: one sentence instead of one for each of its keys.

    Raises:
        ScenarioError: The file is of another kind; the message names the command for it.
    """
    kind_of_file = next((kind for kind, keys in _MARKS if all(key in table for key in keys)), kind_of_command)
    if kind_of_file != kind_of_command:
        raise ScenarioError(
            f"{path.name}: is a file of the kind {kind_of_file}; use `railgrip {_COMMANDS[kind_of_file]} {path.name}`"
        )


def scenario_of(table: Mapping[str, Any], *, directory: Path, origin: str) -> Scenario:
    """Return the scenario of plain tables.

    Args:
        table: Tables as read from TOML or returned by `Scenario.resolved`.
        directory: Folder that their paths are relative to.
        origin: Name of the source in messages.

    Raises:
        ScenarioError: The tables are not a valid scenario.
    """
    return Tables.of(table, directory, origin).value(Scenario)
