"""CasADi functions as C: straight-line code, tables for an interpreter, or the code of CasADi's own generator.

CasADi's generator writes each function in one piece, and the time of C compilers grows faster than the length of a
function. Its code also tests whether an argument or result is NULL, which never happens in an FMU; these tests would
take longer than the operations. Straight-line code is divided into parts; tables (`runtime/tape.c`) compile faster.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache

import casadi as ca

from railgrip.fmus.native.c_source import in_parts, number, table

LONGEST = 150
"""Maximum number of operations in one part."""

PARAMETERS = "const double **restrict arg, double **restrict res, double *restrict w"

LARGEST = 65535
"""Largest index of work, arguments, results and constants; `Operation` has unsigned shorts."""

_CALL = """
typedef int Function(const double **, double **, casadi_int *, double *, int);

static int call(Function *function, const double **arguments, double **results)
{
    casadi_int integers[WHOLE];
    double work[WORK];
    return function(arguments, results, integers, work, 0);
}
"""

_UNARY = (
    "sqrt", "exp", "expm1", "log", "log1p", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh",
    "asinh", "acosh", "atanh", "erf", "fabs", "floor", "ceil",
)  # fmt: skip
_BINARY = ("atan2", "hypot", "copysign", "fmod", "remainder", "fmin", "fmax")

IN_C = {
    "OP_ASSIGN": "x",
    "OP_LIFT": "x",
    "OP_ADD": "x + y",
    "OP_SUB": "x - y",
    "OP_MUL": "x * y",
    "OP_DIV": "x / y",
    "OP_NEG": "-x",
    "OP_INV": "1 / x",
    "OP_SQ": "x * x",
    "OP_TWICE": "2 * x",
    "OP_POW": "pow(x, y)",
    "OP_CONSTPOW": "pow(x, y)",
    "OP_SIGN": "x > 0 ? 1 : x < 0 ? -1 : x",
    "OP_LT": "x < y",
    "OP_LE": "x <= y",
    "OP_EQ": "x == y",
    "OP_NE": "x != y",
    "OP_NOT": "!x",
    "OP_AND": "x && y",
    "OP_OR": "x || y",
    "OP_IF_ELSE_ZERO": "x ? y : 0",
    **{f"OP_{name.upper()}": f"{name}(x)" for name in _UNARY},
    **{f"OP_{name.upper()}": f"{name}(x, y)" for name in _BINARY},
}
"""Name of an operation → C expression of its value; x and y are the operands."""


@cache
def operation_names() -> dict[int, str]:
    """Return the names of all operations by CasADi's numbers."""
    return {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}


def in_c(functions: Sequence[ca.Function]) -> tuple[dict[str, int], str]:
    """Return the sizes of work arrays by macro, and CasADi's C code of functions; its `call` calls any of them."""
    generator = ca.CodeGenerator("model", {"with_header": False, "casadi_int": "int"})
    for function in functions:
        generator.add(function)
    sizes = {
        "ARGUMENTS": max(function.sz_arg() for function in functions),
        "RESULTS": max(function.sz_res() for function in functions),
        # One entry more, because C has no empty arrays.
        "WHOLE": 1 + max(function.sz_iw() for function in functions),
        "WORK": 1 + max(function.sz_w() for function in functions),
    }
    return sizes, generator.dump() + _CALL


@dataclass(slots=True, eq=False)
class _Value:
    """An intermediate value of a function.

    Attributes:
        text: Its name in C.
        storage: Expression from which another part reads it; for a constant the same as `text`.
        parts: Parts that compute or use it; if there are several, it is stored.
    """

    text: str
    storage: str
    parts: set[int] = field(default_factory=set)


@dataclass(frozen=True, slots=True)
class _Operation:
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


def _steps(function: ca.Function) -> Iterator[_Operation]:
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
                yield _Operation("OP_ASSIGN", f"res[{to[0]}][{to[1]}]", operands)
            else:
                values[to[0]] = _Value(f"v{k}", f"w[{to[0]}]", {count // LONGEST})
                yield _Operation(operation, values[to[0]], operands)
            count += 1


def _part(steps: list[_Operation]) -> list[str]:
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


def fits(function: ca.Function) -> bool:
    """Return whether a function is small enough for the interpreter; a larger one must be compiled."""
    sizes = [function.nnz_in(i) for i in range(function.n_in())]
    sizes += [function.nnz_out(i) for i in range(function.n_out())]
    return max([function.sz_w(), function.n_instructions(), *sizes]) <= LARGEST


def interpreter() -> list[str]:
    """Return lines of C that must precede the functions of `tape`."""
    return [
        "#define OPERATIONS(_) " + " ".join(f"_({name}, {value})" for name, value in IN_C.items()),
        '#include "tape.c"',
    ]


def tape(function: ca.Function) -> str:
    """Return C code that interprets an expanded (SX) function, with the signature of `straight`."""
    name, constants = function.name(), dict[str, int]()
    rows: list[str] = []
    for k in range(function.n_instructions()):
        operation = operation_names()[function.instruction_id(k)]
        to, a = function.instruction_output(k), function.instruction_input(k)
        if operation == "OP_CONST":
            place = constants.setdefault(repr(function.instruction_constant(k)), len(constants))  # 0.0 is not -0.0
            row = (to[0], place, 0)
        elif operation == "OP_INPUT":
            row = (to[0], *a)
        elif operation == "OP_OUTPUT":
            row = (to[0], a[0], to[1])
        else:
            row = (to[0], a[0], a[-1])
        rows.append(f"{{{operation},{row[0]},{row[1]},{row[2]}}},")
    lines = ["".join(rows[k : k + 6]) for k in range(0, len(rows), 6)]
    return "\n".join(
        [
            table("double", f"{name}_constants", [float(c) for c in constants]),
            # One operation more, because C has no empty arrays.
            f"static const Operation {name}_tape[] = {{",
            *lines,
            "{OP_CONST,0,0,0}};",
            f"static void {name}(const double **arg, double **res) {{",
            f"    double w[{function.sz_w() + 1}];",
            f"    play({name}_tape, {len(rows)}, {name}_constants, arg, res, w);",
            "}",
        ]
    )
