"""Files that a scenario names, and the layers of tables that it consists of.

A named file is kept as written, found relative to the folder of its scenario, and identified by its content. Layers
are `extends`, the file, equipment, variants of a campaign, `--set` and changes in Python.
"""

import json
import os
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, cast

from pydantic import GetCoreSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, core_schema

from railgrip.base.errors import ScenarioError
from railgrip.base.registry import Shelf, not_one_of, shelf
from railgrip.base.tables import TomlTable
from railgrip.base.units import cut, place, short
from railgrip.fmus.native.library import file_digest
from railgrip.scenario.table import table_error

_Content = TypeVar("_Content")

DIRECTORY = "directory"
"""Key of the validation context for the folder of the scenario file."""


def is_file(path: Path) -> bool:
    """Return whether a path is a file; also for paths that the system rejects, such as one of 5000 characters."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_folder(path: Path) -> bool:
    """Return whether a path is a folder; as `is_file`."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def locate(entry: str | Path, kind: Shelf, folder: Path = Path(), where: str = "") -> Path:
    """Return the file for an entry: a path relative to a folder, or a bare name in the library, such as `trapezoid`.

    Args:
        entry: Entry as written.
        kind: Kind of library entry.
        folder: Folder that paths are relative to.
        where: Opening words of messages: file and key of the entry.

    Raises:
        ScenarioError: A bare name matches neither a file nor a library entry of this kind.
    """
    path, name = folder / entry, Path(entry)
    if is_file(path) or name.suffix or len(name.parts) != 1:
        return path
    if ours := shelf(kind).get(name.name):
        return ours
    raise ScenarioError(f"{where}{cut(name.name)}: {not_one_of(kind, name.name)}")


def _relative(path: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:  # on another drive of Windows
        return path.resolve().as_posix()


class OtherFileString(str):
    """A string of a file that another one extends: a path in it is relative to the folder of the file that it is
    written in.

    Attributes:
        folder: Folder of that file.
    """

    __slots__ = ("folder",)
    folder: Path

    @classmethod
    def within(cls, value: Any, folder: Path) -> Any:
        """Return tables, lists or a string with the folder attached to each string that has no folder yet."""
        if isinstance(value, Mapping):
            return {key: cls.within(inner, folder) for key, inner in cast("Mapping[str, Any]", value).items()}
        if isinstance(value, list):
            return [cls.within(inner, folder) for inner in cast("list[Any]", value)]
        if not isinstance(value, str) or isinstance(value, OtherFileString):
            return value
        text = cls(value)
        text.folder = folder
        return text


class NamedFile:
    """A file that a scenario refers to.

    It is not a dataclass, which pydantic would dump as a table.

    Attributes:
        entry: The path as written; results record only this, so that they do not depend on the location of the project.
        path: Path of the file on this machine.
    """

    __slots__ = ("entry", "path")

    def __init__(self, entry: str, path: Path) -> None:
        self.entry, self.path = entry, path

    def __eq__(self, other: object) -> bool:
        return isinstance(other, NamedFile) and (self.entry, self.path) == (other.entry, other.path)

    def __hash__(self) -> int:
        return hash((self.entry, self.path))

    def __repr__(self) -> str:
        return f"NamedFile({self.entry!r}, {self.path!r})"

    def digest(self) -> str:
        """Return the SHA-256 of the content; for a Modelica file, that of all files that its classes may use."""
        return file_digest(self.path)

    def read(self, content_of: Callable[[Path], _Content]) -> _Content:
        """Return the content by a function of the path, whose ValueErrors become those of the key `file`.

        Raises:
            PydanticCustomError: The function has raised a ValueError.
        """
        try:
            return content_of(self.path)
        except ValueError as problem:
            raise table_error(f"file {self.entry}: {problem}") from problem

    @classmethod
    def find(cls, entry: object, info: ValidationInfo) -> "NamedFile":
        """Resolve a string relative to the scenario's folder.

        Raises:
            PydanticCustomError: The entry is not a path, the file does not exist, or it is a system by SSP.
        """
        if isinstance(entry, NamedFile):
            return entry
        if not isinstance(entry, str) or not entry:
            raise table_error(f"is {short(entry)}; expected is the path of a file")
        if entry.lower().endswith(".ssp"):
            raise table_error(
                f"is {short(entry)}, a system by SSP, which railgrip exports and does not import; extract the .fmu "
                "that you need from the folder resources of that archive and name that"
            )
        context = cast("dict[str, Path] | None", info.context) or {}
        directory = context.get(DIRECTORY, Path())
        path = (entry.folder if isinstance(entry, OtherFileString) else directory) / entry
        if not is_file(path):
            is_recipe = path.suffix == ".fmu" and path.parent.parts[-2:] == ("build", "fmus")
            hint = f"; `railgrip build {path.stem}` makes one in build/fmus of the current folder" if is_recipe else ""
            raise table_error(
                f"names '{cut(entry)}', but there is no file {place(path)}; a path in a file starts at its folder, one "
                f"of --set at the current folder{hint}"
            )
        if isinstance(entry, OtherFileString):
            entry = _relative(path, directory)
        return cls(entry=entry, path=path)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(
            cls.find,
            json_schema_input_schema=core_schema.str_schema(min_length=1),
            serialization=core_schema.plain_serializer_function_ser_schema(lambda file: file.entry, when_used="json"),
        )


_DEEPEST = 12
"""Maximum depth of tables and lists; the deepest file of the library has five."""

_PART = re.compile(r"""[A-Za-z0-9_-]+|"[^"]*"|'[^']*'""")
_KEY = re.compile(rf"(?:{_PART.pattern})(?:\s*\.\s*(?:{_PART.pattern}))*")


_KINDS_OF_ONE_FILTER = ("fmu", "compiled", "python")


def inline_toml(value: Any) -> str:
    """Return a value of tables that were read from TOML as TOML in one line."""
    if isinstance(value, Mapping):
        table = cast("Mapping[str, Any]", value)
        return f"{{ {', '.join(f'{_toml_key(key)} = {inline_toml(inner)}' for key, inner in table.items())} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(inline_toml, cast('Sequence[Any]', value)))}]"
    return json.dumps(value, ensure_ascii=False)  # of texts, numbers and flags the same in TOML


def _toml_key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key, ensure_ascii=False)


def parse_toml(text: str) -> TomlTable:
    """Return the tables of a TOML text.

    Raises:
        TOMLDecodeError: The text is not TOML, or hostile: nested too deep, or an integer of thousands of digits.
    """
    try:
        table = tomllib.loads(text)
        _require_shallow(table, _DEEPEST)
    except RecursionError:
        raise tomllib.TOMLDecodeError(f"its tables are nested deeper than {_DEEPEST} levels") from None
    except ValueError as problem:
        if isinstance(problem, tomllib.TOMLDecodeError):
            raise
        raise tomllib.TOMLDecodeError("it has a number of thousands of digits, or an invalid date") from None
    return table


def _require_shallow(value: Any, levels: int) -> None:
    if not isinstance(value, dict | list):
        return
    if not levels:
        raise RecursionError
    for inner in cast("Iterable[Any]", value.values() if isinstance(value, dict) else value):
        _require_shallow(inner, levels - 1)


_ELEMENT = re.compile(r"(.+)\[(\d{1,9})\]")
"""Key of an element of an array, such as `r_wheel[2]`."""


def merge(base: Mapping[str, Any], change: Mapping[str, Any]) -> TomlTable:
    """Return `base` with the keys of `change` overlaid, table by table.

    A change of a table's `kind` discards the other keys, because another kind has other keys; kinds of the same filter,
    which differ only in its computation, have the same keys.

    The value of an array element is that of the highest layer that names it: `r_wheel`, a list or one value for all,
    names all elements, and `"r_wheel[2]"` the second. A layer with both a list and an element of it is not resolved
    here; `railgrip.scenario.table.Parameters` rejects it.
    """
    result = {key: value for key, value in base.items() if _array_of(key) not in change}
    for key, value in change.items():
        below = result.get(key)
        if isinstance(value, Mapping) and isinstance(below, Mapping) and _has_keys_of(below, value.get("kind")):
            result[key] = merge(below, value)
        elif isinstance(value, Mapping):
            result[key] = merge({}, value)
        elif (array := _array_of(key)) is None or array in change or not _replace(result, array, key, value):
            result[key] = value
    return result


def _array_of(key: Any) -> str | None:
    element = _ELEMENT.fullmatch(key) if isinstance(key, str) else None
    return element[1] if element else None


def _replace(table: TomlTable, array: str, key: str, value: Any) -> bool:
    values, index = table.get(array), int(key[len(array) + 1 : -1]) - 1
    if not isinstance(values, list | tuple) or not 0 <= index < len(values):
        return False
    table[array] = [*values[:index], value, *values[index + 1 :]]
    return True


_PLANT = ("plant", "model", "library", "train")
"""Keys of [vehicle] that select the plant."""


def with_another_plant(vehicle: Mapping[str, Any], keys: Mapping[str, Any]) -> TomlTable:
    """Return the keys of a [vehicle] overridden by others; if these select a plant, it replaces the former one."""
    names_one = any(key in keys for key in _PLANT)
    return merge({key: value for key, value in vehicle.items() if not (names_one and key in _PLANT)}, keys)


def _has_keys_of(table: Mapping[str, Any], kind: object) -> bool:
    present = table.get("kind")
    return (
        kind is None or present == kind or (kind in _KINDS_OF_ONE_FILTER and present in (*_KINDS_OF_ONE_FILTER, None))
    )


def parts_of(key: Any) -> tuple[str, ...]:
    """Return the parts of a dotted key; a part with dots or brackets is quoted, as in TOML.

    Raises:
        ScenarioError: The key is malformed.
    """
    if not isinstance(key, str) or not _KEY.fullmatch(key):
        raise ScenarioError(
            f"{short(key)} is not a key such as start.speed; "
            'a part with brackets takes quotes: vehicle.parameters."r_wheel[2]"'
        )
    parts = tuple(part[1:-1] if part[0] in "\"'" else part for part in _PART.findall(key))
    if len(parts) > _DEEPEST:
        raise ScenarioError(f"{short(key)} has {len(parts)} parts; tables are nested {_DEEPEST} levels deep at most")
    return parts


def nest(changes: Mapping[str, Any]) -> TomlTable:
    """Return dotted keys and their values, which are not changed, as one tree of tables.

    Raises:
        ScenarioError: A key is malformed; see `parts_of`.
    """
    tree: TomlTable = {}
    for key, value in changes.items():
        layer: Any = value
        for part in reversed(parts_of(key)):
            layer = {part: layer}
        try:
            _require_shallow(layer, _DEEPEST)
        except RecursionError:
            raise ScenarioError(f"the value of {short(key)} is nested deeper than {_DEEPEST} levels") from None
        _insert(tree, layer)
    return tree


def read_overrides(overrides: Sequence[str]) -> TomlTable:
    """Return strings `table.key=value` as one tree of tables.

    The value is parsed as TOML (`5`, `true`, `[1, 2]`, `"text"`), and otherwise used as plain text, so that
    `start.speed=80 km/h` needs no quotes. For keys see `parts_of`: `vehicle.parameters."r_wheel[2]"=0.37`. Paths are
    relative to the current folder, as elsewhere on a command line.

    Raises:
        ScenarioError: An override is malformed.
    """
    tree: TomlTable = {}
    for override in overrides:
        key, equals, value = override.partition("=")
        if not equals or not key.strip() or not value.strip():
            raise ScenarioError(f"--set {cut(override)}: expected is table.key=value, such as start.speed='80 km/h'")
        try:
            _insert(tree, nest({key.strip(): _toml_value(value.strip())}))
        except ScenarioError as problem:
            raise ScenarioError(f"--set {cut(override)}: {problem}") from None
    return OtherFileString.within(tree, Path.cwd())


def _insert(tree: TomlTable, layer: Mapping[str, Any]) -> None:
    # Unlike in files, a `kind` does not discard other keys, whatever their order.
    for key, value in layer.items():
        below = tree.get(key)
        if isinstance(value, Mapping) and isinstance(below, dict):
            _insert(below, value)
        else:
            tree[key] = merge({}, value) if isinstance(value, Mapping) else value


def _toml_value(text: str) -> Any:
    try:
        table = parse_toml(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    # A text with a newline could continue with other keys after its value.
    return table["value"] if len(table) == 1 else text
