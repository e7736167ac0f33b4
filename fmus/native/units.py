"""Modelica unit strings as FMI unit definitions: exponents of the SI base units and a factor."""

import math
import re
from dataclasses import dataclass

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True, slots=True)
class Unit:
    """SI value = factor · value + offset; exponents are those of `BASE`."""

    exponents: tuple[int, ...]
    factor: float = 1.0
    offset: float = 0.0


def _of(factor: float = 1.0, offset: float = 0.0, **exponents: int) -> Unit:
    return Unit(tuple(exponents.get(b, 0) for b in BASE), factor, offset)


KNOWN = {b: _of(**{b: 1}) for b in BASE} | {
    "1": _of(),
    "g": _of(1e-3, kg=1),
    "t": _of(1e3, kg=1),
    "N": _of(kg=1, m=1, s=-2),
    "J": _of(kg=1, m=2, s=-2),
    "W": _of(kg=1, m=2, s=-3),
    "Wh": _of(3600.0, kg=1, m=2, s=-2),
    "Pa": _of(kg=1, m=-1, s=-2),
    "bar": _of(1e5, kg=1, m=-1, s=-2),
    "V": _of(kg=1, m=2, s=-3, A=-1),
    "Hz": _of(s=-1),
    "ms": _of(1e-3, s=1),
    "min": _of(60.0, s=1),
    "h": _of(3600.0, s=1),
    "km": _of(1e3, m=1),
    "cm": _of(1e-2, m=1),
    "mm": _of(1e-3, m=1),
    "l": _of(1e-3, m=3),
    "deg": _of(math.pi / 180, rad=1),
    "rev": _of(2 * math.pi, rad=1),
    "degC": _of(offset=273.15, K=1),
    "kN": _of(1e3, kg=1, m=1, s=-2),
    "kJ": _of(1e3, kg=1, m=2, s=-2),
    "kW": _of(1e3, kg=1, m=2, s=-3),
    "MW": _of(1e6, kg=1, m=2, s=-3),
    "MJ": _of(1e6, kg=1, m=2, s=-2),
    "kPa": _of(1e3, kg=1, m=-1, s=-2),
    "MPa": _of(1e6, kg=1, m=-1, s=-2),
    "GPa": _of(1e9, kg=1, m=-1, s=-2),
}


def parse(text: str) -> Unit | None:
    """Return the unit of a Modelica unit string such as `N.m/s2` or `W/(m2.K)`, or None if a part is unknown.

    Grammar: factors joined by `.`; after one `/` a factor or a parenthesis of factors.
    Source: Modelica specification, §19.1.
    """
    numerator, slash, denominator = text.partition("/")
    if denominator.startswith("(") and denominator.endswith(")"):
        denominator = denominator[1:-1]
    exponents, factor = [0] * len(BASE), 1.0
    offset = 0.0
    for part, sign in ((numerator, 1), (denominator, -1)):
        if part == "" and sign == -1 and not slash:
            continue
        for symbol in part.split("."):
            match = re.fullmatch(r"([A-Za-z]+|1)([+-]?\d*)", symbol)
            if not match or match[1] not in KNOWN:
                return None
            unit, power = KNOWN[match[1]], sign * int(match[2] or 1)
            factor *= unit.factor**power
            exponents = [e + power * k for e, k in zip(exponents, unit.exponents, strict=True)]
            offset = unit.offset if text == match[1] else offset
    return Unit(tuple(exponents), factor, offset)
