"""Where the operations of Modelica are defined, and under which conditions a model evaluates them.

Outside its domain an operation gives NaN, infinity or a wrong element, which may be lost again in a relation or in
`max`. Therefore each operation that is not defined everywhere has a requirement; the FMU checks it like an assertion.
"""

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from railgrip.fmus.native.arrays import SX, Array, each, is_number

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
            yield Requirement(SX(holds), r.sentence, r.found, r.where)
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


def _nonnegative(value: SX) -> bool:
    # Whether an expression cannot be negative by its form, so that it needs no check.
    if is_number(value):
        return float(value) >= 0
    operands = [value.dep(k) for k in range(value.n_dep())]
    if value.op() in (ca.OP_SQ, ca.OP_FABS, ca.OP_EXP, ca.OP_SQRT):
        return True
    if value.op() == ca.OP_INV:
        return _nonnegative(operands[0])
    if value.op() in (ca.OP_ADD, ca.OP_MUL, ca.OP_DIV):
        same = value.op() == ca.OP_MUL and operands[0].element_hash() == operands[1].element_hash()
        return same or all(map(_nonnegative, operands))
    if value.op() == ca.OP_FMAX:
        return any(map(_nonnegative, operands))
    return False


def _positive(value: SX) -> bool:
    if is_number(value):
        return float(value) > 0
    operands = [value.dep(k) for k in range(value.n_dep())]
    if value.op() == ca.OP_EXP:
        return True
    if value.op() == ca.OP_SQRT:
        return _positive(operands[0])
    if value.op() == ca.OP_ADD:
        return all(map(_nonnegative, operands)) and any(map(_positive, operands))
    if value.op() in (ca.OP_MUL, ca.OP_DIV, ca.OP_INV):
        return all(map(_positive, operands))
    if value.op() == ca.OP_FMAX:
        return any(map(_positive, operands))
    return False


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


def _quotient(divisor: SX) -> Rule:
    return _positive(divisor) or divisor != 0, "the divisor must not be zero", divisor


def _power(base: SX, exponent: SX) -> Rule:
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


_RULES: dict[str, Callable[..., Rule]] = {
    "sqrt": _root,
    "log": _logarithm,
    "log10": _logarithm,
    "asin": _arc,
    "acos": _arc,
    "tan": _tangent,
    "atan2": _direction,
    "divide": _quotient,
    "elementwise_divide": _quotient,
    "mod": _quotient,
    "rem": _quotient,
    "div": _quotient,
    "power": _power,
    "elementwise_power": _power,
}
PARTIAL = _RULES.keys()
"""Operations that are not defined everywhere."""


BEYOND = 1e-9
"""Distance beyond a bound of its domain up to which a guarded operation has the value at the bound.

A relation keeps its value until the event at which it changes has been located, and until then the state is beyond the
bound that the relation guards, as in `if x > 0 then sqrt(x) else 0`. Farther beyond, the operation gives NaN, for which
the solver takes shorter steps, until it is within this distance."""


def extended(operation: str, operands: tuple[Array, ...]) -> tuple[Array, ...]:
    """Return the operands of a guarded operation, moved to the bounds of its domain if they are just beyond them."""
    low, high = {
        "sqrt": (0.0, None),
        "log": (sys.float_info.min, None),
        "log10": (sys.float_info.min, None),
        "asin": (-1.0, 1.0),
        "acos": (-1.0, 1.0),
        "power": (0.0, None),
        "elementwise_power": (0.0, None),
    }.get(operation, (None, None))
    if low is None or (len(operands) == 2 and all(is_number(n) and float(n).is_integer() for n in operands[1].flat)):
        return operands

    def move(value: SX) -> SX:
        if _nonnegative(value) and high is None:
            return value
        moved = ca.if_else(ca.logic_and(value < low, value > low - BEYOND), low, value)
        return moved if high is None else ca.if_else(ca.logic_and(value > high, value < high + BEYOND), high, moved)

    return (each(move)(operands[0]), *operands[1:])


def requirements(operation: str, operands: tuple[Array, ...], text: str, where: str) -> list[Requirement]:
    """Return the requirements of an operation on arrays that does not always fulfil them by its form.

    Args:
        operation: Name in the DAE, one of `PARTIAL`.
        operands: Operands, elementwise or scalars that apply to each element.
        text: Modelica text of the operation.
        where: File and line.
    """
    rule = _RULES[operation]
    if rule is _quotient:
        operands = operands[1:]
    found: list[Requirement] = []
    for elements in np.broadcast(*operands):
        holds, words, value = rule(*(SX(element) for element in elements))
        if not (is_number(holds) and float(holds)):
            found.append(Requirement(SX(holds), f"{text}: {words}, but it is ", value, where))
    return found
