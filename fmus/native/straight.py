"""CasADi functions as straight-line C.

CasADi's own generator writes each function in one piece, and the time of C compilers grows faster than the length of a
function. It also allows any argument or result to be NULL; here none is, and the tests would take longer than the
operations.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache

import casadi as ca

from railgrip.fmus.native.ctext import in_parts, number
from railgrip.fmus.native.operations import IN_C, operation_names

LONGEST = 150
"""Maximum number of operations in one part."""

PARAMETERS = "const double **restrict arg, double **restrict res, double *restrict w"


@dataclass(slots=True, eq=False)
class _Value:
    """An intermediate value of a function.

    Attributes:
        text: Its name in C.
        storage: Expression from which another part reads it; for a constant the same as `text`.
        parts: Parts that use it.
    """

    text: str
    storage: str
    parts: set[int] = field(default_factory=set)


@dataclass(frozen=True, slots=True)
class _Step:
    """One operation: its result, a value or a place in `res`, and its operands."""

    operation: str
    result: _Value | str
    operands: tuple[_Value, ...]


def straight(function: ca.Function) -> str:
    """Return C code of an expanded (SX) function NAME: `static void NAME(const double **arg, double **res)`.

    The operations are CasADi's, in its order. A value that several parts use is stored in `w` at the place of CasADi's
    virtual machine, which reuses places as soon as they are free.
    """
    steps = list(_steps(function))
    parts = [_part(steps[k : k + LONGEST]) for k in range(0, len(steps), LONGEST)]
    name = function.name()
    return "\n".join(
        [
            *in_parts(name, PARAMETERS, parts),
            f"static void {name}(const double **arg, double **res) {{",
            f"    double w[{function.sz_w() + 1}];",
            f"    for (int k = 0; k < {len(parts)}; k++) {name}_parts[k](arg, res, w);",
            "}",
        ]
    )


def _steps(function: ca.Function) -> Iterator[_Step]:
    values: dict[int, _Value] = {}
    count = 0
    for k in range(function.n_instructions()):
        operation = operation_names()[function.instruction_id(k)]
        to, arguments = function.instruction_output(k), function.instruction_input(k)
        if operation == "OP_CONST":
            constant = number(function.instruction_constant(k))
            values[to[0]] = _Value(constant, constant)
        elif operation == "OP_INPUT":
            values[to[0]] = _Value(f"v{k}", f"arg[{arguments[0]}][{arguments[1]}]")
        else:
            operands = tuple(values[place] for place in arguments)
            for operand in operands:
                operand.parts.add(count // LONGEST)
            if operation == "OP_OUTPUT":
                yield _Step("OP_ASSIGN", f"res[{to[0]}][{to[1]}]", operands)
            else:
                values[to[0]] = _Value(f"v{k}", f"w[{to[0]}]", {count // LONGEST})
                yield _Step(operation, values[to[0]], operands)
            count += 1


def _part(steps: list[_Step]) -> list[str]:
    lines: list[str] = []
    names: set[str] = set()
    for step in steps:
        for operand in step.operands:
            if operand.text != operand.storage and operand.text not in names:
                lines.append(f"double {operand.text} = {operand.storage};")
                names.add(operand.text)
        value = _template(step.operation).format(x=step.operands[0].text, y=step.operands[-1].text)
        if isinstance(step.result, str):
            lines.append(f"{step.result} = {value};")
            continue
        names.add(step.result.text)
        keep = f"{step.result.storage} = " if len(step.result.parts) > 1 else ""
        lines.append(f"double {step.result.text} = {keep}{value};")
    return lines


@cache
def _template(operation: str) -> str:
    return re.sub(r"\b([xy])\b", r"{\1}", IN_C[operation])
