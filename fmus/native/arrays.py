"""Arrays of scalar CasADi expressions, and Modelica's operators on them.

A Modelica value of any shape is a numpy object array of scalar `SX`; a scalar is 0-dimensional.
"""

import operator
import sys
from collections.abc import Callable, Iterable
from functools import reduce
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

SX = ca.SX
Array = NDArray[Any]


def array(values: Iterable[Any], shape: tuple[int, ...] = ()) -> Array:
    """Return an object array of `shape` filled row by row."""
    every = list(values)
    out = np.empty(len(every), dtype=object)
    for i, value in enumerate(every):
        out[i] = value  # with an integer index numpy stores the object itself, without a check for arrays
    return out.reshape(shape)


def as_array(value: Any) -> Array:
    """Return `value` as an array; numpy unwraps 0-dimensional results."""
    return value if isinstance(value, np.ndarray) else array([value])


def each(function: Callable[..., Any], count: int = 1) -> Callable[..., Array]:
    """Return `function` of `count` scalars, applied elementwise with broadcasting."""
    ufunc = np.frompyfunc(function, count, 1)
    return lambda *arguments: as_array(ufunc(*arguments))


def is_number(value: SX | float) -> bool:
    """Return whether an expression is a plain number."""
    return (value if isinstance(value, SX) else SX(value)).is_constant()


def integer(value: SX) -> int:
    """Return a constant expression as int."""
    return int(float(value))


def choose(condition: SX, yes: SX, no: SX) -> SX:
    """Return if-then-else; if the condition is a number, the chosen branch alone."""
    if is_number(condition):
        return yes if float(condition) else no
    return ca.if_else(condition, yes, no)


def _power(base: SX, exponent: SX) -> SX:
    # Small whole exponents as products: exact, fast, and differentiable at zero.
    if is_number(exponent) and float(exponent) == integer(exponent) and 0 <= integer(exponent) <= 4:
        return reduce(operator.mul, [base] * integer(exponent), SX(1))
    return base**exponent


def _truncation(value: SX) -> SX:
    return ca.if_else(value < 0, ca.ceil(value), ca.floor(value))


def _product(a: Array, b: Array) -> Array:
    return as_array(a * b if a.ndim == 0 or b.ndim == 0 else np.dot(a, b))


def _plain(function: Callable[[Array, Array], Any]) -> Callable[[Array, Array], Array]:
    # numpy applies an operator to the elements of object arrays itself.
    return lambda a, b: as_array(function(a, b))


_ARITHMETIC: dict[str, Callable[[Array, Array], Array]] = {
    "add": _plain(operator.add),
    "subtract": _plain(operator.sub),
    "multiply": _plain(operator.mul),
    "divide": _plain(operator.truediv),
    "power": each(_power, 2),
}
BINARY: dict[str, Callable[[Array, Array], Array]] = {
    **_ARITHMETIC,
    **{f"elementwise_{name}": function for name, function in _ARITHMETIC.items()},
    "multiply": _product,
    "less": each(operator.lt, 2),
    "less_equal": each(operator.le, 2),
    "greater": each(operator.gt, 2),
    "greater_equal": each(operator.ge, 2),
    "equal": each(operator.eq, 2),
    "not_equal": each(operator.ne, 2),
    "and": each(ca.logic_and, 2),
    "or": each(ca.logic_or, 2),
}
UNARY: dict[str, Callable[[Array], Array]] = {
    "negate": lambda a: as_array(-a),
    "plus": lambda a: a,
    "not": each(ca.logic_not),
}
_FUNCTIONS = "sqrt exp log log10 sin cos tan asin acos atan sinh cosh tanh sign floor ceil"  # the same names in CasADi
ELEMENTWISE: dict[str, Callable[..., Array]] = {name: each(getattr(ca, name)) for name in _FUNCTIONS.split()} | {
    "abs": each(ca.fabs),
    "integer": each(ca.floor),
    "no_event": lambda a: a,  # the front end lists only relations outside it as causes of events
    "atan2": each(ca.atan2, 2),
    "mod": each(lambda a, b: a - ca.floor(a / b) * b, 2),
    "rem": each(lambda a, b: a - _truncation(a / b) * b, 2),
    "div": each(lambda a, b: _truncation(a / b), 2),
    "smooth": lambda _order, value: value,
    "homotopy": lambda actual, _simple: actual,
}


def _fold(pair: Callable[[SX, SX], SX], neutral: float) -> Callable[..., Array]:
    def fold(*arguments: Array) -> Array:
        if len(arguments) == 2:
            return each(pair, 2)(*arguments)
        elements = list(arguments[0].flat)
        return array([reduce(pair, elements) if elements else SX(neutral)])

    return fold


def _fill(value: SX, *sizes: Array) -> Array:
    shape = tuple(integer(size.item()) for size in sizes)
    return array([value] * int(np.prod(shape)), shape)


def _identity(size: Array) -> Array:
    n = integer(size.item())
    return array([SX(float(i == j)) for i in range(n) for j in range(n)], (n, n))


def _linspace(first: Array, last: Array, count: Array) -> Array:
    n = integer(count.item())
    a, b = first.item(), last.item()
    return array([a + (b - a) * (k / (n - 1)) for k in range(n)], (n,))


def _cross(a: Array, b: Array) -> Array:
    (x, y, z), (p, q, r) = a, b
    return array([y * r - z * q, z * p - x * r, x * q - y * p], (3,))


def _matrix_cat(axis: int) -> Callable[..., Array]:
    return lambda *parts: np.concatenate([p.reshape(p.shape + (1,) * (2 - p.ndim)) for p in parts], axis)


SHAPED: dict[str, Callable[..., Array]] = {
    "min": _fold(ca.fmin, sys.float_info.max),  # Modelica Language Specification 3.6, section 10.3.4
    "max": _fold(ca.fmax, -sys.float_info.max),
    "sum": lambda a: array([reduce(operator.add, a.flat, SX(0))]),
    "product": lambda a: array([reduce(operator.mul, a.flat, SX(1))]),
    "zeros": lambda *sizes: _fill(SX(0), *sizes),
    "ones": lambda *sizes: _fill(SX(1), *sizes),
    "fill": lambda value, *sizes: _fill(value.item(), *sizes),
    "identity": _identity,
    "linspace": _linspace,
    "cat": lambda axis, *parts: np.concatenate(parts, integer(axis.item()) - 1),
    "promoted_cat1": _matrix_cat(0),
    "promoted_cat2": _matrix_cat(1),
    "transpose": lambda a: a.T,
    "cross": _cross,
    "size": lambda a, axis: array([SX(float(a.shape[integer(axis.item()) - 1]))]),
}
