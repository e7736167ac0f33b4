"""Changes laid over a scenario's tables: `--set` on the command line, variants and sweeps in a campaign."""

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, cast

from railgrip.errors import ScenarioError
from railgrip.units import cut, short

_DEEPEST = 12
"""Levels of tables and lists; the deepest file of ours has five."""


_KINDS_OF_ONE_FILTER = ("fmu", "compiled", "python")


def parsed(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises:
        TOMLDecodeError: It is none, or none that anybody wrote: nested too deep, an integer of thousands of digits.
    """
    try:
        table = tomllib.loads(text)
        _demand_shallow(table, _DEEPEST)
    except RecursionError:
        raise tomllib.TOMLDecodeError(f"its tables are nested deeper than {_DEEPEST} levels") from None
    except ValueError as problem:
        if isinstance(problem, tomllib.TOMLDecodeError):
            raise
        raise tomllib.TOMLDecodeError("it has a number of thousands of digits, or a date that is none") from None
    return table


def _demand_shallow(value: Any, levels: int) -> None:
    if not isinstance(value, dict | list):
        return
    if not levels:
        raise RecursionError
    for inner in cast("Iterable[Any]", value.values() if isinstance(value, dict) else value):
        _demand_shallow(inner, levels - 1)


def merged(base: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
    """Return `base` with the keys of `change` laid over it, table by table.

    A change of a table's `kind` starts that table anew, because another kind has other keys; kinds of one filter, which
    differ only in how it is computed, have the same.
    """
    result = dict(base)
    for key, value in change.items():
        below = result.get(key)
        if not isinstance(value, Mapping):
            result[key] = value
        elif not isinstance(below, Mapping) or not _has_keys_of(below, value.get("kind")):
            result[key] = merged({}, value)
        else:
            result[key] = merged(below, value)
    return result


def _has_keys_of(table: Mapping[str, Any], kind: object) -> bool:
    """Say whether the keys of a table mean the same under another kind; None is no change of it."""
    own = table.get("kind")
    return kind is None or own == kind or (kind in _KINDS_OF_ONE_FILTER and own in (*_KINDS_OF_ONE_FILTER, None))


def read_overrides(overrides: Sequence[str]) -> dict[str, Any]:
    """Return `table.key=value` texts as one tree of tables.

    The value is read as TOML (`5`, `true`, `[1, 2]`, `"text"`), and as plain text where it is none, so that
    `start.speed=80 km/h` needs no quotes. A key with dots or brackets in it takes quotes, as in TOML:
    `vehicle.parameters."r_wheel[2]"=0.37`.

    Raises:
        ScenarioError: Not of that form.
    """
    tree: dict[str, Any] = {}
    for override in overrides:
        key, equals, value = override.partition("=")
        if not equals or not key.strip() or not value.strip():
            raise ScenarioError(f"--set {cut(override)}: wanted is table.key=value, such as start.speed='80 km/h'")
        try:
            layer = parsed(f"{key} = {_toml_value(value.strip())}")
        except tomllib.TOMLDecodeError as problem:
            raise ScenarioError(
                f"--set {cut(override)}: {short(key.strip())} is not a key such as start.speed; "
                'a part with brackets takes quotes: vehicle.parameters."r_wheel[2]"=0.37'
            ) from problem
        _insert(tree, layer)
    return tree


def _insert(tree: dict[str, Any], layer: Mapping[str, Any]) -> None:
    """Lay `layer` into `tree`; whatever the order of overrides, a `kind` takes away none of the others."""
    for key, value in layer.items():
        below = tree.get(key)
        if isinstance(value, Mapping) and isinstance(below, dict):
            _insert(below, value)
        else:
            tree[key] = merged({}, value) if isinstance(value, Mapping) else value


def _toml_value(text: str) -> str:
    """Return `text` itself if TOML reads it as a value, else as a TOML string."""
    try:
        parsed(f"value = {text}")
    except tomllib.TOMLDecodeError:
        content = text.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{content}"'
    return text
