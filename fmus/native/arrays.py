"""Arrays of scalar CasADi expressions, and Modelica's operators on them.

A Modelica value of any shape is a numpy object array of scalar `SX`; a scalar is 0-dimensional.

Outside its domain an operation gives NaN, infinity or a wrong element, which may be lost again in a relation or in
`max`. Therefore each operation that is not defined everywhere has a requirement; the FMU checks it like an assertion.
"""

import operator
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial, reduce
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import ShapeError

SX = ca.SX
Array = NDArray[Any]


def array(values: Iterable[Any], shape: tuple[int, ...] = ()) -> Array:
    """Return an object array of `shape` filled row by row."""
    every = list(values)
    out = np.empty(len(every), dtype=object)
    for i, value in enumerate(every):
        out[i] = value  # with an integer index numpy stores the object itself, without a check for arrays
    return out.reshape(shape)


def scalar(value: Any) -> Array:
    """Return a 0-dimensional object array."""
    out = np.empty(1, dtype=object)
    out[0] = value
    return out.reshape(())


def as_array(value: Any) -> Array:
    """Return `value` as an array; numpy unwraps 0-dimensional results."""
    return value if isinstance(value, np.ndarray) else scalar(value)


def each(function: Callable[..., Any], count: int = 1) -> Callable[..., Array]:
    """Return `function` of `count` scalars, applied elementwise with broadcasting."""
    ufunc = np.frompyfunc(function, count, 1)

    def apply(*arguments: Array) -> Array:
        if all(a.ndim == 0 for a in arguments):  # most are, and numpy takes longer for them than CasADi
            return scalar(function(*(a.item() for a in arguments)))
        with np.errstate(all="ignore"):  # a constant out of the domain is reported with its place
            return as_array(ufunc(*arguments))

    return apply


def as_sx(value: Any) -> SX:
    """Return a number or expression as an expression; CasADi takes longer to copy one than to add two."""
    return value if isinstance(value, SX) else SX(value)


def is_number(value: SX | float) -> bool:
    """Return whether an expression is a plain number."""
    return as_sx(value).is_constant()


def integer(value: SX) -> int:
    """Return a constant expression as int."""
    return int(float(value))


def count(value: Array) -> int:
    """Return a size or an exponent, which is a whole number that is not negative and known at build time."""
    require(value.ndim == 0, "sizes and exponents of matrices are scalars")
    number = value.item()
    require(
        is_number(number), "sizes and exponents of matrices must be numbers at build time; write a number or a constant"
    )
    require(
        float(number) >= 0 and float(number).is_integer(),
        f"sizes and exponents of matrices are whole numbers that are not negative, got {float(number):g}",
    )
    return integer(number)


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


def require(condition: bool, rule: str) -> None:
    """Raise a ShapeError with a rule of the language unless it is fulfilled."""
    if not condition:
        raise ShapeError(rule)


def _shape(a: Array) -> str:
    return f"[{', '.join(map(str, a.shape))}]" if a.ndim else "a scalar"


_times = each(operator.mul, 2)


def _product(a: Array, b: Array) -> Array:
    if a.ndim == 0 or b.ndim == 0:
        return _times(a, b)
    require(
        a.ndim <= 2 and b.ndim <= 2 and a.shape[-1] == b.shape[0],
        f"{_shape(a)} * {_shape(b)}: the factors are vectors or matrices with equal inner sizes (10.6.4)",
    )
    # numpy returns the integer 0 for an inner size of zero.
    return each(SX)(as_array(np.dot(a, b)))


def _elementwise(function: Callable[[SX, SX], SX], *, allows_scalar: bool = True) -> Callable[[Array, Array], Array]:
    elementwise = each(function, 2)
    rule = "the sizes must be equal, or one side a scalar" if allows_scalar else "the sizes of both sides must be equal"

    def apply(a: Array, b: Array) -> Array:
        if a.shape != b.shape and not (allows_scalar and 0 in (a.ndim, b.ndim)):
            raise ShapeError(f"{_shape(a)} and {_shape(b)}: {rule} (10.6)")
        return elementwise(a, b)

    return apply


def _quotient(a: Array, b: Array) -> Array:
    require(b.ndim == 0, f"{_shape(a)} / {_shape(b)}: the divisor must be a scalar (10.6.5); write ./ for each element")
    return each(operator.truediv, 2)(a, b)


def _whole_power(a: Array, exponent: Array) -> Array:
    if a.ndim == 0:
        require(exponent.ndim == 0, "the exponent of ^ must be a scalar (10.6.7); write .^ for each element")
        return each(_power, 2)(a, exponent)
    require(
        a.ndim == 2 and a.shape[0] == a.shape[1] and exponent.ndim == 0,
        f"{_shape(a)} ^ {_shape(exponent)}: the base must be a square matrix and the exponent a scalar (10.6.7)",
    )
    n = count(exponent)
    out, square = _identity(scalar(SX(a.shape[0]))), a
    while n:
        if n % 2:
            out = _product(out, square)
        n //= 2
        square = _product(square, square) if n else square
    return out


_ARITHMETIC: dict[str, Callable[[SX, SX], SX]] = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "divide": operator.truediv,
    "power": _power,
}
RELATIONS: dict[str, Callable[[SX, SX], SX]] = {
    "less": operator.lt,
    "less_equal": operator.le,
    "greater": operator.gt,
    "greater_equal": operator.ge,
    "equal": operator.eq,
    "not_equal": operator.ne,
    "and": ca.logic_and,
    "or": ca.logic_or,
}
BINARY: dict[str, Callable[[Array, Array], Array]] = {
    **{name: _elementwise(f, allows_scalar=False) for name, f in (_ARITHMETIC | RELATIONS).items()},
    **{f"elementwise_{name}": _elementwise(function) for name, function in _ARITHMETIC.items()},
    "multiply": _product,
    "divide": _quotient,
    "power": _whole_power,
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


def _fold(pair: Callable[[SX, SX], SX]) -> Callable[..., Array]:
    elementwise = _elementwise(pair)

    def fold(*arguments: Array) -> Array:
        return elementwise(*arguments) if len(arguments) == 2 else scalar(reduce(pair, arguments[0].flat))

    return fold


def _fill(value: SX, *sizes: Array) -> Array:
    shape = tuple(map(count, sizes))
    return array([value] * int(np.prod(shape)), shape)


def _diagonal(values: Array) -> Array:
    n = len(values)
    return array([values[i] if i == j else SX(0) for i in range(n) for j in range(n)], (n, n))


def _identity(size: Array) -> Array:
    return _diagonal(_fill(SX(1), size))


def _linspace(first: Array, last: Array, number: Array) -> Array:
    n = count(number)
    require(n >= 2, f"linspace requires at least two points (10.3.3), got {n}")
    a, b = first.item(), last.item()
    return array([a + (b - a) * (k / (n - 1)) for k in range(n)], (n,))


def _cross(a: Array, b: Array) -> Array:
    require(a.shape == b.shape == (3,), f"cross({_shape(a)}, {_shape(b)}): both are vectors of size 3 (10.3.5)")
    (x, y, z), (p, q, r) = a, b
    return array([y * r - z * q, z * p - x * r, x * q - y * p], (3,))


def _skew(a: Array) -> Array:
    require(a.shape == (3,), f"skew({_shape(a)}): the argument is a vector of size 3 (10.3.5)")
    (x, y, z), zero = a, SX(0)
    return array([zero, -z, y, z, zero, -x, -y, x, zero], (3, 3))


def _outer_product(a: Array, b: Array) -> Array:
    require(a.ndim == b.ndim == 1, f"outerProduct({_shape(a)}, {_shape(b)}): both are vectors (10.3.5)")
    return array([x * y for x in a for y in b], (len(a), len(b)))


def _symmetric(a: Array) -> Array:
    require(a.ndim == 2 and a.shape[0] == a.shape[1], f"symmetric({_shape(a)}): the matrix must be square (10.3.5)")
    return array([a[min(i, j), max(i, j)] for i in range(len(a)) for j in range(len(a))], a.shape)


def _transpose(a: Array) -> Array:
    require(a.ndim >= 2, "transpose requires at least two dimensions (10.3.5)")
    return np.swapaxes(a, 0, 1)


def _vector(a: Array) -> Array:
    require(sum(n > 1 for n in a.shape) <= 1, f"vector({_shape(a)}): at most one size may exceed 1 (10.3.2)")
    return a.reshape(-1)


def _matrix(a: Array) -> Array:
    require(all(n == 1 for n in a.shape[2:]), f"matrix({_shape(a)}): sizes after the second are 1 (10.3.2)")
    return a.reshape((*a.shape, 1, 1)[:2])


def _scalar(a: Array) -> Array:
    require(a.size == 1, f"scalar({_shape(a)}): the argument has one element (10.3.2)")
    return a.reshape(())


def _size(a: Array, axis: Array | None = None) -> Array:
    if axis is None:
        return array([SX(n) for n in a.shape], (a.ndim,))
    k = count(axis)
    require(1 <= k <= a.ndim, f"size(A, {k}): A has {a.ndim} dimensions (10.3.1)")
    return scalar(SX(a.shape[k - 1]))


def _concatenate(parts: Sequence[Array], axis: int) -> Array:
    shapes = {(p.ndim, *p.shape[:axis], *p.shape[axis + 1 :]) for p in parts}
    require(
        len(shapes) == 1 and parts[0].ndim > axis >= 0,
        f"{' and '.join(map(_shape, parts))} cannot be joined along dimension {axis + 1}: "
        "the other sizes must be equal (10.4.2)",
    )
    return np.concatenate(parts, axis)


def _matrix_cat(axis: int) -> Callable[..., Array]:
    # Every operand is a matrix, unless one has more dimensions (10.4.2.1).
    return lambda *parts: _concatenate([p.reshape(p.shape + (1,) * (2 - p.ndim)) for p in parts], axis)


OF_NO_ELEMENTS: dict[str, dict[str, float]] = {
    "min": {"real": sys.float_info.max, "integer": 2**31 - 1, "boolean": 1},
    "max": {"real": -sys.float_info.max, "integer": 1 - 2**31, "boolean": 0},
}
"""Value of min and max of an empty array, by type (Modelica Language Specification 3.6, section 10.3.4); an Integer has
32 bits and is symmetric, as in Modelica.Constants."""

SHAPED: dict[str, Callable[..., Array]] = {
    "min": _fold(ca.fmin),
    "max": _fold(ca.fmax),
    "sum": lambda a: scalar(reduce(operator.add, a.flat, SX(0))),
    "product": lambda a: scalar(reduce(operator.mul, a.flat, SX(1))),
    "zeros": lambda *sizes: _fill(SX(0), *sizes),
    "ones": lambda *sizes: _fill(SX(1), *sizes),
    "fill": lambda value, *sizes: _fill(value.item(), *sizes),
    "identity": _identity,
    "diagonal": _diagonal,
    "linspace": _linspace,
    "cat": lambda axis, *parts: _concatenate(parts, count(axis) - 1),
    "promoted_cat1": _matrix_cat(0),
    "promoted_cat2": _matrix_cat(1),
    "transpose": _transpose,
    "symmetric": _symmetric,
    "outer_product": _outer_product,
    "cross": _cross,
    "skew": _skew,
    "scalar": _scalar,
    "vector": _vector,
    "matrix": _matrix,
    "ndims": lambda a: scalar(SX(a.ndim)),
    "size": _size,
}


LARGEST_TANGENT = 1e15
"""The tangent of every double next to a pole below 1 is larger; cos is never exactly zero in doubles."""


@dataclass(frozen=True, slots=True, eq=False)
class Requirement:
    """A condition for the value of an operation to exist.

    Attributes:
        holds: Expression that is nonzero if it is fulfilled.
        sentence: Operation and rule, up to the value that was found.
        found: That value.
        where: File and line.
    """

    holds: SX
    sentence: str
    found: SX
    where: str


@dataclass(slots=True, eq=False)
class Evaluation:
    """An evaluated expression: its requirements, and the evaluations it uses with the conditions of that use.

    An expression that occurs at several places is evaluated once, so it is used if any of its conditions holds.
    """

    requirements: list[Requirement] = field(default_factory=list[Requirement])
    uses: "list[tuple[Evaluation, SX | None]]" = field(default_factory=list)

    def __bool__(self) -> bool:
        return bool(self.requirements or self.uses)


def both(a: SX | None, b: SX | None) -> SX | None:
    """Return the conjunction of two conditions, where None always holds."""
    return b if a is None else a if b is None else ca.logic_and(a, b)


def conditional_requirements(root: Evaluation) -> Iterator[Requirement]:
    """Yield the requirements of all evaluations below a root, fulfilled where the evaluation is not used."""
    condition: dict[int, SX | None] = {id(root): None}
    for evaluation in _users_first(root):
        used = condition[id(evaluation)]
        for r in evaluation.requirements:
            holds = r.holds if used is None else ca.logic_or(ca.logic_not(used), r.holds)
            yield Requirement(as_sx(holds), r.sentence, r.found, r.where)
        for part, only_if in evaluation.uses:
            here = both(used, only_if)
            if id(part) not in condition:
                condition[id(part)] = here
            else:
                other = condition[id(part)]
                condition[id(part)] = None if here is None or other is None else ca.logic_or(other, here)


def _users_first(root: Evaluation) -> list[Evaluation]:
    # Reverse postorder, with an explicit stack because functions with loops make long chains.
    order: list[Evaluation] = []
    seen = {id(root)}
    stack = [(root, iter(root.uses))]
    while stack:
        evaluation, parts = stack[-1]
        for part, _ in parts:
            if id(part) not in seen:
                seen.add(id(part))
                stack.append((part, iter(part.uses)))
                break
        else:
            order.append(evaluation)
            stack.pop()
    return order[::-1]


def _is_whole(value: SX) -> SX:
    return value == ca.floor(value)


def _nonnegative(value: SX, *, strictly: bool = False) -> bool:
    # Whether an expression cannot be negative, or not zero either, by its form, so that it needs no check.
    if is_number(value):
        return float(value) > 0 or (not strictly and float(value) == 0)
    operation, operands = value.op(), [value.dep(k) for k in range(value.n_dep())]
    holds = partial(_nonnegative, strictly=strictly)
    if operation in (ca.OP_SQ, ca.OP_FABS):
        return not strictly
    if operation == ca.OP_EXP:
        return True
    if operation == ca.OP_SQRT:
        return not strictly or holds(operands[0])
    if operation == ca.OP_ADD and strictly:
        return all(map(_nonnegative, operands)) and any(map(_positive, operands))
    if operation in (ca.OP_ADD, ca.OP_MUL, ca.OP_DIV, ca.OP_INV):
        is_square = operation == ca.OP_MUL and operands[0].element_hash() == operands[1].element_hash()
        return (is_square and not strictly) or all(map(holds, operands))
    return operation == ca.OP_FMAX and any(map(holds, operands))


_positive = partial(_nonnegative, strictly=True)


Rule = tuple[SX | bool, str, SX]
"""Whether the requirement holds, the rule in words, and the value found."""


def _root(a: SX) -> Rule:
    return _nonnegative(a) or a >= 0, "the argument must not be negative", a


def _logarithm(a: SX) -> Rule:
    return _positive(a) or a > 0, "the argument must be positive", a


def _arc(a: SX) -> Rule:
    return ca.fabs(a) <= 1, "the argument must be from -1 to 1", a


def _tangent(a: SX) -> Rule:
    return ca.fabs(ca.tan(a)) < LARGEST_TANGENT, "the argument must not be an odd multiple of pi/2", a


def _direction(y: SX, x: SX) -> Rule:
    return (
        _positive(ca.fabs(y) + ca.fabs(x)) or ca.logic_or(y != 0, x != 0),
        "the second argument must not be zero where the first is",
        y,
    )


def _divisor(divisor: SX) -> Rule:
    return _positive(divisor) or divisor != 0, "the divisor must not be zero", divisor


def _base(base: SX, exponent: SX) -> Rule:
    rule = "a negative base requires a whole exponent, and a base of zero an exponent that is not negative"
    if is_number(exponent):
        n = float(exponent)
        if n >= 0:
            return n.is_integer() or _nonnegative(base) or base >= 0, rule, base
        return _positive(base) or (base != 0 if n.is_integer() else base > 0), rule, base
    if _positive(base):
        return True, rule, base
    at_zero = ca.logic_and(base == 0, exponent >= 0)
    return ca.logic_or(base > 0, ca.logic_or(at_zero, ca.logic_and(base < 0, _is_whole(exponent)))), rule, base


_RULES: dict[str, tuple[Callable[..., Rule], float | None, float | None]] = {
    "sqrt": (_root, 0.0, None),
    "log": (_logarithm, sys.float_info.min, None),
    "log10": (_logarithm, sys.float_info.min, None),
    "asin": (_arc, -1.0, 1.0),
    "acos": (_arc, -1.0, 1.0),
    "tan": (_tangent, None, None),
    "atan2": (_direction, None, None),
    **dict.fromkeys(("divide", "elementwise_divide", "mod", "rem", "div"), (_divisor, None, None)),
    "power": (_base, 0.0, None),
    "elementwise_power": (_base, 0.0, None),
}
"""Operation → its requirement, and the bounds of the domain of its first operand to which `extended` moves that."""
PARTIAL = _RULES.keys()
"""Operations that are not defined everywhere."""


BEYOND = 1e-9
"""Distance beyond a bound of its domain up to which a guarded operation has the value at the bound.

A relation keeps its value until the event at which it changes has been located, and until then the state is beyond the
bound that the relation guards, as in `if x > 0 then sqrt(x) else 0`. Farther beyond, the operation gives NaN, for which
the solver takes shorter steps, until it is within this distance."""


def extended(operation: str, operands: tuple[Array, ...]) -> tuple[Array, ...]:
    """Return the operands of a guarded operation, moved to the bounds of its domain if they are just beyond them."""
    _, low, high = _RULES.get(operation, (None, None, None))
    if low is None or (len(operands) == 2 and all(is_number(n) and float(n).is_integer() for n in operands[1].flat)):
        return operands

    def move(value: SX) -> SX:
        if _nonnegative(value) and high is None:
            return value
        moved = ca.if_else(ca.logic_and(value < low, value > low - BEYOND), low, value)
        return moved if high is None else ca.if_else(ca.logic_and(value > high, value < high + BEYOND), high, moved)

    return (each(move)(operands[0]), *operands[1:])


def requirements(operation: str, operands: tuple[Array, ...]) -> list[Rule]:
    """Return the requirements of an operation on arrays that does not always fulfil them by its form.

    Args:
        operation: Name in the DAE, one of `PARTIAL`.
        operands: Operands, elementwise or scalars that apply to each element.
    """
    rule, _, _ = _RULES[operation]
    if rule is _divisor:
        operands = operands[1:]
    found: list[Rule] = []
    for elements in np.broadcast(*operands):
        holds, words, value = rule(*(as_sx(element) for element in elements))
        if not (is_number(holds) and float(holds)):
            found.append((holds, words, value))
    return found
