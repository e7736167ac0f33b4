"""The JSON schemas accept every file of the library and refuse broken ones, as jsonschema reads them."""

import json
import tomllib

import jsonschema
import pytest
from wrong import REMOVED
from wrong import table as stored

from railgrip.base.registry import shelf
from railgrip.cli.library import text_of_schema

BASES = {"scenario": "trapezoid", "campaign": "table1", "train": "emu387", "estimation": "wagon"}
"""Kind → name of a file of the library."""
SCHEMAS = {kind: json.loads(text_of_schema(kind)) for kind in BASES}
FILES = [(kind, name) for kind in BASES for name in shelf(f"{kind}s")]


def table_of(kind, name):
    return tomllib.loads(shelf(kind)[name].read_text(encoding="utf-8"))


def problems(kind, table):
    validator = jsonschema.Draft7Validator(SCHEMAS[kind])
    return [f"{'.'.join(map(str, error.absolute_path))}: {error.message}" for error in validator.iter_errors(table)]


@pytest.mark.parametrize("kind", SCHEMAS)
def test_each_is_a_valid_draft_7_schema(kind):
    assert SCHEMAS[kind]["$schema"] == "http://json-schema.org/draft-07/schema#"
    jsonschema.Draft7Validator.check_schema(SCHEMAS[kind])


@pytest.mark.parametrize(("kind", "name"), FILES, ids=" ".join)
def test_every_file_of_the_library_is_valid_against_its_schema(kind, name):
    assert problems(kind, table_of(f"{kind}s", name)) == []


@pytest.mark.parametrize("name", shelf("equipment"))
def test_equipment_contains_only_changes_of_a_scenario(name):
    assert problems("scenario", {"extends": "trapezoid", **table_of("equipment", name)}) == []


def changed(table, key, value):
    """Return a table with another value at a dotted key, or without the key if the value is `REMOVED`."""
    first, _, rest = key.partition(".")
    if rest:
        return table | {first: changed(table.get(first, {}), rest, value)}
    return {k: v for k, v in table.items() if k != first} | ({} if value == REMOVED else {first: value})


BROKEN = stored(__file__, "broken.toml")


@pytest.mark.parametrize(
    ("kind", "key", "value"),
    [(kind, *case) for kind, cases in BROKEN.items() for case in cases],
    ids=lambda value: json.dumps(value).strip('"'),
)
def test_a_broken_file_is_refused(kind, key, value):
    table = table_of(f"{kind}s", BASES[kind])
    if kind == "scenario" and key.startswith("faults"):
        assert problems(kind, {**table, "faults": [{"part": "radar", "kind": "dead"}]}) == []
    assert problems(kind, changed(table, key, value))


EXTENDING = stored(__file__, "extending.toml")


@pytest.mark.parametrize("verdict", EXTENDING)
@pytest.mark.parametrize("kind", ["scenario", "estimation"])
def test_a_file_that_extends_another_contains_only_differences(kind, verdict):
    for table in EXTENDING[verdict][kind]:
        assert (problems(kind, table) == []) == (verdict == "accepted"), table


def descriptions(schema):
    """Yield table.key and its description, which may be that of its table."""
    defined = schema.get("$defs", {})
    for name, table in {"": schema, **defined}.items():
        for key, field in table.get("properties", {}).items():
            refs = [field.get("$ref", ""), *(one.get("$ref", "") for one in field.get("allOf", ()))]
            below = [defined.get(ref.removeprefix("#/$defs/"), {}).get("description", "") for ref in refs]
            own = table.get("description", "") if key in ("kind", "part") else ""  # the table describes its kind
            yield f"{name}.{key}", field.get("description") or next(filter(None, below), own)


@pytest.mark.parametrize("kind", SCHEMAS)
def test_every_key_has_a_description(kind):
    found = dict(descriptions(SCHEMAS[kind]))
    assert len(found) > {"scenario": 450, "campaign": 250, "train": 80, "estimation": 100}[kind]
    assert [key for key, description in found.items() if not description.strip()] == []
