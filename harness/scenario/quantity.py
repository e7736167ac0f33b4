"""Quantities with units as text ("80 km/h"), converted to SI floats when a file is read; plausible and usual ranges."""

import math
import operator
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Final, cast, get_args

from pydantic import BaseModel, Field, GetCoreSchemaHandler, Strict
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from railgrip.base import units
from railgrip.base.errors import ScenarioError
from railgrip.base.names import ElementName, did_you_mean
from railgrip.base.units import quantity, short, to_si, unit

_LIMITS = {"above": operator.gt, "at least": operator.ge, "below": operator.lt, "at most": operator.le}
"""Words for a limit → comparison of a value with it."""

_DENORMAL = f"too small to calculate with; give 0, or at least {sys.float_info.min:.2g}"
"""End of the message for a denormal number, which has lost digits and is not a meaningful quantity."""

_WITH_UNIT = core_schema.str_schema(pattern=r"^\s*[-+]?\.?\d")
"""Pattern of a number with its unit, for the schema that editors use."""


class UnitRange:
    """Annotation of a float field: its SI unit and range.

    `Annotated[float, UnitRange("m/s", above=0)]` accepts "80 km/h", which is converted after a check of its dimension,
    and 22.2, which is in SI.
    """

    def __init__(
        self,
        unit: str,
        *,
        above: float | None = None,
        at_least: float | None = None,
        below: float | None = None,
        at_most: float | None = None,
        between: tuple[float, float] | None = None,
        or_zero: bool = False,
        usual: tuple[float, float] | None = None,
        difference: bool = False,
        because: str = "",
    ) -> None:
        """Store unit and limits.

        Args:
            unit: SI unit, "1" for a ratio.
            above: Lower limit in that unit, exclusive.
            at_least: Lower limit, inclusive.
            below: Upper limit, exclusive.
            at_most: Upper limit, inclusive.
            between: Both limits, inclusive.
            or_zero: Whether 0 is valid regardless of the limits.
            usual: Minimum and maximum of usual values; others within the limits are valid, but worth a remark.
            difference: Whether the value is a difference of temperatures, which "°C" does not express.
            because: Reason of the limits.
        """
        self.unit, self.or_zero, self.usual, self.difference = unit, or_zero, usual, difference
        self.because = f"; {because}" if because else ""
        at_least, at_most = between or (at_least, at_most)
        self.limits = dict(zip(_LIMITS, (above, at_least, below, at_most), strict=True))

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Parse before pydantic validates: the result is a float in `unit`."""
        above, at_least, below, at_most = self.limits.values()
        at_least = 0.0 if self.or_zero else at_least
        si = core_schema.float_schema(gt=above, ge=at_least, lt=below, le=at_most)
        return core_schema.no_info_before_validator_function(
            self.read, handler(source), json_schema_input_schema=core_schema.union_schema([si, _WITH_UNIT])
        )

    def read(self, entry: object) -> float:
        """Return the SI value of an entry in a file.

        Raises:
            PydanticCustomError: The entry is not a number, has the wrong dimension, or is out of range.
        """
        if isinstance(entry, bool) or not isinstance(entry, int | float | str):
            raise _refusal(f"is {_spell(entry)}, but a number in {self._name} is expected")
        try:
            value = to_si(entry, self.unit) if isinstance(entry, str) else float(entry)
        except ValueError as problem:
            raise _refusal(str(problem)) from problem
        except OverflowError:  # an integer of more than 308 digits
            value = math.inf
        if self.difference and isinstance(entry, str) and (point := quantity(entry)[1]).offset:
            raise _refusal(
                f"is {_spell(entry)}, a temperature, but a difference of temperatures is expected; write it in K, "
                f"or without a unit ({point.name} has another zero than K)"
            )
        if not math.isfinite(value):
            raise _refusal(f"is {_spell(entry)}, but a finite number is expected")
        if 0.0 < abs(value) < sys.float_info.min:
            raise _refusal(f"is {_spell(entry)}, {_DENORMAL}")
        for words, limit in self.limits.items() if value or not self.or_zero else ():
            if limit is not None and not _LIMITS[words](value, limit):
                # A lower limit of zero needs no reason.
                reason = "" if limit == 0.0 else self.because
                suffix = "" if self.unit == "1" else f" {self.unit}"
                span = self._span(suffix)
                raise _refusal(f"must be {words} {limit:g}{suffix}, got {_spell(entry)}{span}{reason}")
        return value

    def doubt(self, value: float) -> str:
        """Return the words, after the name of a key, for a valid value that is not usual; '' for a usual one."""
        if self.usual is None or self.usual[0] <= value <= self.usual[1] or (self.or_zero and value == 0.0):
            return ""
        suffix, (low, high) = "" if self.unit == "1" else f" {self.unit}", self.usual
        bare = f"; a number without a unit is in {self.unit}" if suffix else ""
        return f"is {value:g}{suffix}; usual are {low:g} to {high:g}{suffix}{self.because}{bare}"

    def _span(self, suffix: str) -> str:
        above, at_least, below, at_most = self.limits.values()
        low, high = above if at_least is None else at_least, below if at_most is None else at_most
        return f"; expected is {'0, or ' * self.or_zero}{low:g} to {high:g}{suffix}" if low and high and low > 0 else ""

    @property
    def _name(self) -> str:
        return "no unit" if self.unit == "1" else repr(self.unit)


@dataclass(frozen=True, slots=True)
class InList:
    """An element of a list of parameters, as written.

    Attributes:
        entry: Value of the element.
        count: Number of elements of the list.
    """

    entry: object
    count: int


BOOLEAN: Final = "boolean"
"""Placeholder for the unit of a boolean parameter."""

Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
"""A number without a unit; unlike float it accepts neither booleans nor strings."""

NotNegative = Annotated[Number, Field(ge=0.0)]


class Magnitude:
    """A parameter of a model: the value in its unit, and the dimension if the file gives one.

    The model defines the expected unit, so the dimension can only be checked after the model has been read:
    `magnitude.si("Pa")`.

    Attributes:
        entry: Number or string, as written; for a `Parameter` also a boolean.
        count: Number of elements of the list that it is part of; None outside of lists.
    """

    __slots__ = ("count", "entry")

    takes_booleans: ClassVar[bool] = False

    def __init__(self, entry: float | str, count: int | None = None) -> None:
        """Store the entry of a file.

        Raises:
            ValueError: A string is not a number with a unit, or a number is not finite.
        """
        try:
            number = float(quantity(entry)[0] if isinstance(entry, str) else entry)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise ValueError(f"is {short(entry)}, but a finite number is expected")
        if 0.0 < abs(number) < sys.float_info.min:
            raise ValueError(f"is {short(entry)}, {_DENORMAL}")
        self.entry, self.count = entry, count

    def si(self, unit: str | units.Unit | None) -> float:
        """Return the value in a unit, usually an SI one ("kg.m2"); None, "" and "1" mean a ratio, `BOOLEAN` a bool.

        Raises:
            ValueError: The file gives a unit of another dimension, or a number in place of a boolean or the reverse;
                the message follows the parameter's name.
        """
        if unit == BOOLEAN:
            if self.entry not in (0, 1):
                raise ValueError(f"is {_spell(self.entry)}, but true or false is expected")
            return bool(self.entry)
        if isinstance(self.entry, bool):
            raise ValueError(f"is {_spell(self.entry)}, but a number or a text such as '3.4 bar' is expected")
        return to_si(self.entry, unit or "1") if isinstance(self.entry, str) else float(self.entry)

    def has_dimension_of(self, unit: str) -> bool:
        """Return whether the file gives a unit that can be converted to another one."""
        try:
            self.si(unit)
        except ValueError:
            return False
        return isinstance(self.entry, str)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Magnitude) and self.entry == other.entry

    def __hash__(self) -> int:
        return hash(self.entry)

    def __repr__(self) -> str:
        return f"Magnitude({self.entry!r})"

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Accept a number or a string with a unit, for a `Parameter` also booleans; serialise as written."""
        kinds = "a number, true, false" if cls.takes_booleans else "a number"

        def read(entry: object) -> "Magnitude":
            if isinstance(entry, Magnitude):
                return entry
            entry, count = (entry.entry, entry.count) if isinstance(entry, InList) else (entry, None)
            if not isinstance(entry, int | float | str) or (isinstance(entry, bool) and not cls.takes_booleans):
                raise _refusal(f"is {_spell(entry)}, but {kinds} or a text such as '3.4 bar' is expected")
            try:
                return cls(entry, count)
            except ValueError as problem:
                raise _refusal(str(problem)) from problem

        return core_schema.no_info_plain_validator_function(
            read,
            json_schema_input_schema=core_schema.union_schema(
                [core_schema.float_schema(), *([core_schema.bool_schema()] if cls.takes_booleans else []), _WITH_UNIT]
            ),
            serialization=core_schema.plain_serializer_function_ser_schema(lambda magnitude: magnitude.entry),
        )


class Parameter(Magnitude):
    """A parameter of a model that may also be a boolean, which is known only when the model has been read."""

    __slots__ = ()
    takes_booleans: ClassVar[bool] = True


_PLAUSIBLE: Mapping[str, tuple[float, float, str]] = {
    "kg": (0.0, 1e8, "the heaviest train weighed 1e8 kg"),
    "m": (-1e5, 1e5, "no stop is longer than 100 km"),
    "s": (0.0, 1e5, "no stop lasts a day"),
    "m/s": (-160.0, 160.0, "no train on wheels has been faster than 159.7 m/s"),
    "m/s2": (-1e3, 1e3, "more than a hundred times the acceleration of gravity is not braking"),
    "Pa": (-1e8, 1e8, "pneumatics and hydraulics of brakes stay below 1000 bar"),
    "N": (-1e7, 1e7, "a thousand tonnes rest on no axle, brake or spring"),
    "N.m": (-1e7, 1e7, "no wheelset takes a torque of 10 MN.m"),
    "kg.m2": (0.0, 1e6, "no wheelset has such an inertia"),
    "K": (0.0, 5e3, "steel boils at 3100 K"),
    "rad/s": (-1e4, 1e4, "no wheelset turns so fast"),
}
"""Unit → minimum and maximum of a parameter in it, with the reason.

The range exceeds that of any vehicle by an order of magnitude or more.
"""


def in_units(
    where: str,
    magnitudes: Mapping[str, Magnitude],
    expected: Mapping[str, str | units.Unit],
    descriptions: Mapping[str, str] | None = None,
    others: str = "",
) -> dict[str, float]:
    """Return the values of a table of parameters in the units that its model expects.

    Args:
        where: Table, and its file if there are several; the opening words of messages.
        magnitudes: Parameters by name.
        expected: Unit of every valid name.
        descriptions: Descriptions of these names, which help to suggest `m`, "Mass of the wagon", for "mass".
        others: Sentence on parameters that cannot be set, which follows that on an unknown name.

    Raises:
        ScenarioError: A name is unknown, a unit has another dimension, or a value is not plausible for a vehicle; one
            line per problem.
    """
    values: dict[str, float] = {}
    problems: list[str] = []
    lists = {ElementName.of(name).array: magnitude.count for name, magnitude in magnitudes.items() if magnitude.count}
    for array, count in lists.items():
        size = sum(name.startswith(f"{array}[") for name in expected)
        if size and size != count:
            problems.append(f"{where} {array} is a list of {count}, but there are {size} elements; give all of them.")
    for name, magnitude in magnitudes.items():
        if name not in expected:
            if lists.get(ElementName.of(name).array) and problems:
                continue
            arrays = sorted({ElementName.of(name).array for name in expected})  # a long train has hundreds of elements
            if name in arrays:
                hint = f'it is an array: write "{name}[1]" = … and so on, a key for each element.'
            else:
                # A name such as "mass" for the parameter `m`, "Mass of the wagon".
                near = _match_description(name, descriptions or {})
                hint = f"did you mean '{near[0]}'?" if near else did_you_mean(name, expected)
                hint = (hint or f"there is {', '.join(arrays) or 'none'}.") + others
            problems.append(f"{where} has no parameter '{short(name)[1:-1]}'; {hint}")
            continue
        try:
            values[name] = magnitude.si(expected[name])
            _require_plausible(f"{where} {name}", values[name], expected[name])
        except ScenarioError as problem:
            problems.append(str(problem))
        except ValueError as problem:
            problems.append(f"{where} {name} {problem}")
    if problems:
        raise ScenarioError("\n".join(problems))
    return values


def _match_description(name: str, descriptions: Mapping[str, str]) -> list[str]:
    words = ElementName.of(name).array.replace("_", " ").lower()
    return [other for other, text in descriptions.items() if f"{text.lower()} ".startswith(f"{words} ")][:1]


def _require_plausible(who: str, value: float, unit_of_value: str | units.Unit) -> None:
    # Values in units without a known range are not checked.
    try:
        expected_unit = unit(unit_of_value) if isinstance(unit_of_value, str) else unit_of_value
    except ValueError:
        return
    for name, (least, most, why) in _PLAUSIBLE.items():
        if unit(name).exponents == expected_unit.exponents:
            si = expected_unit.factor * value + expected_unit.offset
            if not least <= si <= most:
                raise ScenarioError(f"{who} must be between {least:g} and {most:g} {name}, got {si:g}; {why}.")


def _spell(entry: object) -> str:
    if isinstance(entry, bool):
        return str(entry).lower()
    if isinstance(entry, dict):
        return "a table"
    if isinstance(entry, list | tuple):
        return "a list"
    return short(entry)


def _refusal(words: str) -> PydanticCustomError:
    return PydanticCustomError("quantity", "{words}", {"words": words})


def unusual(table: BaseModel) -> Iterator[tuple[str, str]]:
    """Yield key and description of each valid value of a table that is not usual.

    The description follows the key, as in `is 500 m/s; usual are …`.
    """
    for key, span, value in quantities(table):
        if words := span.doubt(value):
            yield key, words


def quantities(table: BaseModel, key: str = "") -> Iterator[tuple[str, UnitRange, float]]:
    """Yield key, range and SI value of each quantity.

    Args:
        table: Table of a file.
        key: Key of that table; empty for the whole file.
    """
    for name, field in type(table).model_fields.items():
        value, path = getattr(table, name), f"{key}.{name}" if key else name
        for place, inner in _values_in(path, value):
            if isinstance(inner, BaseModel):
                yield from quantities(inner, place)
                continue
            span = _range_of(field.annotation, field.metadata)
            if span is not None and isinstance(inner, float):
                where, _, last = place.rpartition(".")
                yield f"[{where}] {last}" if where else last, span, inner


def _values_in(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, inner in cast("Mapping[str, Any]", value).items():
            yield from _values_in(f"{path}.{name}", inner)
    elif isinstance(value, tuple):
        values = cast("tuple[Any, ...]", value)
        for number, inner in enumerate(values, start=1):
            yield from _values_in(
                f"{path}[{number}]" if len(values) > 1 or isinstance(inner, BaseModel) else path, inner
            )
    else:
        yield path, value


def _range_of(annotation: Any, metadata: Any = ()) -> UnitRange | None:
    for entry in (*metadata, *getattr(annotation, "__metadata__", ())):
        if isinstance(entry, UnitRange):
            return entry
    return next((found for part in get_args(annotation) if (found := _range_of(part)) is not None), None)
