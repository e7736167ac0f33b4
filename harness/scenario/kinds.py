"""Tables whose kind determines their keys: a built-in class for each kind, or a user-defined class."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, cast, get_args

from pydantic import BaseModel, Field, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from railgrip.base import registry
from railgrip.scenario.table import Table


class Custom(Table):
    """A user-defined class; see `railgrip.simulate.custom` for the required methods.

    `railgrip.simulate.importing` describes from where it is imported.
    """

    kind: str = Field(description="module:Class, or the name of an entry point in the group railgrip.<table>s")
    parameters: dict[str, Any] = Field(default={}, description="arguments of the class, by keyword")


def kinds_of(table: type[BaseModel]) -> tuple[str, ...]:
    """Return the kinds of a table; empty if any string is accepted."""
    field = table.model_fields.get("kind")
    return get_args(field.annotation) if field else ()


def by_kind(*tables: type[Table]) -> dict[str, type[Table]]:
    """Return kind → table."""
    return {kind: table for table in tables for kind in kinds_of(table)}


@dataclass(frozen=True, slots=True)
class ByKind:
    """Annotation of a field with a table of one of several kinds, read by the class for its kind.

    Attributes:
        ours: Function that returns kind → table of the built-in kinds.
        role: Role of user-defined classes; None if they are not allowed.
        custom: Table for user-defined classes.
    """

    ours: Callable[[], Mapping[str, type[Table]]]
    role: registry.Role | None = None
    custom: type[Table] = Custom

    def table_of(self, kind: object) -> type[Table] | None:
        """Return the table of a kind, or None."""
        if not isinstance(kind, str):
            return None
        if table := self.ours().get(kind):
            return table
        is_custom = self.role is not None and (":" in kind or kind in registry.installed_names(self.role))
        return self.custom if is_custom else None

    def read(self, entry: Any, info: ValidationInfo) -> Table:
        """Return the table of an entry.

        Raises:
            PydanticCustomError: The entry is not a table, lacks a kind, or its kind is unknown.
            ValidationError: There are errors in its keys.
        """
        if isinstance(entry, Table):
            return entry
        if not isinstance(entry, Mapping):
            raise PydanticCustomError("dict_type", "must be a table")
        if "kind" not in entry:
            raise PydanticCustomError("union_tag_not_found", "has no kind")
        kind = cast("Mapping[str, object]", entry)["kind"]
        if (table := self.table_of(kind)) is None:
            expected = ", ".join(self.ours()) + (", or your module:Class" if self.role else "")
            raise PydanticCustomError("union_tag_invalid", "no kind", {"tag": str(kind), "expected_tags": expected})
        return table.model_validate(entry, context=info.context)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, source: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        kinds: dict[type[Table], list[str]] = {}
        for kind, table in self.ours().items():
            kinds.setdefault(table, []).append(kind)
        choices: list[tuple[type[Table], Any]] = [(table, {"enum": names}) for table, names in kinds.items()]
        if self.role is not None:
            installed = list(registry.installed_names(self.role))
            custom = [{"type": "string", "pattern": ":"}, *({"const": name} for name in installed)]
            choices.append((self.custom, {"anyOf": custom}))
        return {
            "anyOf": [
                {"allOf": [handler(table.__pydantic_core_schema__)], "properties": {"kind": kind}, "required": ["kind"]}
                for table, kind in choices
            ]
        }
