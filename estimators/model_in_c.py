"""The model of a filter as C: what `kernel/step.h` asks of it, and the C of CasADi functions."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import casadi as ca

Pattern = tuple[tuple[int, ...], ...]
"""Columns of a sparse matrix that may differ from zero, ascending, for each row."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelInC:
    """A prediction of n states and m outputs as C, for a filter of one shape.

    The text defines three functions of the states `x` and of the filter's memory, with the inputs at
    `block + INPUT` and the prediction's parameters at `block + PARAMETERS`:

        static int slope(const double *block, const double *x, double *f);
        static int slope_and_jacobian(const double *block, const double *x, double *f, double *A);
        static int expected(const double *block, const double *x, double *h, double *H);

    They write dx/dt, the outputs, and the entries of their Jacobians by rows, and return 0, or else something other.

    Attributes:
        derivative_pattern: Of ∂f/∂x, n rows.
        output_pattern: Of ∂h/∂x, m rows.
        inputs: How many.
        parameters: How many.
        sizes: Macros that the text uses.
        text: The C.
    """

    derivative_pattern: Pattern
    output_pattern: Pattern
    inputs: int
    parameters: int
    sizes: tuple[tuple[str, int], ...]
    text: str


def pattern_of(jacobian: ca.SX) -> Pattern:
    """Return the pattern of a sparse CasADi matrix."""
    transposed = jacobian.sparsity().T  # CasADi counts down columns
    starts, columns = transposed.colind(), transposed.row()
    return tuple(tuple(columns[start:end]) for start, end in pairwise(starts))


def in_c(functions: Sequence[ca.Function]) -> tuple[dict[str, int], str]:
    """Return CasADi functions as C, with `call`, which calls any of them, and the sizes of its arrays as macros."""
    generator = ca.CodeGenerator("model", {"with_header": False, "casadi_int": "int"})
    for function in functions:
        generator.add(function)
    sizes = {
        "ARGUMENTS": max(function.sz_arg() for function in functions),
        "RESULTS": max(function.sz_res() for function in functions),
        # One more than needed, since C knows no empty arrays.
        "WHOLE": 1 + max(function.sz_iw() for function in functions),
        "WORK": 1 + max(function.sz_w() for function in functions),
    }
    return sizes, generator.dump() + _CALL


_CALL = """
typedef int Function(const double **, double **, casadi_int *, double *, int);

static int call(Function *function, const double **arguments, double **results)
{
    casadi_int integers[WHOLE];
    double work[WORK];
    return function(arguments, results, integers, work, 0);
}
"""

_CALLS = """
static int evaluate(Function *function, const double *block, const double *x, double *value, double *jacobian)
{
    const double *arguments[ARGUMENTS] = {x, block + INPUT, block + PARAMETERS};
    double *results[RESULTS] = {value, jacobian};
    return call(function, arguments, results);
}

static int slope(const double *block, const double *x, double *f)
{
    return evaluate(casadi_slope, block, x, f, 0);
}

static int slope_and_jacobian(const double *block, const double *x, double *f, double *A)
{
    return evaluate(casadi_slope_and_jacobian, block, x, f, A);
}

static int expected(const double *block, const double *x, double *h, double *H)
{
    return evaluate(casadi_expected, block, x, h, H);
}
"""


def model_in_c(
    x: ca.SX, u: ca.SX, p: ca.SX, derivative: ca.SX, output: ca.SX, derivative_jacobian: ca.SX, output_jacobian: ca.SX
) -> ModelInC:
    """Return f, h and their sparse Jacobians, expressions of x, u and p, as C."""
    # Jacobians transposed, because CasADi stores columns and step.h reads rows.
    functions = [
        ca.Function("casadi_slope", [x, u, p], [derivative]),
        ca.Function("casadi_slope_and_jacobian", [x, u, p], [derivative, derivative_jacobian.T]),
        ca.Function("casadi_expected", [x, u, p], [output, output_jacobian.T]),
    ]
    sizes, text = in_c(functions)
    return ModelInC(
        derivative_pattern=pattern_of(derivative_jacobian),
        output_pattern=pattern_of(output_jacobian),
        inputs=u.numel(),
        parameters=p.numel(),
        sizes=tuple(sizes.items()),
        text=text + _CALLS,
    )
