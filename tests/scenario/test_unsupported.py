"""Standard features of the field that are not supported are named as such, in train files and scenarios alike."""

import re
import tomllib
from itertools import product
from pathlib import Path

import pytest
from wrong import table

from railgrip.base.errors import ScenarioError
from railgrip.base.registry import DYNAMIC_BRAKES, modules, shelf
from railgrip.rolling_stock.schema import Train, train_of
from railgrip.scenario.keys import scenario_schema, schema_of
from railgrip.scenario.load import UNSUPPORTED, explain_unsupported, load
from railgrip.scenario.schema import Scenario

KEYS = table(__file__, "tables.toml")["unsupported"]


def train_with(place: str, key: str) -> Train:
    table = tomllib.loads(shelf("trains")["emu387"].read_text(encoding="utf-8"))
    {"top": table, "bogie": next(iter(table["bogies"].values())), "car": table["cars"][0]}[place][key] = {"force": 1.0}
    return train_of(table, "own.toml")


def scenario_with(table: str, key: str) -> Scenario:
    return load(Path("trapezoid"), [f"{table}{key}={{a=1}}"])


@pytest.mark.parametrize(
    ("read", "place"),
    [*product((train_with,), ("top", "bogie", "car")), *product((scenario_with,), ("", "vehicle.", "track."))],
)
@pytest.mark.parametrize(("key", "word"), KEYS.items())
def test_a_file_with_such_a_key_is_refused_with_an_explanation(key, word, read, place):
    with pytest.raises(ScenarioError, match=rf"has no key '{key}'; .*{word}.* not supported here; ") as refused:
        read(place, key)
    assert "did you mean" not in str(refused.value)


def names(schema: object) -> set[str]:
    """Return all names of properties in a JSON schema."""
    if isinstance(schema, list):
        return set().union(*map(names, schema))
    if not isinstance(schema, dict):
        return set()
    return set(schema.get("properties", ())).union(*(names(value) for value in schema.values()))


def test_no_key_of_a_file_is_listed_as_unsupported():
    supported = names(scenario_schema()) | names(schema_of(Train))
    assert {"track_brakes", "track_brake", "resistance", "demand"} <= supported
    assert [key for key in supported if explain_unsupported(key)] == []
    for name in modules(DYNAMIC_BRAKES):
        assert f"'{name}'" in explain_unsupported(name), f"[dynamic_brakes.NAME] has kind '{name}', and it is denied"


def test_each_entry_has_an_example_in_this_module():
    covered = {pattern for key in KEYS for pattern in UNSUPPORTED if re.fullmatch(pattern, key)}
    assert covered == UNSUPPORTED.keys()
