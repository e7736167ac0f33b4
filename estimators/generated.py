"""C code of a filter for one model: the fixed files in `kernel`, and shape.h with everything that depends on the model.

If CasADi generated the whole step for 25 states and 12 readings, as scalar code of 70 000 operations, it would take two
to four times as long as the vectorised rows of `kernel/step.h`, although both skip the zeros of the Jacobians.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

import numpy as np

from railgrip.estimators.discretisation import Order
from railgrip.estimators.model_in_c import ModelInC, transition_pattern

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
