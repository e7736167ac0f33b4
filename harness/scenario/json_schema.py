"""JSON schemas of files, which editors use for completion and checks."""

import json
from copy import deepcopy
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from railgrip.scenario.campaign import CampaignFile
from railgrip.scenario.schema import Scenario

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


def schema_of(model: type[BaseModel]) -> dict[str, Any]:
    """Return the JSON schema of a file that is a pydantic model."""
    return {"$schema": _Generator.schema_dialect, **model.model_json_schema(schema_generator=_Generator)}


def extending_schema(model: type[BaseModel], kind: str) -> dict[str, Any]:
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


def scenario_schema() -> dict[str, Any]:
    """Return the schema of a scenario, whose name is optional and defaults to that of its file."""
    schema = extending_schema(Scenario, "scenario")
    schema["$defs"]["Scenario"]["required"].remove("name")
    return schema


def campaign_schema() -> dict[str, Any]:
    """Return the schema of a campaign; a variant of an axis holds any tables of a scenario."""
    schema, scenario = schema_of(CampaignFile), schema_of(Scenario)
    changes = _any_key({**scenario.pop("$defs"), "Scenario": scenario})
    changes[f"{_CHANGE}Scenario"].pop("$schema")
    variant = {"anyOf": [{"type": "string"}, {"$ref": f"#/$defs/{_CHANGE}Scenario"}]}
    axes = {"additionalProperties": {"type": "object", "additionalProperties": variant}}
    schema["properties"]["axes"] |= axes
    schema["$defs"] |= changes
    return schema


def _any_key(tables: dict[str, Any]) -> dict[str, Any]:
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
