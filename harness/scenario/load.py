"""From a TOML file and overrides to a `Scenario`, or to sentences that say what to correct."""

import difflib
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, cast, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from railgrip.base.errors import ScenarioError
from railgrip.base.units import cut, place, short
from railgrip.scenario.file import DIRECTORY, located
from railgrip.scenario.kinds import ByKind, kinds_of
from railgrip.scenario.merge import merged, parsed, read_overrides
from railgrip.scenario.schema import Scenario

Kind = Literal["scenario", "campaign", "estimation"]
_MARKS: Mapping[Kind, tuple[str, ...]] = {
    "campaign": ("name", "scenarios"),
    "estimation": ("name", "model", "noise"),
    "scenario": ("name", "vehicle", "controller"),
}
"""Keys that only files of this kind have together."""

_LARGEST = 4_000_000  # bytes; the longest file of ours has 20 000

_Model = TypeVar("_Model", bound=BaseModel)


def load(path: Path, overrides: Sequence[str] = ()) -> Scenario:
    """Return the scenario of a TOML file, or of the package by its name, with `table.key=value` overrides on top.

    Raises:
        ScenarioError: The file is missing, not TOML, or not a scenario; each problem in one sentence.
    """
    path = located(path, "scenarios")
    table_of_file = read_toml(path)
    require_kind(table_of_file, "scenario", path)
    table = merged(table_of_file, read_overrides(overrides))
    return scenario_of(table, directory=path.parent, origin=path.name)


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Raises:
        ScenarioError: Missing, unreadable, or not TOML.
    """
    name = place(path)
    try:
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)
        if len(content) > _LARGEST:
            raise ScenarioError(f"{name}: is larger than {_LARGEST / 1e6:g} MB, which no scenario or campaign is")
        return parsed(content.decode("utf-8-sig").replace("\r\n", "\n"))
    except FileNotFoundError as problem:
        raise ScenarioError(
            f"{name}: there is no such file; name a scenario or campaign file (*.toml), or one of ours, such as "
            "trapezoid"
        ) from problem
    except OSError as problem:
        raise ScenarioError(f"{name}: cannot be read: {problem.strerror}") from problem
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as problem:
        raise ScenarioError(f"{cut(path.name)}: is not TOML: {cut(str(problem))}") from problem
    except ValueError as problem:
        if isinstance(problem, ScenarioError):
            raise
        raise ScenarioError(f"{name}: cannot be read: {problem}") from problem  # a path with a null in it


def require_kind(table: Mapping[str, Any], kind_of_command: Kind, path: Path) -> None:
    """Refuse a file of another kind, in one sentence in place of one for each of its keys.

    Raises:
        ScenarioError: It says which command is for the file.
    """
    kind_of_file = next((kind for kind, keys in _MARKS.items() if all(key in table for key in keys)), kind_of_command)
    if kind_of_file != kind_of_command:
        command = {"scenario": "run", "campaign": "campaign", "estimation": "estimate"}[kind_of_file]
        raise ScenarioError(f"{path.name}: is a file of the kind {kind_of_file}; use `railgrip {command} {path.name}`")


def scenario_of(table: Mapping[str, Any], *, directory: Path, origin: str) -> Scenario:
    """Return the scenario that plain tables describe.

    Args:
        table: As TOML or `Scenario.resolved` give it.
        directory: From where the files it names are found.
        origin: What to call the source in a sentence.

    Raises:
        ScenarioError: Not a scenario.
    """
    return validated(Scenario, table, directory=directory, origin=origin)


def validated(model: type[_Model], table: Mapping[str, Any], *, directory: Path, origin: str) -> _Model:
    """Return `table` as a value of `model`.

    Raises:
        ScenarioError: With one line, "origin: [table] key …", for each problem.
    """
    try:
        return model.model_validate(table, context={DIRECTORY: directory})
    except ValidationError as problem:
        lines = dict.fromkeys(_sentence(model, table, error) for error in problem.errors())
        raise ScenarioError("\n".join(f"{origin}: {line}" for line in lines)) from None


def _sentence(model: type[BaseModel], table: Mapping[str, Any], error: ErrorDetails) -> str:
    path, keys = _place(model, table, error["loc"])
    kind, context = error["type"], error.get("ctx", {})
    if kind == "extra_forbidden":
        return f"{_table(path[:-1])} has no key {short(path[-1])}; {_suggestion(str(path[-1]), keys)}"
    if kind == "missing":
        whole_table = len(path) == 1 and bool(_models(model.model_fields[str(path[0])].annotation))
        problem = f"[{path[0]}] is missing" if whole_table else f"{_table(path[:-1])} has no '{path[-1]}'"
        return f"{problem}; it is wanted and has no default"
    if kind == "union_tag_not_found":
        return f"{_table(path)} has no 'kind'; it is wanted and has no default"
    if kind == "union_tag_invalid":
        return f"{_table(path)} kind is {short(context['tag'])}; {_choice(context['tag'], context['expected_tags'])}"
    if not path:
        return f"{error['msg']}."  # a rule between tables names them itself
    key = f"{_table(path[:-1])} {path[-1]}" if path[:-1] else str(path[-1])
    if isinstance(error["input"], Mapping) and kind == "scenario":
        key = _table(path)  # a problem of a whole table names its keys itself
    if kind in {"quantity", "file", "scenario"}:
        return f"{key} {error['msg']}."
    if kind == "literal_error":
        return f"{key} is {short(error['input'])}; {_choice(error['input'], context['expected'])}"
    if kind in {"model_type", "model_attributes_type", "dict_type"}:
        return f"{_table(path)} must be a table, got {short(error['input'])}"
    message = error["msg"]
    return f"{key} is {short(error['input'])}; {message[:1].lower()}{message[1:]}"


def _place(
    model: type[BaseModel], table: Mapping[str, Any], location: tuple[int | str, ...]
) -> tuple[list[int | str], list[str]]:
    """Return pydantic's location as the path in the file, and the keys that the table of its last step knows.

    Pydantic puts the tag of a union of tables ("trapezoid" in adhesion.trapezoid.minimum), and the branch of
    a union of values, into the location; the file has neither.
    """
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
            fields = [branch.model_fields[str(step)] for branch in branches if step in branch.model_fields]
            node = node.get(step)
        elif isinstance(step, int) and step < len(node):
            node = node[step]
        branches = [table_model for field in fields for table_model in _models(field, node)] or branches
        path.append(step)
    return path, keys


def _models(annotation: Any, entry: Any = None) -> list[type[BaseModel]]:
    """Return the tables inside an annotation or a field; of those that its kind chooses the one of an entry."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if isinstance(annotation, FieldInfo):
        parts: tuple[Any, ...] = (annotation.annotation, *annotation.metadata)
    else:
        parts = get_args(annotation) if get_origin(annotation) in {Annotated, Union, UnionType, tuple, dict} else ()
    by_kind = next((one for one in parts if isinstance(one, ByKind)), None)
    if (
        by_kind is not None
        and isinstance(entry, Mapping)
        and (table := by_kind.table_of(cast("Mapping[str, object]", entry).get("kind")))
    ):
        return [table]
    return [table_model for part in parts for table_model in _models(part, entry)]


def _dotted(path: Sequence[int | str]) -> str:
    return re.sub(r"\.\[", "[", ".".join(f"[{step + 1}]" if isinstance(step, int) else step for step in path))


def _table(path: Sequence[int | str]) -> str:
    return f"[{_dotted(path)}]" if path else "the top level"


def _suggestion(name: str, choice: Sequence[str]) -> str:
    close = difflib.get_close_matches(name, choice, n=1)
    guess = f"did you mean '{close[0]}'? " if close else ""
    return f"{guess}It has {', '.join(choice)}." if guess else f"it has {', '.join(choice)}."


def _choice(found: object, expected: str) -> str:
    """Return what there is in place of what was found, the nearest first."""
    near = difflib.get_close_matches(str(found), re.findall(r"\w+", expected), n=1)
    return f"{f'did you mean {near[0]}? There' if near else 'there'} is {expected}"
