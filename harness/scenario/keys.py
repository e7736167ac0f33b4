"""The keys of a scenario: JSON schemas for editors, SI units and meanings."""

import json
from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy
from functools import cache
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from railgrip.base.groups import gather
from railgrip.scenario.campaign import CampaignFile
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import ByKind

_CHANGE = "change."
"""Prefix of schemas in which all keys are optional."""


class _Generator(GenerateJsonSchema):
    """Pydantic's generator, adapted to TOML, which has no null, and to editors, which support draft 7."""

    schema_dialect = "http://json-schema.org/draft-07/schema#"

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        described = super().default_schema(schema)
        return {key: value for key, value in described.items() if key != "default" or value not in (None, "", [], {})}

    def tuple_schema(self, schema: core_schema.TupleSchema) -> JsonSchemaValue:
        described = super().tuple_schema(schema)
        if "prefixItems" in described:
            described |= {"items": described.pop("prefixItems"), "additionalItems": False}
        return described


def schema_of(model: type[BaseModel]) -> JsonSchemaValue:
    """Return the JSON schema of a file that is a pydantic model."""
    return {"$schema": _Generator.schema_dialect, **model.model_json_schema(schema_generator=_Generator)}


def extending_schema(model: type[BaseModel], kind: str) -> JsonSchemaValue:
    """Return the schema of a complete file, or of one with changes to the file that `extends` names."""
    name, schema = model.__name__, schema_of(model)
    dialect, tables = schema.pop("$schema"), schema.pop("$defs")
    changes = _any_key({**tables, name: schema})
    change = changes.pop(f"{_CHANGE}{name}")
    change["properties"]["extends"] = {
        "type": "string",
        "description": f"{kind} that this one is laid over: a name from the library, or a path from this file's folder",
    }
    return {
        "$schema": dialect,
        **change,
        "if": {"not": {"required": ["extends"]}},
        "then": {"$ref": f"#/$defs/{name}"},
        "$defs": {**tables, name: schema, **changes},
    }


def scenario_schema() -> JsonSchemaValue:
    """Return the schema of a scenario, whose name is optional and defaults to that of its file."""
    schema = extending_schema(Scenario, "scenario")
    schema["$defs"]["Scenario"]["required"].remove("name")
    return schema


def campaign_schema() -> JsonSchemaValue:
    """Return the schema of a campaign; a variant of an axis holds any tables of a scenario."""
    schema, scenario = schema_of(CampaignFile), schema_of(Scenario)
    changes = _any_key({**scenario.pop("$defs"), "Scenario": scenario})
    changes[f"{_CHANGE}Scenario"].pop("$schema")
    variant = {"anyOf": [{"type": "string"}, {"$ref": f"#/$defs/{_CHANGE}Scenario"}]}
    axes = {"additionalProperties": {"type": "object", "additionalProperties": variant}}
    schema["properties"]["axes"] |= axes
    schema["$defs"] |= changes
    return schema


def _any_key(tables: JsonSchemaValue) -> JsonSchemaValue:
    def relaxed(node: Any) -> Any:
        if isinstance(node, list):
            return [relaxed(inner) for inner in node]
        if not isinstance(node, dict):
            return node
        kept = {
            key: relaxed(value) for key, value in node.items() if not (key == "required" and isinstance(value, list))
        }
        if isinstance(kept.get("oneOf"), list):  # without its kind, a table matches several
            kept["anyOf"] = kept.pop("oneOf")
            kept.pop("discriminator", None)
        return kept

    text = json.dumps({f"{_CHANGE}{name}": relaxed(table) for name, table in deepcopy(tables).items()})
    return json.loads(text.replace('"#/$defs/', f'"#/$defs/{_CHANGE}'))


@cache
def units_of_keys() -> Mapping[str, str]:
    """Return key, as `start.speed`, → SI unit, without keys whose unit depends on the kind of their table."""
    return _unambiguous((key, entry.unit) for key, entry in entries_of(Scenario, "") if isinstance(entry, UnitRange))


@cache
def meanings_of_keys() -> Mapping[str, str]:
    """Return key → description, without keys whose description depends on the kind of their table."""
    return _unambiguous(
        (key, entry.description or "") for key, entry in entries_of(Scenario, "") if isinstance(entry, FieldInfo)
    )


def _unambiguous(pairs: Iterable[tuple[str, str]]) -> dict[str, str]:
    return {key: texts[0] for key, texts in gather(pairs).items() if len(set(texts)) == 1}


def entries_of(table: type[BaseModel], path: str) -> Iterator[tuple[str, FieldInfo | UnitRange]]:
    """Yield the keys of a table after `path`, at any depth, with their fields and units."""
    for name, field in table.model_fields.items():
        yield f"{path}{name}", field
        yield from _of_annotation(field.annotation, field.metadata, f"{path}{name}")


def _of_annotation(annotation: Any, metadata: Iterable[Any], key: str) -> Iterator[tuple[str, FieldInfo | UnitRange]]:
    for entry in metadata:
        if isinstance(entry, FieldInfo):
            yield from _of_annotation(None, entry.metadata, key)
        elif isinstance(entry, UnitRange):
            yield key, entry
        elif isinstance(entry, ByKind):
            for table in entry.ours().values():
                yield from entries_of(table, f"{key}.")
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield from entries_of(annotation, f"{key}.")
    elif hasattr(annotation, "__metadata__"):
        yield from _of_annotation(annotation.__origin__, annotation.__metadata__, key)
    else:
        for argument in get_args(annotation):
            yield from _of_annotation(argument, (), key)
