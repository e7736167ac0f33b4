"""The model of a filter as C, which `kernel/step.h` calls."""

from dataclasses import dataclass
from itertools import pairwise

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from railgrip.fmus.native.c_source import in_c

Pattern = tuple[tuple[int, ...], ...]
"""For each row of a sparse matrix the columns that may differ from zero, ascending."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelInC:
    """A prediction of n states and m outputs as C code.

    The text defines three functions of the states `x` and the filter's memory, in which the inputs are at
    `block + INPUT` and the prediction's parameters at `block + PARAMETERS`:

        static int slope(const double *block, const double *x, double *f);
        static int slope_and_jacobian(const double *block, const double *x, double *f, double *A);
        static int expected(const double *block, const double *x, double *h, double *H);

    They write dx/dt, the outputs, and the entries of their Jacobians by rows, and return 0 on success.

    Attributes:
        derivative_pattern: Pattern of ∂f/∂x, n rows.
        output_pattern: Pattern of ∂h/∂x, m rows.
        inputs: Number of inputs.
        parameters: Number of parameters.
        sizes: Macros that the text uses.
        text: The C code.
    """

    derivative_pattern: Pattern
    output_pattern: Pattern
    inputs: int
    parameters: int
    sizes: tuple[tuple[str, int], ...]
    text: str


def transition_pattern(slopes: Pattern, order: int) -> Pattern:
    """Return the pattern of the sum of the powers 0 to `order` of a matrix with the pattern `slopes`."""
    n = len(slopes)
    pattern: NDArray[np.bool_] = np.zeros((n, n), dtype=bool)
    for row, columns in enumerate(slopes):
        pattern[row, list(columns)] = True
    reach = np.eye(n, dtype=bool)
    # Entry (i, j) of Aᵏ differs from zero only if a path of k steps leads from i to j.
    for _ in range(order):
        reach |= pattern @ reach
    return tuple(tuple(np.flatnonzero(row).tolist()) for row in reach)


def pattern_of(jacobian: ca.SX) -> Pattern:
    """Return the pattern of a sparse CasADi matrix."""
    transposed = jacobian.sparsity().T  # CasADi stores matrices by columns
    starts, columns = transposed.colind(), transposed.row()
    return tuple(tuple(columns[start:end]) for start, end in pairwise(starts))


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
    """Return f, h and their sparse Jacobians, expressions in x, u and p, as C code."""
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
