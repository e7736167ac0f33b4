"""Load a `Scenario` from a TOML file and overrides.

Plain tables are validated; each error becomes a sentence with file, key and correction.
"""

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType, UnionType
from typing import Annotated, Any, Final, Literal, TypeVar, Union, cast, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from railgrip.base.errors import InputError, ScenarioError
from railgrip.base.files import read_text
from railgrip.base.names import did_you_mean
from railgrip.base.registry import DYNAMIC_BRAKES, modules, shelf
from railgrip.base.tables import TomlTable
from railgrip.base.units import cut, place, short
from railgrip.scenario.file import (
    DIRECTORY,
    OtherFileString,
    is_file,
    locate,
    merge,
    parse_toml,
    read_overrides,
    with_another_plant,
)
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import ByKind, kinds_of

_Model = TypeVar("_Model", bound=BaseModel)

Layers = Sequence[tuple[str, Mapping[str, Any]]]
"""Files with their tables, merged in this order, the uppermost first."""


def validate_table(
    model: type[_Model], table: Mapping[str, Any], *, directory: Path, origin: str, layers: Layers = ()
) -> _Model:
    """Return `table` as a value of `model`.

    Args:
        model: Pydantic model of the table.
        table: Plain values.
        directory: Folder that the table's paths are relative to.
        origin: Name of the source in messages.
        layers: Files that the table was merged from, if there are several.

    Raises:
        ScenarioError: The table is invalid; one line, "origin: [table] key …", per problem.
    """
    try:
        return model.model_validate(table, context={DIRECTORY: directory})
    except ValidationError as problem:
        lines: dict[str, None] = {}
        for error in problem.errors():
            if error["type"] == "too_short" and error["input"]:
                continue  # none of its items is valid, each of which has a sentence
            path, keys = _place(model, table, error["loc"])
            # A missing key may belong to a table that another layer has replaced.
            present = path[:-1] if error["type"] == "missing" else path
            lines[f"{_holder(layers, present) or origin}: {_sentence(model, path, keys, error)}"] = None
        raise ScenarioError("\n".join(lines)) from None


def _holder(layers: Layers, path: Sequence[int | str]) -> str | None:
    def depth(table: Any) -> int:
        for number, step in enumerate(path):
            try:
                table = table[step]
            except (KeyError, IndexError, TypeError):
                return number
        return len(path)

    return max(layers, key=lambda layer: depth(layer[1]), default=(None,))[0]


def _sentence(model: type[BaseModel], path: Sequence[int | str], keys: Sequence[str], error: ErrorDetails) -> str:
    kind, context = error["type"], error.get("ctx", {})
    if kind == "extra_forbidden":
        return f"{_table(path[:-1])} has no key {short(path[-1])}; {_suggestion(str(path[-1]), keys)}"
    if kind == "missing":
        whole_table = len(path) == 1 and bool(_models(model.model_fields[str(path[0])].annotation))
        problem = f"[{path[0]}] is missing" if whole_table else f"{_table(path[:-1])} has no '{path[-1]}'"
        return f"{problem}; it is required"
    if kind == "union_tag_not_found":
        return f"{_table(path)} has no 'kind'; it is required"
    if kind == "union_tag_invalid":
        kinds = context["expected_tags"].replace("'", "")
        return f"{_table(path)} kind is {short(context['tag'])}; {_choice(context['tag'], kinds)}"
    if not path:
        return _end_sentence(error["msg"])  # a rule between tables names them in its text
    key = f"{_table(path[:-1])} {path[-1]}" if path[:-1] else str(path[-1])
    if isinstance(error["input"], Mapping) and kind == "scenario":
        key = _table(path)  # a problem of a whole table names its keys in its text
    if kind in {"quantity", "scenario"}:
        return _end_sentence(f"{key} {error['msg']}")
    if kind == "literal_error":
        return f"{key} is {short(error['input'])}; {_choice(error['input'], context['expected'])}"
    if kind in {"tuple_type", "list_type"} and isinstance(error["input"], Mapping):
        return f"{_table(path)} is a table, but may be given several times; write [{_table(path)}]"
    if kind in {"model_type", "model_attributes_type", "dict_type"}:
        return f"{_table(path)} must be a table, got {short(error['input'])}"
    message = error["msg"]
    return f"{key} is {short(error['input'])}; {message[:1].lower()}{message[1:]}"


def _end_sentence(sentence: str) -> str:
    return sentence if sentence.endswith(("?", ".")) else f"{sentence}."


def _place(
    model: type[BaseModel], table: Mapping[str, Any], location: tuple[int | str, ...]
) -> tuple[list[int | str], list[str]]:
    # Pydantic adds the tag of a union of tables ("trapezoid" in adhesion.trapezoid.minimum) and the branch of a union
    # of values; the file has neither.
    path: list[int | str] = []
    node: Any = table
    branches: list[type[BaseModel]] = [model]
    keys: list[str] = []
    fields: list[FieldInfo] = []
    for step in location:
        if isinstance(node, Mapping) and step not in node and step == node.get("kind"):
            branches = [branch for branch in branches if step in kinds_of(branch)] or branches
            continue
        if not isinstance(node, Mapping | list | tuple):
            continue
        keys = sorted({name for branch in branches for name in branch.model_fields})
        if isinstance(node, Mapping):
            # The name of an entry of a table of tables is not a field.
            fields = [branch.model_fields[str(step)] for branch in branches if step in branch.model_fields] or fields
            node = node.get(step)
        elif isinstance(step, int) and step < len(node):
            node = node[step]
        branches = [table_model for field in fields for table_model in _models(field, node)] or branches
        path.append(step)
    return path, keys


def _models(annotation: Any, entry: Any = None) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if isinstance(annotation, FieldInfo):
        parts: tuple[Any, ...] = (annotation.annotation, *annotation.metadata)
    else:
        parts = get_args(annotation) if get_origin(annotation) in {Annotated, Union, UnionType, tuple, dict} else ()
    by_kind = next((part for part in parts if isinstance(part, ByKind)), None)
    if (
        by_kind is not None
        and isinstance(entry, Mapping)
        and (table := by_kind.table_of(cast("Mapping[str, object]", entry).get("kind")))
    ):
        return [table]
    return [table_model for part in parts for table_model in _models(part, entry)]


def _join_path(path: Sequence[int | str]) -> str:
    return re.sub(r"\.\[", "[", ".".join(f"[{step + 1}]" if isinstance(step, int) else step for step in path))


def _table(path: Sequence[int | str]) -> str:
    return f"[{_join_path(path)}]" if path else "the top level"


def _suggestion(name: str, choice: Sequence[str]) -> str:
    if sentence := explain_unsupported(name):
        return f"{sentence}."
    guess = did_you_mean(name, choice)
    return f"{guess} It has {', '.join(choice)}." if guess else f"it has {', '.join(choice)}."


def _choice(found: object, expected: str) -> str:
    if sentence := explain_unsupported(str(found)):
        return f"{sentence}; there is {expected}"
    return f"there is {expected}" + did_you_mean(str(found), re.findall(r"\w+", expected), quote="", before="; ")


_FOREIGN: Final = "a plant from another tool may have it (`railgrip map`)"
UNSUPPORTED: Final[Mapping[str, tuple[str, str]]] = MappingProxyType(
    {
        r"ed(_?brakes?)?|electro_?dynamic.*|regenerat.*|recuperat.*|rheostat.*|blended.*": (
            "electrodynamic brakes under this name are",
            "in a train file, [dynamic_brakes.NAME] has kind = 'electrodynamic' and blending, and a bogie names it: "
            "dynamic_brake = 'NAME'",
        ),
        r"hydro_?dynamic.*|retarders?|engine_brakes?": ("hydrodynamic and engine brakes are", _FOREIGN),
        r".*eddy_?current.*|linear_brakes?|ecb": (
            "eddy-current brakes under this name are",
            "in a train file, [dynamic_brakes.NAME] has kind = 'eddy_current_axle' or 'eddy_current_rail', and a bogie "
            "names it: dynamic_brake = 'NAME'",
        ),
        r".*tread_?brak.*|block_?brak.*|.*brake_?(blocks?|shoes?)|shoes": (
            "tread brakes are",
            "in a train file, [blocks.NAME] has the law of their friction, and a unit in [brakes] names it: "
            "blocks = 'NAME'",
        ),
        r"ll_?blocks?|composite_ll": (
            "blocks of the kind LL are",
            "no law of their friction over speed and force is published; [pads] may have effects for them",
        ),
        r"parkbrakes?|spring_?(applied|loaded)?_brak.*|hand_?brak.*|holding_brak.*": (
            "parking brakes under this name are",
            "in a train file, [parking_brakes.NAME] has their force, and a bogie names it: parking_brake = 'NAME'",
        ),
        r"(load_?)?weigh.*|load_?(proportional|dependent|sens).*|empty_load.*": (
            "brakes that follow the load are",
            "in a train file, [load_valves.NAME] adapts pressure or rigging to the mass of a car, which names it: "
            "load_valve = 'NAME'",
        ),
        r"wind|head_?wind|cross_?wind|weather|tunnels?": (
            "wind, weather and tunnels are",
            "change the drag of the vehicle, and [adhesion] for wet or leaves",
        ),
    }
)
"""Pattern of a whole key → its meaning, and the alternative."""


def explain_unsupported(key: str) -> str:
    """Return a sentence on a key for unsupported equipment; empty for any other key."""
    name = re.sub(r"[\s.-]+", "_", key).casefold()
    if name in modules(DYNAMIC_BRAKES):
        return (
            f"brakes of the kind '{name}' under this name are not supported here; in a train file, "
            f"[dynamic_brakes.NAME] has kind = '{name}', and a bogie names it: dynamic_brake = 'NAME'"
        )
    found = next((words for pattern, words in UNSUPPORTED.items() if re.fullmatch(pattern, name)), None)
    return f"{found[0]} not supported here; {found[1]}" if found else ""


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
    table: TomlTable
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
    below: TomlTable = OtherFileString.within(base.table, base.directory)
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


def read_toml(path: Path) -> TomlTable:
    """Return the tables of a TOML file.

    Raises:
        ScenarioError: The file is missing, unreadable, or not TOML.
    """
    try:
        return parse_toml(read_text(path, if_missing=", or use a name that `railgrip list` shows"))
    except tomllib.TOMLDecodeError as problem:
        raise ScenarioError(f"{cut(path.name)}: is not TOML: {cut(str(problem))}") from problem
    except InputError as problem:
        raise ScenarioError(str(problem)) from problem


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
