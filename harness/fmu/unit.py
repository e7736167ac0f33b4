"""Units as FMI 2.0 knows them: exponents of eight base units, a factor and an offset to SI.

An FMU defines its units in `UnitDefinitions`; ours are written in Modelica's unit syntax (`N.m`, `kg/m3`,
`km/h`). Both become a `Unit`, and values are converted only between units of the same dimension.
"""

import math
import re
from dataclasses import dataclass

from harness.fmu.failure import FmuError

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""Base units of FMI 2.0 (§2.2.2), in the order of `Unit.exponents`."""

Exponents = tuple[int, int, int, int, int, int, int, int]

_SYMBOLS: dict[str, tuple[dict[str, int], float]] = {
    **{base: ({base: 1}, 1.0) for base in BASE},
    "1": ({}, 1.0),
    "g": ({"kg": 1}, 1e-3),
    "N": ({"kg": 1, "m": 1, "s": -2}, 1.0),
    "J": ({"kg": 1, "m": 2, "s": -2}, 1.0),
    "W": ({"kg": 1, "m": 2, "s": -3}, 1.0),
    "Pa": ({"kg": 1, "m": -1, "s": -2}, 1.0),
    "bar": ({"kg": 1, "m": -1, "s": -2}, 1e5),
    "Hz": ({"s": -1}, 1.0),
    "V": ({"kg": 1, "m": 2, "s": -3, "A": -1}, 1.0),
    "Ohm": ({"kg": 1, "m": 2, "s": -3, "A": -2}, 1.0),
    "C": ({"s": 1, "A": 1}, 1.0),
    "l": ({"m": 3}, 1e-3),
    "t": ({"kg": 1}, 1e3),
    "min": ({"s": 1}, 60.0),
    "h": ({"s": 1}, 3600.0),
    "d": ({"s": 1}, 86400.0),
    "deg": ({"rad": 1}, math.pi / 180),
    "rev": ({"rad": 1}, 2 * math.pi),
    "rpm": ({"rad": 1, "s": -1}, 2 * math.pi / 60),
    "%": ({}, 1e-2),
}
_PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "d": 1e-1, "c": 1e-2, "m": 1e-3, "u": 1e-6, "n": 1e-9}
_OFFSETS = {"degC": 273.15}


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit:
    """A unit of measurement: SI value = factor · value + offset.

    Attributes:
        name: As written by its author.
        exponents: Of `BASE`, in that order.
        factor: To SI, not zero.
        offset: To SI; only temperatures have one.
    """

    name: str
    exponents: Exponents
    factor: float
    offset: float

    def __post_init__(self) -> None:
        """Refuse a factor that would make every value zero or infinite."""
        if not (math.isfinite(self.factor) and math.isfinite(self.offset)) or self.factor == 0:
            raise FmuError(
                f"unit '{self.name}' has factor {self.factor} and offset {self.offset}; "
                "both must be finite and the factor not 0."
            )

    @property
    def dimension(self) -> str:
        """The base units it is made of, as 'kg.m2.s-2'; '1' for a pure number."""
        parts = [f"{b}{e if e != 1 else ''}" for b, e in zip(BASE, self.exponents, strict=True) if e]
        return ".".join(parts) or "1"


def conversion(source: Unit, target: Unit, *, difference: bool = False) -> tuple[float, float]:
    """Return (gain, shift) so that value in `target` = gain · value in `source` + shift.

    Args:
        source: Unit of the value at hand.
        target: Unit wanted.
        difference: The value is a difference, so that offsets cancel (FMI's relativeQuantity).

    Raises:
        FmuError: The dimensions differ.
    """
    if source.exponents != target.exponents:
        raise FmuError(f"'{source.name}' ({source.dimension}) cannot become '{target.name}' ({target.dimension}).")
    gain = source.factor / target.factor
    return gain, 0.0 if difference else (source.offset - target.offset) / target.factor


def unit(text: str) -> Unit:
    """Return the unit that a Modelica unit string names, as 'kN.m/s2' or 'J/(kg.K)'.

    Raises:
        FmuError: Not a unit known here.

    Source: Modelica Specification 3.6, §19.1 (syntax of unit expressions).
    """
    if text in _OFFSETS:
        return Unit(name=text, exponents=_exponents({"K": 1}), factor=1.0, offset=_OFFSETS[text])
    powers: dict[str, int] = {}
    factor = 1.0
    numerator, slash, denominator = text.replace(" ", "").partition("/")
    for part, sign in ((numerator, 1), (denominator, -1)) if slash else ((numerator, 1),):
        bare = part[1:-1] if part.startswith("(") and part.endswith(")") else part
        for term in bare.split("."):
            match = re.fullmatch(r"([A-Za-z%]+|1)([+-]?\d+)?", term)
            if match is None:
                raise _unknown(text)
            symbol, power = match[1], sign * int(match[2] or 1)
            dimension, size = _symbol(symbol, text)
            factor *= size**power
            for base, exponent in dimension.items():
                powers[base] = powers.get(base, 0) + exponent * power
    return Unit(name=text, exponents=_exponents(powers), factor=factor, offset=0.0)


def _symbol(symbol: str, text: str) -> tuple[dict[str, int], float]:
    if symbol in _SYMBOLS:
        return _SYMBOLS[symbol]
    prefix, rest = symbol[:1], symbol[1:]
    if prefix in _PREFIXES and rest in _SYMBOLS and rest != "1":
        dimension, size = _SYMBOLS[rest]
        return dimension, _PREFIXES[prefix] * size
    raise _unknown(text)


def _unknown(text: str) -> FmuError:
    return FmuError(
        f"'{text}' is not a unit known here; write it in Modelica's syntax from SI symbols, "
        "as 'N.m', 'km/h', 'bar' or 'J/(kg.K)'."
    )


def _exponents(powers: dict[str, int]) -> Exponents:
    kg, m, s, a, k, mol, cd, rad = (powers.get(base, 0) for base in BASE)
    return (kg, m, s, a, k, mol, cd, rad)
