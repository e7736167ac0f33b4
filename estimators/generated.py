"""The C of a filter for one model: the fixed files in `kernel`, and shape.h with everything that depends on it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from railgrip.estimators.design import Design
from railgrip.estimators.discretisation import Order
from railgrip.estimators.prediction import CasadiPrediction, Equations

LANES = 4
"""Rows of the covariance are padded to a multiple of this: the doubles of one AVX register."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Code:
    """C sources of a filter and the memory they work on.

    Their one function `int step(double *block)` advances the belief in `block` by one period: 0 when it
    could, else what `step.h` says in its first enum.

    Attributes:
        sources: File name to text; every `.c` is to be compiled.
        layout: Part of the block to where it lies: MEAN, COVARIANCE, HELD, SEEN, PARAMETERS, SPREAD,
            READING_NOISE, PERIOD, THRESHOLD, LIMIT_SQUARED are read, MEAN, COVARIANCE, SQUARED, USED, EXPECTED written.
        width: Length of a row of COVARIANCE and SPREAD; numbers beyond the n-th are zero.
    """

    sources: dict[str, str]
    layout: dict[str, slice]
    width: int


def generate(prediction: CasadiPrediction, design: Design) -> Code:
    """Return the C of the filter `design` over `prediction`; numbers are in the block, only shapes in the text."""
    return _code(prediction.equations, design.gated_states, design.gating_inputs, design.order)


@lru_cache(maxsize=16)
def _code(of: Equations, gated_states: tuple[int, ...], gating_inputs: tuple[int, ...], order: Order) -> Code:
    n, m = of.derivative.numel(), of.output.numel()
    width = -(-n // LANES) * LANES
    layout = places(
        {
            "MEAN": n, "COVARIANCE": n * width, "HELD": of.u.numel(), "SEEN": m, "PARAMETERS": of.p.numel(),
            "SPREAD": n * width, "READING_NOISE": m * m, "PERIOD": 1, "THRESHOLD": 1, "LIMIT_SQUARED": m, "SQUARED": 1,
            "USED": m, "EXPECTED": m,
        }
    )  # fmt: skip
    kernel = sorted(
        (file for file in (files("railgrip.estimators") / "kernel").iterdir() if file.name.endswith((".c", ".h"))),
        key=lambda file: file.name,
    )
    sizes = {"N": n, "M": m, "INPUTS": of.u.numel(), "WIDTH": width, "ORDER": order, "GATES": len(gated_states)}
    sizes |= {part: place.start for part, place in layout.items()}
    gates = {"GATE_STATE": gated_states, "GATE_INPUT": gating_inputs}
    return Code(
        sources={file.name: file.read_text(encoding="utf-8") for file in kernel} | _shape(of, sizes, gates, order),
        layout=layout,
        width=width,
    )


def _shape(of: Equations, sizes: dict[str, int], gates: dict[str, tuple[int, ...]], order: Order) -> dict[str, str]:
    """Return the texts of sizes.h, with sizes and layout, and of shape.h, which adds sparsity tables and the model."""
    arguments, names = [of.x, of.u, of.p], ["x", "u", "p"]
    # Jacobians transposed, because CasADi stores columns and step.h reads rows.
    slopes, observations = of.derivative_jacobian.T, of.output_jacobian.T
    functions = [
        ca.Function("slope", arguments, [of.derivative], names, ["f"]),
        ca.Function("slope_and_jacobian", arguments, [of.derivative, slopes], names, ["f", "A"]),
        ca.Function("expected", arguments, [of.output, observations], names, ["h", "H"]),
    ]
    workspace, text = in_c(functions)
    phi = _transition_pattern(slopes.sparsity(), order)
    counts = {"A_COUNT": 1 + slopes.nnz(), "H_COUNT": 1 + observations.nnz(), "PHI_COUNT": int(phi.sum())}
    numbers = sizes | workspace | counts
    tables = {
        "A_ROW": slopes.sparsity().colind(),
        "A_COLUMN": slopes.sparsity().row(),
        "H_ROW": observations.sparsity().colind(),
        "H_COLUMN": observations.sparsity().row(),
        "PHI_ROW": np.concatenate([[0], np.cumsum(phi.sum(axis=1))]).tolist(),
        "PHI_COLUMN": np.nonzero(phi)[1].tolist(),
    } | gates
    return {
        "sizes.h": "".join(f"#define {name} {number}\n" for name, number in numbers.items()),
        "shape.h": "\n".join(
            (
                "#define CASADI_SYMBOL_EXPORT static",
                '#include "sizes.h"',
                *(table(name, values) for name, values in tables.items()),
                text,
            )
        ),
    }


def places(sizes: Mapping[str, int]) -> dict[str, slice]:
    """Return where parts of these sizes lie, one after the other in their order."""
    ends = np.cumsum(list(sizes.values())).tolist()
    return {name: slice(end - size, end) for (name, size), end in zip(sizes.items(), ends, strict=True)}


def in_c(functions: Sequence[ca.Function]) -> tuple[dict[str, int], str]:
    """Return the sizes of the arrays that CasADi functions in C want to work in, large enough for each, and the C."""
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
    return sizes, generator.dump()


def table(name: str, values: Iterable[int]) -> str:
    """Return a constant C array; one element at least, since C knows no empty ones."""
    return f"static const int {name}[] = {{{', '.join(map(str, values)) or '0'}}};"


def _transition_pattern(columns: ca.Sparsity, order: int) -> NDArray[np.bool_]:
    """Return where Φ may differ from zero, shape (n, n), from the pattern of A transposed."""
    n = columns.size1()
    pattern = np.zeros((n, n), dtype=bool)
    row, column = columns.get_triplet()
    pattern[column, row] = True
    reach = np.eye(n, dtype=bool)
    for _ in range(order):
        reach |= pattern @ reach
    return reach
