"""A value of any type at any key of the schema of a file is accepted or refused in a sentence."""

import datetime
import json
import tomllib
from collections.abc import Callable, Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from railgrip.base.errors import RailgripError
from railgrip.base.registry import shelf
from railgrip.cli.library import text_of_schema
from railgrip.estimation.spec import load_specification
from railgrip.rolling_stock.schema import train_of
from railgrip.scenario.campaign import campaign_of
from railgrip.scenario.load import scenario_of

SCENARIO = shelf("scenarios")["service_steps"]
CAMPAIGN = shelf("campaigns")["unseen"]
READERS: dict[str, tuple[Path, Callable[[dict[str, Any]], Any]]] = {
    "scenario": (SCENARIO, lambda table: scenario_of(table, directory=SCENARIO.parent, origin="odd.toml")),
    "campaign": (CAMPAIGN, lambda table: campaign_of(table, CAMPAIGN)),
    "train": (shelf("trains")["vt642"], lambda table: train_of(table, "odd.toml")),
    "estimation": (shelf("estimations")["wagon"], lambda table: load_specification(Path("wagon"), table)),
}
"""Kind → a file of the library and the reader of its tables."""

ODD = (
    [], [[]], [{}], {}, {"a": 1}, {"": []}, True, float("nan"), float("-inf"), 10**400, "", "\0",
    datetime.date(2020, 1, 1), datetime.time(7, 30), b"0",
)  # fmt: skip


def keys(schema: dict[str, Any], node: dict[str, Any], depth: int = 0) -> Iterator[tuple[str | int, ...]]:
    """Yield the path of each property of a schema; 0 is the first element of a list."""
    while "$ref" in node:
        node = schema["$defs"][node["$ref"].removeprefix("#/$defs/")]
    if depth > 5:
        return
    for choice in (*node.get("anyOf", ()), *node.get("oneOf", ()), *node.get("allOf", ())):
        yield from keys(schema, choice, depth)
    for name, inner in node.get("properties", {}).items():
        yield (name,)
        yield from ((name, *rest) for rest in keys(schema, inner, depth + 1))
    if isinstance(node.get("items"), dict):
        yield (0,)
        yield from ((0, *rest) for rest in keys(schema, node["items"], depth + 1))


def with_value(table: Any, place: tuple[str | int, ...], value: Any) -> Any:
    """Return a copy of a table with `value` at a path, whose missing tables and lists are created."""
    if not place:
        return value
    first, *rest = place
    if first == 0:
        elements = list(table) if isinstance(table, list) and table else [{}]
        return [with_value(elements[0], tuple(rest), value), *elements[1:]]
    inner = table if isinstance(table, dict) else {}
    return {**inner, first: with_value(inner.get(first), tuple(rest), value)}


def places(kind: str) -> list[tuple[str | int, ...]]:
    schema = json.loads(text_of_schema(kind))
    return sorted(set(keys(schema, schema)), key=str)


@pytest.mark.parametrize("kind", READERS)
def test_a_value_of_any_type_is_accepted_or_refused_in_a_sentence(kind):
    path, read = READERS[kind]
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    tried = places(kind)
    assert len(tried) >= 20, "the schema was not walked"
    failures = []
    for place in tried:
        for value in ODD:
            try:
                read(with_value(deepcopy(table), place, deepcopy(value)))
            except RailgripError as refusal:
                if not str(refusal):
                    failures.append(f"{place} = {value!r}: an empty sentence")
            except Exception as error:
                failures.append(f"{place} = {value!r}: {type(error).__name__}: {error}")
    assert not failures, "\n".join(failures)
