"""The step of a filter as C: functions of its model, the fixed files in `kernel`, and shape.h with sizes and patterns.

If CasADi generated the whole step for 25 states and 12 readings, as scalar code of 70 000 operations, it would take two
to four times as long as the vectorised rows of `kernel/step.h`, although both skip the zeros of the Jacobians.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from itertools import pairwise

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from railgrip.estimators.belief import Order
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


LANES = 4
"""Rows of the covariance are padded to a multiple of this: the doubles of one AVX register."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Code:
    """C sources of a filter and the layout of its memory.

    The function `int step(double *block)` advances the estimate in `block` by one period and returns 0, or a failure
    code of `step.h`.

    Attributes:
        sources: File name → text; every `.c` file is compiled.
        layout: Part of the block → its slice: MEAN, COVARIANCE, INPUT, READING, PARAMETERS, PROCESS_NOISE,
            READING_NOISE, PERIOD, THRESHOLD, LIMIT_SQUARED are read, MEAN, COVARIANCE, SQUARED, USED, EXPECTED written.
        width: Length of a row of COVARIANCE and PROCESS_NOISE; numbers beyond the n-th are zero.
    """

    sources: dict[str, str]
    layout: dict[str, slice]
    width: int


@lru_cache(maxsize=16)
def generate(model: ModelInC, gated_states: tuple[int, ...], gating_inputs: tuple[int, ...], order: Order) -> Code:
    """Return the C code of a filter for a model; it depends on shapes only, because all values are in the block.

    Args:
        model: The prediction.
        gated_states, gating_inputs, order: See `Design`.
    """
    n, m = len(model.derivative_pattern), len(model.output_pattern)
    width = -(-n // LANES) * LANES
    layout = places(
        {
            "MEAN": n, "COVARIANCE": n * width, "INPUT": model.inputs, "READING": m, "PARAMETERS": model.parameters,
            "PROCESS_NOISE": n * width, "READING_NOISE": m * m, "PERIOD": 1, "THRESHOLD": 1, "LIMIT_SQUARED": m,
            "SQUARED": 1, "USED": m, "EXPECTED": m,
        }
    )  # fmt: skip
    kernel = sorted(
        (file for file in (files("railgrip.estimators") / "kernel").iterdir() if file.name.endswith((".c", ".h"))),
        key=lambda file: file.name,
    )
    transition = transition_pattern(model.derivative_pattern, order)
    numbers = {"N": n, "M": m, "INPUTS": model.inputs, "WIDTH": width, "ORDER": order, "GATES": len(gated_states)}
    numbers["BLOCK"] = max(place.stop for place in layout.values())
    numbers |= {part: place.start for part, place in layout.items()} | dict(model.sizes)
    tables = {"GATE_STATE": gated_states, "GATE_INPUT": gating_inputs}
    patterns = {"A": model.derivative_pattern, "H": model.output_pattern, "PHI": transition}
    for name, pattern in patterns.items():
        # One more than needed, because C has no empty arrays.
        numbers[f"{name}_COUNT"] = 1 + sum(map(len, pattern))
        tables[f"{name}_ROW"] = np.cumsum([0, *map(len, pattern)]).tolist()
        tables[f"{name}_COLUMN"] = tuple(column for row in pattern for column in row)
    sources = {file.name: file.read_text(encoding="utf-8") for file in kernel}
    sources["sizes.h"] = "".join(f"#define {name} {number}\n" for name, number in numbers.items())
    sources["shape.h"] = "\n".join(
        (
            "#define CASADI_SYMBOL_EXPORT static",
            '#include "sizes.h"',
            *(table(name, values) for name, values in tables.items()),
            model.text,
        )
    )
    return Code(sources=sources, layout=layout, width=width)


def places(sizes: Mapping[str, int]) -> dict[str, slice]:
    """Return the slices of parts of these sizes, which are stored one after the other."""
    ends = np.cumsum(list(sizes.values())).tolist()
    return {name: slice(end - size, end) for (name, size), end in zip(sizes.items(), ends, strict=True)}


def table(name: str, values: Iterable[int]) -> str:
    """Return a constant C array; without values it has one zero, because C has no empty arrays."""
    return f"static const int {name}[] = {{{', '.join(map(str, values)) or '0'}}};"
