"""C source: literals and tables, functions as tapes, and the elimination of a sparse matrix.

Text from outside (names, messages, places) enters C only as a string literal made by `string_literal`.

CasADi's generator writes each function in one piece, and the time of C compilers grows faster than the length of a
function. Its code also tests whether an argument or result is NULL, which never happens in an FMU; these tests would
take longer than the operations. `loops.py` writes what steps call, and `tape` the rest: tables (`runtime/tape.c`)
compile faster. Long code is divided into parts.

The pivots of I·c − J in a Rosenbrock method are its diagonal elements. Their order is chosen once, for minimum fill-in,
and (I·c − J) = LU and its solution are generated as straight-line code, without pivoting. A tiny pivot is reported, and
the caller then uses dense elimination with pivoting. Source: Sandu et al., Atmospheric Environment 31 (1997) 3459 (the
approach of KPP).
"""

import string
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from heapq import heapify, heappop, heappush
from itertools import product

import casadi as ca


def table(type_: str, name: str, values: Sequence[float]) -> str:
    """Return a C table of numbers."""
    # One entry more, because C has no empty arrays.
    entries = ", ".join([*(number(v) if type_ == "double" else str(int(v)) for v in values), "0"])
    return f"static const {type_} {name}[] = {{ {entries} }};"


def number(value: float) -> str:
    """Return a number as text that is valid in any C expression."""
    text = repr(float(value)).replace("inf", "INFINITY").replace("nan", "NAN")
    return f"({text})" if text.startswith("-") else text


def strings(name: str, values: Sequence[str | None]) -> str:
    """Return a C table of strings, with a null pointer for each None."""
    # One entry more, because C has no empty arrays.
    entries = ["0" if value is None else string_literal(value) for value in (*values, None)]
    return f"static const char *const {name}[] = {{ {', '.join(entries)} }};"


def in_parts(name: str, parameters: str, parts: Sequence[Sequence[str]]) -> list[str]:
    """Return lines of C functions, one for each part, and of the table NAME_parts with all of them.

    They are called through a table, because compilers inline a function that is called only once, and the caller would
    then have the length that the division avoids.

    Args:
        name: Beginning of the names of the functions.
        parameters: Parameters of each function.
        parts: Lines of each part.
    """
    voids = " ".join(f"(void){parameter.split()[-1].lstrip('*')};" for parameter in parameters.split(","))
    lines = list[str]()
    for k, part in enumerate(parts):
        lines += [f"static void {name}{k}({parameters}) {{", voids, *part, "}"]
    # One entry more, because C has no empty arrays.
    table_of_parts = ", ".join([*(f"{name}{k}" for k in range(len(parts))), "0"])
    return [*lines, f"static void (*const {name}_parts[])({parameters}) = {{ {table_of_parts} }};"]


_PLAIN = frozenset(string.ascii_letters + string.digits + string.punctuation + " ") - frozenset('"\\?')
"""Characters that need no escape in a C string literal; `??` begins a trigraph."""

# Always three digits, so that a digit that follows in the text is not read as part of the escape.
_ESCAPES = {octet: f"\\{octet:03o}" for octet in range(256) if chr(octet) not in _PLAIN}


def string_literal(text: str) -> str:
    """Return a C string literal of a text in UTF-8; NUL, which would end the string, becomes U+FFFD."""
    octets = text.replace("\0", "\ufffd").encode(errors="replace")
    return f'"{octets.decode("latin-1").translate(_ESCAPES)}"'


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
    "OP_IF_ELSE_ZERO": "x ? y : 0.0",
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


def fits(function: ca.Function) -> bool:
    """Return whether a function is small enough for the interpreter; a larger one must be compiled."""
    sizes = [function.nnz_in(i) for i in range(function.n_in())]
    sizes += [function.nnz_out(i) for i in range(function.n_out())]
    constants = sum(function.instruction_id(k) == ca.OP_CONST for k in range(function.n_instructions()))
    return max([function.sz_w(), constants, *sizes]) <= LARGEST


def interpreter() -> list[str]:
    """Return lines of C that must precede the functions of `tape`."""
    return [
        "#define OPERATIONS(_) " + " ".join(f"_({name}, {value})" for name, value in IN_C.items()),
        '#include "tape.c"',
    ]


def tape(function: ca.Function) -> str:
    """Return C code that interprets an expanded (SX) function, with the signature of `loops.with_loops`."""
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


MAX_ENTRIES, MAX_PRODUCTS = 10_000, 10_000
"""Entries of LU, and products of the factorisation, above which straight-line code saves too little to be compiled;
elimination is dense then."""

LARGEST_ELIMINATION = 100_000
"""The same limit for a large system, whose dense factorisation takes a hundred times as many products."""

LINES_OF_A_PART = 30
"""Lines of one part; a line may have many entries. Three times as many take half as long again to compile."""

FACTOR = "int sparse_factor(const double *jacobian, double c, double *a)"
SOLVE = "void sparse_solve(const double *a, double *b)"
"""The functions of an elimination in C."""

SMALLEST_PIVOT = 1e-7
"""Smallest pivot in units of c: below it the diagonal has cancelled, and half of the digits may be lost."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Elimination:
    """The elimination of one sparsity pattern.

    Attributes:
        code: C code of `FACTOR`, which returns 1 for a tiny pivot, and `SOLVE`.
        entries: Length of `a`; 0 if elimination is dense.
    """

    code: str
    entries: int


def eliminate(n: int, pattern: list[tuple[int, int]]) -> Elimination:
    """Return the elimination for the nonzeros of J, given as (row, column) in the order of its values.

    For each pivot, `a` has the inverse of the pivot, the row of U to its right and the column of L below it.
    """
    order, rows, columns = _order(n, pattern)
    position = {v: k for k, v in enumerate(order)}
    right = {k: [j for j in sorted(rows[k]) if position[j] > position[k]] for k in order}
    below = {k: [i for i in sorted(columns[k]) if position[i] > position[k]] for k in order}
    at: dict[tuple[int, int], int] = {}
    for k in order:
        for place in ((k, k), *((k, j) for j in right[k]), *((i, k) for i in below[k])):
            at[place] = len(at)
    worth = min(n**3 // 300, LARGEST_ELIMINATION)
    products = sum(len(below[k]) * len(right[k]) for k in order)
    if len(at) > max(MAX_ENTRIES, worth) or products > max(MAX_PRODUCTS, worth):
        order, at, pattern = [], {}, []
    sums = {(i, j): "c" if i == j else "0" for i, j in at}
    for m, place in enumerate(pattern):
        sums[place] += f" - jacobian[{m}]"
    for k in order:
        for i, j in product(below[k], right[k]):
            sums[i, j] += f" - a[{at[i, k]}] * a[{at[k, j]}]"
    factors: list[str] = []
    for (i, j), value in sums.items():
        to = f"a[{at[i, j]}]"
        if i == j:
            factors.append(f"{to} = {value}; *tiny |= !(fabs({to}) > {SMALLEST_PIVOT} * c); {to} = 1 / {to};")
        else:
            factors.append(f"{to} = ({value}) * a[{at[j, j]}];" if position[i] > position[j] else f"{to} = {value};")
    solution = [f"b[{i}] -= a[{at[i, k]}] * b[{k}];" for k in order for i in below[k]]
    for i in reversed(order):
        terms = "".join(f" - a[{at[i, j]}] * b[{j}]" for j in right[i])
        solution.append(f"b[{i}] = (b[{i}]{terms}) * a[{at[i, i]}];")
    lines = [
        *in_parts(
            "factor",
            "const double *restrict jacobian, double c, double *restrict a, int *restrict tiny",
            _parts(factors),
        ),
        f"{FACTOR} {{",
        f"    int tiny = {int(not at)};",
        f"    for (int k = 0; k < {len(_parts(factors))}; k++) factor_parts[k](jacobian, c, a, &tiny);",
        "    return tiny;",
        "}",
        *in_parts("solve", "const double *restrict a, double *restrict b", _parts(solution)),
        f"{SOLVE} {{",
        f"    for (int k = 0; k < {len(_parts(solution))}; k++) solve_parts[k](a, b);",
        "}",
    ]
    return Elimination(code="\n".join(lines), entries=len(at))


def _parts(lines: Sequence[str]) -> list[Sequence[str]]:
    return [lines[k : k + LINES_OF_A_PART] for k in range(0, len(lines), LINES_OF_A_PART)]


def _order(n: int, pattern: list[tuple[int, int]]) -> tuple[list[int], list[set[int]], list[set[int]]]:
    # The pivots in their order, and the rows and columns of the pattern with its fill-in.
    rows: list[set[int]] = [{i} for i in range(n)]
    columns: list[set[int]] = [{i} for i in range(n)]
    for i, j in pattern:
        rows[i].add(j)
        columns[j].add(i)
    right, below = ([line - {v} for v, line in enumerate(lines)] for lines in (rows, columns))  # without former pivots
    # Markowitz: the product bounds the number of new nonzeros; the number breaks ties, for reproducible code.
    candidates = [(len(right[v]) * len(below[v]), v) for v in range(n)]
    heapify(candidates)
    order: dict[int, None] = {}
    while candidates:
        cost, k = heappop(candidates)
        if k in order or cost != len(right[k]) * len(below[k]):
            continue
        order[k] = None
        for here, there, lines, to in ((below[k], right, rows, right[k]), (right[k], below, columns, below[k])):
            for v in here:
                lines[v] |= to
                there[v] |= to
                there[v] -= {k, v}
        for v in right[k] | below[k]:
            heappush(candidates, (len(right[v]) * len(below[v]), v))
    return list(order), rows, columns
