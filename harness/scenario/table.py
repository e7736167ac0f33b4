"""Common base of all tables of a scenario file: strictness, common quantities, errors of validators, tables by kind.

The keys of a table may depend on its kind: there is a built-in class for each kind, or a user-defined class.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Self, cast, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    PlainValidator,
    StrictInt,
    ValidationInfo,
    model_validator,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from railgrip.base import registry
from railgrip.base.groups import gather
from railgrip.base.names import did_you_mean
from railgrip.base.tables import TomlTable
from railgrip.base.units import short
from railgrip.scenario.quantity import InList, Parameter, UnitRange

FASTEST = 160.0  # m/s
_FASTEST = "no train on wheels has been faster than 159.7 m/s (574.8 km/h in 2007)"
_WHY_THREE_HOURS = "no braking lasts three hours"

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", max_length=100)]
"""Name of a folder: a plain name that cannot leave the parent folder and is not too long."""
Seed = Annotated[StrictInt, Field(ge=0, lt=2**63)]
Friction = Annotated[
    float, UnitRange("1", above=0, at_most=1, usual=(0.01, 0.6), because="dry rail carries up to 0.5 (Polach, 2005)")
]
Speed = Annotated[float, UnitRange("m/s", above=0, at_most=FASTEST, usual=(0.0, 95.0), because=_FASTEST)]
StartSpeed = Annotated[float, UnitRange("m/s", between=(0, FASTEST), or_zero=True, usual=(2.0, 70.0), because=_FASTEST)]
Duration = Annotated[float, UnitRange("s", above=0, at_most=10800, because=_WHY_THREE_HOURS)]
Period = Annotated[
    float,
    UnitRange(
        "s",
        between=(1e-6, 60),
        usual=(1e-5, 1.0),
        because="nothing in a train is sampled in less than 1 us, or once a minute; a period is 1 over the frequency",
    ),
]
Delay = Annotated[float, UnitRange("s", between=(0, 10800), because=_WHY_THREE_HOURS)]
Lag = Annotated[
    float,
    UnitRange("s", between=(0, 10), usual=(0.0, 1.0), because="what a sensor shows so late is of another stop"),
]
Length = Annotated[float, UnitRange("m", between=(0, 1e5), because="no braking is longer than 100 km")]
Chainage = Annotated[float, UnitRange("m", between=(-1e7, 1e7), because="no line is longer than 10,000 km")]
Mass = Annotated[float, UnitRange("kg", above=0, at_most=1e8, because="the heaviest train weighed 1e8 kg")]
Deviation = Annotated[
    float,
    UnitRange("1", at_least=0, below=1, usual=(0.0, 0.1), because="sensors of trains err by some per cent at most"),
]
ModelicaClass = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*$", max_length=200)]
"""Full name of a class."""


def _elements(entry: Any) -> Any:
    # FMI names the elements of an array `x[1]`, `x[2]`.
    if not isinstance(entry, Mapping):
        return entry
    flat: TomlTable = {}
    table = cast("Mapping[str, Any]", entry)
    for name, value in table.items():
        if not isinstance(value, list | tuple):
            flat[name] = value
            continue
        elements = cast("Sequence[Any]", value)
        twice = next((key for key in table if key.startswith(f"{name}[")), None)
        if twice is not None:
            raise table_error(
                f"{name} is a list of {len(elements)}, and '{twice}' is given too; change the element in the list, "
                "which must have a value for each, and remove the other key"
            )
        if not elements:
            raise table_error(f"{name} is an empty list; give a value for each element, or leave it out")
        for index, element in enumerate(elements, start=1):
            flat[f"{name}[{index}]"] = InList(element, len(elements))
    return flat


Parameters = Annotated[
    dict[str, Parameter], BeforeValidator(_elements, json_schema_input_type=dict[str, Parameter | list[Parameter]])
]


class _OneOrEach:
    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        each = handler(source)
        return core_schema.no_info_before_validator_function(
            lambda entry: entry if isinstance(entry, list | tuple) else (entry,),
            each,
            json_schema_input_schema=core_schema.union_schema([handler(get_args(source)[0]), each]),
        )


ONE_OR_EACH = _OneOrEach()
"""Annotation of a tuple that may be written as one value for all elements."""


def table_error(words: str) -> PydanticCustomError:
    """Return the error for a key or table; the words follow its name in the message."""
    return PydanticCustomError("scenario", "{words}", {"words": words})


def optional(description: str | None = None, *, default: Any = None, max_length: int | None = None) -> Any:
    """Return a field that is omitted from results while it has its default."""
    return Field(
        default=default, exclude_if=lambda value: value == default, description=description, max_length=max_length
    )


def not_in(names: Collection[str], name: str, between: str = ", ") -> str:
    """Return the end of a message on an unknown name: the name, the known names, and the nearest one."""
    return f"{short(name)}; there is {between.join(names)}" + did_you_mean(name, names, before="; ")


def one_of(names: Collection[str], between: str = ", ") -> AfterValidator:
    """Return the annotation of a string that must be one of some names."""

    def known(name: str) -> str:
        if name not in names:
            raise table_error(f"is {not_in(names, name, between)}")
        return name

    return AfterValidator(known)


def ends_after_it_begins(table: Any) -> None:
    """Raise an error for a table whose `begin` and `end`, None for the end of the stop, are in reverse order."""
    if table.end is not None and table.end <= table.begin:
        raise table_error(f"end {table.end:g} s is not after begin {table.begin:g} s")


class Table(BaseModel):
    """A table of the file: frozen, and without unknown keys.

    A class and each of its bases may have a method `_check`, which raises `table_error` for values that do not fit
    together; that of a base is called first.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @model_validator(mode="after")
    def _check_all(self) -> Self:
        for kind in reversed(type(self).__mro__):
            if check := vars(kind).get("_check"):
                check(self)
        return self


def _map_entry(entry: Any) -> Any:
    if isinstance(entry, str | dict) or (
        isinstance(entry, list | tuple) and all(isinstance(element, str | dict) for element in entry)
    ):
        return entry
    raise table_error(
        f"is {entry!r}, expected is the name of an FMU variable, a list of names, "
        'or { variable = "…", unit = "…", scale = … }'
    )


MapEntry = Annotated[Any, PlainValidator(_map_entry, json_schema_input_type=str | TomlTable | list[str | TomlTable])]
"""Annotation of a mapping entry: signal of the harness → variable of a foreign FMU."""


class Custom(Table):
    """A user-defined class; see `railgrip.simulate.user_parts` for the required methods.

    `railgrip.simulate.user_parts` describes from where it is imported.
    """

    kind: str = Field(description="module:Class, or the name of an entry point in the group railgrip.<table>s")
    parameters: TomlTable = Field(default={}, description="arguments of the class, by keyword")


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
        kinds = gather((table, kind) for kind, table in self.ours().items())
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
