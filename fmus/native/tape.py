"""CasADi functions as tables for the interpreter in `runtime/tape.c`, which compile faster than code."""

import casadi as ca

from railgrip.fmus.native.ctext import table
from railgrip.fmus.native.operations import IN_C, operation_names

LARGEST = 65535
"""Largest index of work, arguments, results and constants; `Operation` has unsigned shorts."""


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
