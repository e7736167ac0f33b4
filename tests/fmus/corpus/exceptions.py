"""Combinations that the compiler may refuse: context → patterns of features, those of `fnmatch`."""

from collections.abc import Mapping
from fnmatch import fnmatchcase

ITERATORS = (
    *("sum over an iterator", "product over an iterator", "sum over two iterators"),
    *("array over an iterator*", "array over two iterators"),
)
ORDERS = ("order of Booleans", "fill of a matrix", "power of a matrix", "sizes of a matrix", "sum over two iterators")
RANGES = ("range downwards", "range of Reals")
DIVISIONS = ("div", "div by *", "mod", "mod by *", "rem", "rem by *")
LINEAR = ("homotopy", "elementwise sum with a scalar", "elementwise difference with a scalar", "linspace")

REFUSED: Mapping[str, tuple[str, ...]] = {
    "*": (
        *("function returns a record", "recursive function", "integer of an enumeration", "symmetric", "ndims"),
        *("scalar of an array", "matrix of a vector", "max over an iterator"),
        *("function with an early return", "function with break", "function with modifiers"),
    ),
    "initial algorithm": ("*",),
    "algorithm": ("*",),
    "inner variable": ("*",),
    "constant of a package": ("*",),
    "parameter": ORDERS,
    "final parameter": ORDERS,
    "constant": ORDERS,
    "modifier": ORDERS,
    "modifier of an extends clause": ORDERS,
    "when clause": ITERATORS,
    "when clause in an algorithm": ("*",),
    "condition of a when clause": RANGES + ITERATORS,
    "argument of a function": (*LINEAR, "range of Reals"),
    "start value": ("power of a matrix",),
    "reinit": ITERATORS,
    "for equation": DIVISIONS + ITERATORS,
}
"""Combinations that are right or refused with file and line; all others must be right."""


def may_be_refused(feature: str, context: str) -> bool:
    """Return whether a feature need not be supported in a context."""
    return any(fnmatchcase(feature, pattern) for place in ("*", context) for pattern in REFUSED.get(place, ()))
