"""The system of units for scenarios, variables of FMUs and recorded columns.

The radian is a base dimension, as in FMI 2.0: an angular velocity is not a frequency, and the factor between both (2π,
or 1) is never guessed. Only the units in units.txt are valid, so that a text is never a unit by accident ("kmph" is
km/h here, not a thousand miles per hour). Units are written in Modelica's syntax (`kg.m2/s2`, `J/(kg.K)`) or in common
notation (`kg*m**2`, `m/s²`, `°C`).
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Final

from railgrip.base.errors import UnitError
from railgrip.base.names import did_you_mean

DEFINITIONS = Path(__file__).with_name("units.txt")
"""All units, in pint's format."""

GRAVITY: Final = 9.81
"""Acceleration of gravity [m/s2], as in the Modelica package RailBraking; C code gets it from here."""

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""Base units of FMI 2.0 (§2.2.2), in the order of `Unit.exponents`."""

_ROOTS = ("kilogram", "meter", "second", "ampere", "kelvin", "mole", "candela", "radian")
_ANGLE = BASE.index("rad")
_WITH_PREFIX = {
    *("gram", "meter", "second", "ampere", "kelvin", "mole", "radian", "newton", "joule", "watt", "pascal", "bar"),
    *("hertz", "volt", "ohm", "coulomb", "liter"),
}
_SPELLINGS = {
    **{"‰": "permille", "%": "percent", "°C": "degC", "°F": "degF", "°": "deg", "µ": "u", "μ": "u", "Ω": "Ohm"},
    **{"Ω": "Ohm", "·": "*", "⋅": "*", "²": "2", "³": "3", "⁻¹": "-1", "⁻²": "-2"},
    **{"g_0": "g_n", "g0": "g_n", "g₀": "g_n"},
}
_GRAMS = re.compile(r"\s*m?g\s*")
"""Mass symbols that accelerometers use for multiples of the acceleration of gravity."""
_SYMBOL = r"[A-Za-z_]+"
_TERM = rf"(?:1|{_SYMBOL}(?:(?:\*\*|\^)?[+-]?[1-9])?)"
_PRODUCT = rf"{_TERM}(?:[*.]{_TERM})*"
# After a slash without parentheses only one term is accepted: "J/kg.K" is ambiguous.
_QUOTIENT = re.compile(rf"({_PRODUCT})((?:/(?:{_TERM}|\({_PRODUCT}\)))*)")
_BY_RATIO = re.compile(rf"/\(({_SYMBOL})/({_SYMBOL})\)(?:\*\*|\^)?([1-9]?)")
"""A division by a power of a ratio, as in `N/(km/h)2`, which is `N*h2/km2`."""
_BRACKETED = re.compile(rf"/\(({_SYMBOL})\)(?![A-Za-z_(])")
_POWER = re.compile(rf"({_SYMBOL})(?:\*\*|\^)?([+-]?[1-9])?")
_NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL)
_MAX_LENGTH = 200  # characters of a quantity; the longest unit in any file of this project has 20

Exponents = tuple[int, ...]
"""One number for each of `BASE`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit:
    """A unit of measurement: SI value = factor · value + offset.

    Attributes:
        name: Name as written by its author.
        exponents: Exponents of `BASE`, in that order.
        factor: Factor to SI, not zero.
        offset: Offset to SI; nonzero only for temperatures.
    """

    name: str
    exponents: Exponents
    factor: float
    offset: float

    def __post_init__(self) -> None:
        """Raise an error for a factor that would make every value zero or infinite."""
        if not (math.isfinite(self.factor) and math.isfinite(self.offset)) or self.factor == 0:
            raise UnitError(
                f"unit '{self.name}' has factor {self.factor} and offset {self.offset}; "
                "both must be finite and the factor not 0."
            )

    @property
    def dimension(self) -> str:
        """Product of base units, as 'kg.m2.s-2'; '1' for a pure number."""
        parts = [f"{b}{e if e != 1 else ''}" for b, e in zip(BASE, self.exponents, strict=True) if e]
        return ".".join(parts) or "1"

    def __truediv__(self, divisor: "Unit") -> "Unit":
        """Return the unit of a quotient; temperatures in it are differences."""
        quotient = Unit(
            name=f"{self.name}/{divisor.name}",
            exponents=tuple(ours - theirs for ours, theirs in zip(self.exponents, divisor.exponents, strict=True)),
            factor=self.factor / divisor.factor,
            offset=0.0,
        )
        # A slash before a product or quotient would divide by its first factor only.
        return quotient if divisor.name.isalnum() else replace(quotient, name=quotient.dimension)

    def leaves_the_angle_out_of(self, other: "Unit") -> bool:
        """Return whether `other` is this unit times an angle: rev/min, rad/min and deg/min, for 1/min."""
        *ours, angle = self.exponents
        *theirs, other_angle = other.exponents
        ratio = other.factor / self.factor
        return (
            ours == theirs
            and (angle, other_angle) == (0, 1)
            and any(math.isclose(ratio, factor, rel_tol=1e-9) for factor in (1.0, math.tau, math.tau / 360.0))
        )


def conversion(source: Unit, target: Unit, *, difference: bool = False) -> tuple[float, float]:
    """Return (gain, shift) so that value in `target` = gain · value in `source` + shift.

    If the target is an acceleration, "g" and "mg" are multiples of standard gravity, not masses.

    Args:
        source: Unit of the given value.
        target: Unit of the result.
        difference: Whether the value is a difference, for which offsets cancel (FMI's relativeQuantity).

    Raises:
        UnitError: The dimensions differ.
    """
    if target.exponents == _gravity().exponents and _GRAMS.fullmatch(source.name):
        source = replace(_gravity(), name=source.name, factor=_gravity().factor * source.factor / unit("g").factor)
    if source.exponents != target.exponents:
        raise UnitError(
            f"'{source.name}' ({source.dimension}) cannot become '{target.name}' ({target.dimension})"
            f"{_angle_hint(source, target)}."
        )
    gain = source.factor / target.factor
    return gain, 0.0 if difference else (source.offset - target.offset) / target.factor


@cache
def _gravity() -> Unit:
    return unit("g_n")


def turning_of(source: Unit, target: Unit) -> str:
    """Return 'min', 's' or 'h' if a frequency is used in place of a rotational speed, else ''.

    Revolutions and radians per time are both in use, 2π apart, so a guess would often be wrong.
    """
    *rest, angle = (a - b for a, b in zip(target.exponents, source.exponents, strict=True))
    if any(rest) or angle != 1 or source.exponents[:_ANGLE] != (0, 0, -1, 0, 0, 0, 0):
        return ""
    return next((name for name, size in (("min", 60.0), ("h", 3600.0)) if math.isclose(source.factor * size, 1.0)), "s")


def _angle_hint(source: Unit, target: Unit) -> str:
    time = turning_of(source, target)
    return f"; a rotational speed is written 'rev/{time}' or 'rad/{time}', which are 2π apart" if time else ""


@cache
def unit(text: str) -> Unit:
    """Return the unit of a text, as 'kN.m/s2', 'J/(kg.K)' or 'kg*m**2'; '' and '1' are a pure number.

    Raises:
        UnitError: The unit is unknown.

    Source: Modelica Specification 3.6, §19.1 (syntax of unit expressions).
    """
    product = text.strip()
    for spelling, plain in _SPELLINGS.items():
        product = product.replace(spelling, plain)
    product = re.sub(r"\s+", "*", re.sub(r"\s*(\*\*|[*./^()])\s*", r"\1", product))
    product = _BRACKETED.sub(r"/\1", _BY_RATIO.sub(r"*\2\3/\1\3", product))
    match = _QUOTIENT.fullmatch(product or "1") if len(text) <= _MAX_LENGTH else None
    if match is None:
        raise _unknown(text)
    exponents, factor = [0] * len(BASE), 1.0
    for part, sign in ((match[1], 1), (match[2], -1)):
        for symbol, digits in _POWER.findall(part):
            power = sign * int(digits or 1)
            symbol_unit = _symbol(symbol)
            if symbol_unit is None:
                raise _unknown(text)
            size, roots = symbol_unit
            factor *= size**power
            exponents = [e + power * roots.get(root, 0) for e, root in zip(exponents, _ROOTS, strict=True)]
    offset = _registry().Quantity(0.0, product).to_root_units().magnitude if product in ("degC", "degF") else 0.0
    return Unit(name=text, exponents=tuple(exponents), factor=factor, offset=offset)


def quantity(text: str) -> tuple[float, Unit]:
    """Return number and unit of a text such as "80 km/h"; arithmetic is not evaluated, so that a file stays data.

    Raises:
        UnitError: The text is not one number and one unit; the message follows a name.
    """
    match = _NUMBER_AND_UNIT.fullmatch(text) if len(text) <= _MAX_LENGTH else None
    if match is None:
        raise UnitError(f"is {short(text)}, which is not a number with a unit such as '80 km/h'")
    try:
        return float(match[1]), unit(match[2])
    except UnitError as problem:
        raise UnitError(f"is {short(text)}, whose unit {problem}") from problem


def to_si(text: str, target_unit: str | Unit) -> float:
    """Return the value of `text` in a unit.

    Args:
        text: A number followed by any unit of the same dimension, for example "3.4 bar".
        target_unit: Target unit, usually an SI one; "1" for a ratio.

    Raises:
        UnitError: The text or its dimension is wrong; the message follows a name.
    """
    number, source = quantity(text)
    target = unit(target_unit) if isinstance(target_unit, str) else target_unit
    try:
        gain, shift = conversion(source, target)
    except UnitError as problem:
        if not source.name:
            raise UnitError(
                f"is {short(text)}, which names no unit; write one of the dimension of {target.name!r}, "
                f"or a bare number in {target.name!r}"
            ) from problem
        raise UnitError(
            f"is {short(text)}, but '{source.name}' cannot be converted to {target.name!r}{_angle_hint(source, target)}"
        ) from problem
    return gain * number + shift


_MISTAKES = {
    "the other sign": -1.0, "km/h for m/s": 3.6, "m/s for km/h": 1 / 3.6, "km for m, or kPa for Pa": 1e-3,
    "m for km, or mm for m": 1e3, "bar for Pa": 1e-5, "Pa for bar": 1e5,
    "revolutions per second for rad/s": 1 / (2 * math.pi), "revolutions per minute for rad/s": 30 / math.pi,
    "percent for a ratio": 100.0, "multiples of g for m/s2": 1 / GRAVITY,
}  # fmt: skip
_ALIKE = 0.08
"""Relative tolerance: wheels differ from nominal by this much, and all pairs of mistakes by more."""


def mistaken_factor(ratio: float) -> float | None:
    """Return the factor of the mistake in `mistake`, or None."""
    return next((factor for factor in _MISTAKES.values() if abs(ratio / factor - 1) < _ALIKE), None)


def mistake(ratio: float) -> str:
    """Return the mistake of unit or sign that multiplies values by `ratio`, or ''."""
    return next((words for words, factor in _MISTAKES.items() if abs(ratio / factor - 1) < _ALIKE), "")


def short(value: object) -> str:
    """Return the representation of a value for a message, cut to a line."""
    try:
        return cut(repr(value))
    except ValueError:  # Python refuses to print integers of more than 4300 digits
        return "a number of thousands of digits"
    except Exception:  # a user's object may raise anything there
        return "what has no representation"


def cut(text: str, longest: int = 80) -> str:
    """Return a text unchanged, or its beginning and length if it is longer."""
    return text if len(text) <= longest else f"{text[:60]}… ({len(text)} characters)"


def place(path: Path) -> str:
    """Return a path for a message; the limit is longer than for other texts, since the file name comes last."""
    return cut(str(path), 255)


@cache
def _registry() -> Any:
    import pint  # imported here: half of the start-up of a foreign plant's process, which needs no new unit

    without_defaults: Any = None
    registry = pint.UnitRegistry(without_defaults)
    registry.load_definitions(DEFINITIONS)
    return registry


@cache
def _symbol(symbol: str) -> tuple[float, Mapping[str, int]] | None:
    # Only prefixed units in use are accepted, so no kilo-hour.
    prefix, name = _reading(symbol)
    # Names may be in the plural; symbols may not, or "kPas" would be a pressure.
    plural = symbol.endswith("s") and symbol != f"{prefix}{name}s" and _reading(symbol[:-1]) == (prefix, name)
    if not name or plural or (prefix and name not in _WITH_PREFIX):
        return None
    factor, roots = _registry().get_root_units(prefix + name, check_nonmult=False)
    return float(factor), {str(name): int(power) for name, power in roots._units.items()}


def _reading(symbol: str) -> tuple[str, str]:
    readings = _registry().parse_unit_name(symbol)
    return (readings[0][0], readings[0][1]) if readings else ("", "")


_REFERENCED = re.compile(r"(?P<unit>[kMh]?Pa|m?bar|psi)[ _]?\(?(?P<reference>a|abs|g|gauge|rel)\.?\)?")
"""Unit of a pressure that states whether it includes the pressure of the air, as barg and kPa(a)."""


def _unknown(text: str) -> UnitError:
    if found := _REFERENCED.fullmatch(text):
        unit_of_pressure, is_absolute = found["unit"], found["reference"].startswith("a")
        remedy = (
            f"subtract that of the air and write {unit_of_pressure}" if is_absolute else f"write {unit_of_pressure}"
        )
        return UnitError(f"{short(text)} is not a unit known here; pressures are above that of the air: {remedy}.")
    hint = did_you_mean(text, _COMMON) or "write it from SI symbols, as 'N.m', 'km/h', 'bar', 'J/(kg.K)'."
    return UnitError(f"{short(text)} is not a unit known here; {hint}")


_COMMON = (
    *("km/h", "m/s", "m/s2", "rad/s", "rev/min", "rev/s", "Hz", "1/s", "1/m", "bar", "Pa", "kPa", "N", "kN", "N.m"),
    *("kg", "t", "kg.m2", "m", "mm", "km", "s", "ms", "min", "h", "degC", "K", "%", "permille", "W", "kW", "s/m"),
)
