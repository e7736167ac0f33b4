"""Layers of a scenario: `extends`, the file, equipment, variants of a campaign, `--set` and changes in Python."""

import json
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from railgrip.base.errors import ScenarioError
from railgrip.base.units import cut, short
from railgrip.scenario.file import OtherFileString

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


def parse_toml(text: str) -> dict[str, Any]:
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


def merge(base: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
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


def _replace(table: dict[str, Any], array: str, key: str, value: Any) -> bool:
    values, index = table.get(array), int(key[len(array) + 1 : -1]) - 1
    if not isinstance(values, list | tuple) or not 0 <= index < len(values):
        return False
    table[array] = [*values[:index], value, *values[index + 1 :]]
    return True


_PLANT = ("plant", "model", "library", "train")
"""Keys of [vehicle] that select the plant."""


def with_another_plant(vehicle: Mapping[str, Any], keys: Mapping[str, Any]) -> dict[str, Any]:
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


def nest(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return dotted keys and their values, which are not changed, as one tree of tables.

    Raises:
        ScenarioError: A key is malformed; see `parts_of`.
    """
    tree: dict[str, Any] = {}
    for key, value in changes.items():
        layer = value
        for part in reversed(parts_of(key)):
            layer = {part: layer}
        try:
            _require_shallow(layer, _DEEPEST)
        except RecursionError:
            raise ScenarioError(f"the value of {short(key)} is nested deeper than {_DEEPEST} levels") from None
        _insert(tree, layer)
    return tree


def read_overrides(overrides: Sequence[str]) -> dict[str, Any]:
    """Return strings `table.key=value` as one tree of tables.

    The value is parsed as TOML (`5`, `true`, `[1, 2]`, `"text"`), and otherwise used as plain text, so that
    `start.speed=80 km/h` needs no quotes. For keys see `parts_of`: `vehicle.parameters."r_wheel[2]"=0.37`. Paths are
    relative to the current folder, as elsewhere on a command line.

    Raises:
        ScenarioError: An override is malformed.
    """
    tree: dict[str, Any] = {}
    for override in overrides:
        key, equals, value = override.partition("=")
        if not equals or not key.strip() or not value.strip():
            raise ScenarioError(f"--set {cut(override)}: expected is table.key=value, such as start.speed='80 km/h'")
        try:
            _insert(tree, nest({key.strip(): _toml_value(value.strip())}))
        except ScenarioError as problem:
            raise ScenarioError(f"--set {cut(override)}: {problem}") from None
    return OtherFileString.within(tree, Path.cwd())


def _insert(tree: dict[str, Any], layer: Mapping[str, Any]) -> None:
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
