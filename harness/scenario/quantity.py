"""Numbers with units as people write them ("80 km/h"), made SI floats at the edge of the scenario file."""

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol

import pint
from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

_NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")
_SPELLINGS = {"‰": "permille", "kmh": "km/h", "µ": "u"}


class _Measure(Protocol):
    """What we use of a pint quantity (pint's own types change with its registry)."""

    magnitude: float
    units: object
    unitless: bool

    def to(self, unit: str, /) -> "_Measure": ...


@cache
def _registry() -> Any:
    registry = pint.UnitRegistry()
    registry.define("@alias turn = rev")  # as drawings write revolutions
    return registry


def _measure(text: str) -> _Measure:
    """Return number times unit; no arithmetic, so that a scenario file stays data.

    Raises:
        ValueError: The text is not one number and one unit, with the reason.
    """
    match = _NUMBER_AND_UNIT.fullmatch(text)
    if match is None:
        raise ValueError(f"is {text!r}, which is not a number with a unit such as '80 km/h'")
    number, unit = match.groups()
    for written, known in _SPELLINGS.items():
        unit = unit.replace(written, known)
    try:
        return _registry().Quantity(float(number), unit or "dimensionless")
    except Exception as problem:  # pint raises its own, tokenize's and Python's errors for an unreadable unit
        raise ValueError(f"is {text!r}, whose unit {unit!r} is unknown") from problem


def to_si(text: str, unit: str) -> float:
    """Return the value of `text` in the SI unit `unit`.

    Args:
        text: A number followed by any unit of the same dimension, for example "3.4 bar".
        unit: The SI unit wanted, as pint spells it; "1" for a ratio.

    Raises:
        ValueError: With the rest of a sentence that begins with the key's name.
    """
    measure = _measure(text)
    try:
        return float(measure.to("dimensionless" if unit == "1" else unit).magnitude)
    except pint.DimensionalityError as problem:
        if measure.unitless:
            raise ValueError(
                f"is {text!r}, which names no unit; write one of the dimension of {unit!r}, "
                f"or a bare number in {unit!r}"
            ) from problem
        raise ValueError(f"is {text!r}, but '{measure.units:~}' cannot be converted to {unit!r}") from problem


@dataclass(frozen=True, slots=True, kw_only=True)
class _Range:
    above: float | None
    at_least: float | None
    below: float | None
    at_most: float | None

    def broken(self, value: float) -> str | None:
        """Return the words of the first limit that `value` does not keep, or None."""
        if self.above is not None and value <= self.above:
            return f"above {self.above:g}"
        if self.at_least is not None and value < self.at_least:
            return f"at least {self.at_least:g}"
        if self.below is not None and value >= self.below:
            return f"below {self.below:g}"
        if self.at_most is not None and value > self.at_most:
            return f"at most {self.at_most:g}"
        return None


class Unit:
    """Annotation of a float field: its SI unit and range.

    `Annotated[float, Unit("m/s", above=0)]` accepts "80 km/h" (converted, dimension checked) and 22.2 (taken
    as SI).
    """

    def __init__(
        self,
        unit: str,
        *,
        above: float | None = None,
        at_least: float | None = None,
        below: float | None = None,
        at_most: float | None = None,
    ) -> None:
        """Take the SI unit, "1" for a ratio, and the limits of the value in that unit."""
        self.unit = unit
        self.range = _Range(above=above, at_least=at_least, below=below, at_most=at_most)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Read before pydantic does: what leaves here is a float in `unit`."""
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def read(self, written: object) -> float:
        """Return the SI value of what the file says.

        Raises:
            PydanticCustomError: Not a number, wrong dimension, or out of range.
        """
        if isinstance(written, bool) or not isinstance(written, int | float | str):
            raise _refusal(f"is {_spell(written)}, but a number in {self._name} is wanted")
        try:
            value = to_si(written, self.unit) if isinstance(written, str) else float(written)
        except ValueError as problem:
            raise _refusal(str(problem)) from problem
        if not math.isfinite(value):
            raise _refusal(f"is {_spell(written)}, but a finite number is wanted")
        limit = self.range.broken(value)
        if limit is not None:
            suffix = "" if self.unit == "1" else f" {self.unit}"
            raise _refusal(f"must be {limit}{suffix}, got {_spell(written)}")
        return value

    @property
    def _name(self) -> str:
        return "no unit" if self.unit == "1" else repr(self.unit)


class Magnitude:
    """A parameter of an FMU: the SI value, and the dimension if the file states one.

    The unit that is wanted stands in the FMU, so the dimension can only be checked by whoever has read it:
    `magnitude.si("Pa")`.
    """

    __slots__ = ("written",)

    def __init__(self, written: float | str | bool) -> None:
        """Take what the file says.

        Raises:
            ValueError: A text that is not a number with a unit.
        """
        if isinstance(written, str):
            _measure(written)
        elif not math.isfinite(written):
            raise ValueError(f"is {written!r}, but a finite number is wanted")
        self.written = written

    def si(self, unit: str | None) -> float:
        """Return the value in `unit`, an SI unit as FMI spells it ("kg.m2"); None, "" and "1" mean a ratio.

        Raises:
            ValueError: The file states a unit of another dimension, in words that follow the parameter's
            name.
        """
        if isinstance(self.written, str):
            spelled = re.sub(r"([A-Za-z])(-?\d)", r"\1**\2", unit or "1").replace(".", "*")
            return to_si(self.written, spelled)
        return float(self.written)

    def __eq__(self, other: object) -> bool:
        """Say whether both were written alike."""
        return isinstance(other, Magnitude) and self.written == other.written

    def __hash__(self) -> int:
        """Hash what was written."""
        return hash(self.written)

    def __repr__(self) -> str:
        """Show what was written."""
        return f"Magnitude({self.written!r})"

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Accept a number, a truth value or a text with a unit; serialise as written."""

        def read(written: object) -> "Magnitude":
            if isinstance(written, Magnitude):
                return written
            if not isinstance(written, bool | int | float | str):
                raise _refusal(f"is {_spell(written)}, but a number, true/false or '3.4 bar' is wanted")
            try:
                return cls(written)
            except ValueError as problem:
                raise _refusal(str(problem)) from problem

        return core_schema.no_info_plain_validator_function(
            read,
            serialization=core_schema.plain_serializer_function_ser_schema(lambda magnitude: magnitude.written),
        )


def _spell(written: object) -> str:
    if isinstance(written, bool):
        return str(written).lower()
    if isinstance(written, dict):
        return "a table"
    if isinstance(written, list | tuple):
        return "a list"
    return repr(written)


def _refusal(words: str) -> PydanticCustomError:
    return PydanticCustomError("quantity", "{words}", {"words": words})
