"""Time events: the instants at which expressions of time change.

An expression is piecewise linear in time if it consists of sums, products with factors that are constant between
events, and `floor`, `ceil`, `sign`, `abs`, `min`, `max`, relations and if-expressions of such expressions. Its next
breakpoint and its next zero follow from its present value and slope, so that no event of it is missed, however large
the steps of a solver are. Other expressions of time are searched for zeros like those of states.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca

from railgrip.fmus.native.arrays import SX

_DEPTH = 30
"""Depth to which CasADi compares two expressions; if they are equal only below it, both are kept."""

_CONSTANT, _STEPS, _LINEAR, _OTHER = range(4)
"""Dependence on time: none, piecewise constant, piecewise linear, any other."""

_COMPARISONS = (ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE)


@dataclass(frozen=True, slots=True)
class TimeEvents:
    """Instants of the time events of a class.

    Attributes:
        time: Symbol of time.
        parameters: Symbols of the parameters.
        held: Symbols that are constant between events: parameters, discrete variables, memories of relations.
        instants: Instants as expressions of the parameters.
        moving: Next instants as expressions of `time` and `held`; they are valid until the next event, and infinite,
            not a number or in the past without one.
    """

    time: SX
    parameters: frozenset[str]
    held: frozenset[str]
    instants: list[SX] = field(default_factory=list[SX])
    moving: list[SX] = field(default_factory=list[SX])

    def add_zeros(self, expression: SX) -> bool:
        """Add the zeros of an expression; False if they cannot be computed."""
        if not ca.depends_on(expression, self.time):
            return False
        return self._add(expression, _next_zero(expression, self.time))

    def add_whole_numbers(self, expression: SX) -> bool:
        """Add the instants at which an expression is a whole number; False if they cannot be computed."""
        if not ca.depends_on(expression, self.time):
            return False
        return self._add(expression, _next_whole_number(expression, self.time), is_zero=False)

    def _add(self, expression: SX, following: SX, *, is_zero: bool = True) -> bool:
        names = {s.name() for s in ca.symvar(expression)} - {self.time.name()}
        if not names <= self.held:
            return False
        breakpoints, is_piecewise_linear = _breakpoints(expression, self.time)
        if not is_piecewise_linear:  # the search for zeros begins anew at each breakpoint
            for instant in breakpoints:
                _add_once(self.moving, ca.densify(instant))
            return False
        if is_zero and not breakpoints and names <= self.parameters:
            slope = ca.jacobian(expression, self.time)
            rest = ca.substitute(expression, self.time, SX(0))
            _add_once(self.instants, ca.densify(-rest / slope))
        else:
            for instant in (*breakpoints, following):
                _add_once(self.moving, ca.densify(instant))
        return True


def _add_once(instants: list[SX], instant: SX) -> None:
    if not any(ca.is_equal(instant, other, _DEPTH) for other in instants):
        instants.append(instant)


def _next_zero(expression: SX, time: SX) -> SX:
    return time - expression / ca.jacobian(expression, time)


def _next_whole_number(expression: SX, time: SX) -> SX:
    slope = ca.jacobian(expression, time)
    return time + (ca.if_else(slope > 0, ca.floor(expression) + 1, ca.ceil(expression) - 1) - expression) / slope


def _breakpoints(expression: SX, time: SX) -> tuple[list[SX], bool]:
    """Return the next breakpoints of the piecewise linear parts of an expression, and whether it is one as a whole."""
    others = [s for s in ca.symvar(expression) if s.name() != time.name()]
    inputs = [time, ca.vertcat(*others)]
    program = ca.Function("program", inputs, [expression])
    values: dict[int, tuple[SX, int]] = {}
    out: list[SX] = []
    kinds: list[int] = []
    for k in range(program.n_instructions()):
        operation = program.instruction_id(k)
        if operation == ca.OP_OUTPUT:
            continue
        (place,) = program.instruction_output(k)
        if operation == ca.OP_CONST:
            values[place] = SX(program.instruction_constant(k)), _CONSTANT
            continue
        arguments = program.instruction_input(k)
        if operation == ca.OP_INPUT:
            values[place] = inputs[arguments[0]].nz[arguments[1]], _CONSTANT if arguments[0] else _LINEAR
            continue
        operands = [values[i][0] for i in arguments]
        value = SX.unary(operation, *operands) if len(operands) == 1 else SX.binary(operation, *operands)
        kind, more = _kind(operation, operands, [values[i][1] for i in arguments], time)
        values[place] = value, kind
        out += more
        kinds.append(kind)
    return out, _OTHER not in kinds


def _kind(operation: int, operands: Sequence[SX], kinds: Sequence[int], time: SX) -> tuple[int, list[SX]]:
    # The dependence on time of an operation's result, and its own next breakpoints.
    if _OTHER in kinds:
        return _OTHER, []
    if max(kinds) < _LINEAR:
        return max(kinds), []
    if operation in (ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE):
        return _LINEAR, []
    if operation in (ca.OP_MUL, ca.OP_IF_ELSE_ZERO):
        return (_LINEAR if min(kinds) < _LINEAR else _OTHER), []
    if operation == ca.OP_DIV:
        return (_LINEAR if kinds[1] < _LINEAR else _OTHER), []
    if operation in (ca.OP_FLOOR, ca.OP_CEIL):
        return _STEPS, [_next_whole_number(operands[0], time)]
    if operation in (ca.OP_SIGN, ca.OP_FABS):
        return _STEPS if operation == ca.OP_SIGN else _LINEAR, [_next_zero(operands[0], time)]
    if operation in (ca.OP_FMIN, ca.OP_FMAX, *_COMPARISONS):
        kind = _STEPS if operation in _COMPARISONS else _LINEAR
        return kind, [_next_zero(operands[0] - operands[1], time)]
    return _OTHER, []
