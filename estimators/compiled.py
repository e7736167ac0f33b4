"""The extended Kalman filter of `ekf`, generated as C for one model."""

import ctypes
import hashlib
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.belief import Estimate, Vector
from estimators.design import Design, frozen_estimate
from estimators.discretisation import ORDER
from estimators.errors import FilterDiverged
from estimators.gate import Gate
from estimators.prediction import CasadiPrediction
from fmus.native.toolchain import shared_library

LANES = 4
"""Rows of the covariance are padded to a multiple of this: the doubles of one AVX register."""

DIVERGED = {
    1: "Filter: the predicted mean is not finite.",
    2: "Filter: the covariance of the readings is not positive definite.",
    3: "Filter: the readings threw the mean to a value that is not finite.",
}
"""What the failures of `step.c` mean, in the words of `ekf`."""


class CompiledFilter:
    """The filter of `ExtendedKalmanFilter`, with its arguments, in C: equal but for rounding, much faster.

    `step` works on values as the other filter does. A loop that minds microseconds writes into `held` and
    `seen`, calls `advance` and reads `mean` and `covariance`: nothing is allocated or copied.

    Args:
        prediction: The model; its parameters may be changed in `parameters` without compiling again.
        process_noise: Density in (unit of the state)²/s, shape (n,) or (n, n).
        reading_noise: Covariance of the readings, shape (m,) or (m, m).
        period: Seconds between two steps.
        gate: States to freeze and when, or None.
        outlier_limit: Standard deviations beyond which a reading is left out, or None.
        directory: Where compiled filters are kept and found again.

    Attributes:
        mean: Shape (n,), the belief after the last step; a view into the filter's memory, as are all of
            these.
        covariance: Shape (n, n).
        held: Inputs of the next step, shape (nu,).
        seen: Readings of the next step, shape (m,).
        parameters: Of the model, in its order.
        used: 1 for every reading that the last step used, 0 for one missing or left out, shape (m,).

    Raises:
        EstimatorError: The parts do not fit each other.
        fmus.errors.CompilerMissing: There is no C compiler on this machine.
    """

    def __init__(
        self,
        prediction: CasadiPrediction,
        process_noise: ArrayLike,
        reading_noise: ArrayLike,
        period: float,
        gate: Gate | None = None,
        outlier_limit: float | None = None,
        directory: Path = Path("build/estimators"),
    ) -> None:
        """Check the parts, generate and compile the step (or find it compiled), and fill its memory."""
        self.design = design = Design.of(
            prediction, process_noise, reading_noise, period, gate, outlier_limit
        )
        n, m, nu = len(design.states), len(design.outputs), len(design.inputs)
        width = -(-n // LANES) * LANES
        layout = {
            "MEAN": n,
            "COVARIANCE": n * width,
            "HELD": nu,
            "SEEN": m,
            "PARAMETERS": prediction.parameters.size,
            "SPREAD": n * width,
            "READING_NOISE": m * m,
            "PERIOD": 1,
            "THRESHOLD": 1,
            "LIMIT_SQUARED": 1,
            "SQUARED": 1,
            "USED": m,
        }
        ends = np.cumsum(list(layout.values()))
        starts = dict(zip(layout, (ends - list(layout.values())).tolist(), strict=True))
        self._block = block = np.zeros(ends[-1])

        def part(name: str) -> Vector:
            return block[starts[name] : starts[name] + layout[name]]

        self.mean = part("MEAN")
        self.covariance = part("COVARIANCE").reshape(n, width)[:, :n]
        self.held, self.seen = part("HELD"), part("SEEN")
        self.parameters, self.used = part("PARAMETERS"), part("USED")
        self._squared = part("SQUARED")
        self.parameters[:] = prediction.parameters
        part("SPREAD").reshape(n, width)[:, :n] = design.spread
        part("READING_NOISE").reshape(m, m)[:] = design.reading_noise
        part("PERIOD")[:] = design.period
        part("THRESHOLD")[:] = design.gate_threshold
        part("LIMIT_SQUARED")[:] = design.outlier_limit**2

        sources = {
            **{file.name: file.read_text() for file in (files("estimators") / "kernel").iterdir()},
            "shape.h": _shape(prediction, design, width, starts),
        }
        digest = hashlib.sha256("".join(sources.values()).encode()).hexdigest()[:16]
        library = shared_library(sources, directory, f"filter_{digest}", flags=("-O3",))
        self._step = ctypes.CDLL(str(library.resolve())).step
        self._step.argtypes, self._step.restype = [ctypes.c_void_p], ctypes.c_int
        self._address = ctypes.c_void_p(block.ctypes.data)
        self._last: Estimate | None = None

    @property
    def squared_innovation(self) -> float:
        """Normalised innovation squared of the last step, of `used.sum()` degrees."""
        return float(self._squared[0])

    def start(self, mean: ArrayLike, covariance: ArrayLike) -> Estimate:
        """Return and hold the belief before the first step; see `ExtendedKalmanFilter.start`."""
        first = self.design.start(mean, covariance)
        self.hold(first)
        return first

    def hold(self, belief: Estimate) -> None:
        """Make `belief` the one that `advance` goes on from."""
        self.mean[:] = belief.mean
        self.covariance[:] = belief.covariance
        self._last = belief

    def advance(self) -> None:
        """Move the belief in `mean` and `covariance` on by one period, from the arrays `held` and `seen`.

        Raises:
            FilterDiverged: As `ExtendedKalmanFilter.step`; the belief stays what it was.
        """
        self._last = None
        outcome = self._step(self._address)
        if outcome:
            raise FilterDiverged(DIVERGED[outcome])

    def step(self, prior: Estimate, held: Vector, seen: Vector) -> Estimate:
        """Predict over one period, then condition on `seen`; see `ExtendedKalmanFilter.step`."""
        held_now, seen_now = self.held, self.seen
        if held.shape != held_now.shape or seen.shape != seen_now.shape:
            self.design.check(held, seen)
        if prior is not self._last:
            self.hold(prior)
        held_now[:] = held
        seen_now[:] = seen
        self.advance()
        self._last = posterior = frozen_estimate(self.mean.copy(), self.covariance.copy())
        return posterior


def _shape(prediction: CasadiPrediction, design: Design, width: int, starts: dict[str, int]) -> str:
    """Return the text of shape.h: sizes, layout, sparsity tables and the model."""
    of = prediction.equations
    given = [of.x, of.u, of.p]
    names = ["x", "u", "p"]
    functions = [
        ca.Function("slope", given, [of.derivative], names, ["f"]),
        # Transposed, because CasADi stores columns and step.c reads rows.
        ca.Function(
            "slope_and_jacobian", given, [of.derivative, of.derivative_jacobian.T], names, ["f", "A"]
        ),
        ca.Function("expected", given, [of.output, of.output_jacobian.T], names, ["h", "H"]),
    ]
    generator = ca.CodeGenerator("model", {"with_header": False, "casadi_int": "int"})
    for function in functions:
        generator.add(function)
    derivative_rows = of.derivative_jacobian.T.sparsity()
    output_rows = of.output_jacobian.T.sparsity()
    phi = _transition_pattern(derivative_rows)
    sizes = {
        "N": len(design.states),
        "M": len(design.outputs),
        "WIDTH": width,
        "ORDER": ORDER,
        "GATES": len(design.gated_states),
        "ARGUMENTS": max(function.sz_arg() for function in functions),
        "RESULTS": max(function.sz_res() for function in functions),
        "WHOLE": 1 + max(function.sz_iw() for function in functions),
        "WORK": 1 + max(function.sz_w() for function in functions),
    }
    tables = {
        "A_ROW": derivative_rows.colind(),
        "A_COLUMN": derivative_rows.row(),
        "H_ROW": output_rows.colind(),
        "H_COLUMN": output_rows.row(),
        "PHI_ROW": np.concatenate([[0], np.cumsum(phi.sum(axis=1))]).tolist(),
        "PHI_COLUMN": np.nonzero(phi)[1].tolist(),
        "GATE_STATE": design.gated_states,
        "GATE_INPUT": design.gating_inputs,
    }
    return "\n".join(
        (
            "#define CASADI_SYMBOL_EXPORT static",
            *(f"#define {name} {value}" for name, value in {**sizes, **starts}.items()),
            *(_table(name, values) for name, values in tables.items()),
            generator.dump(),
        )
    )


def _table(name: str, values: Iterable[int]) -> str:
    """Return a constant C array; one element at least, since C knows no empty ones."""
    return f"static const int {name}[] = {{{', '.join(map(str, values)) or '0'}}};"


def _transition_pattern(rows: ca.Sparsity) -> NDArray[np.bool_]:
    """Return where Φ may differ from zero, shape (n, n), from the pattern of A by rows."""
    n = rows.size1()
    pattern = np.zeros((n, n), dtype=bool)
    pattern[rows.get_triplet()[1], rows.get_triplet()[0]] = True
    reach = np.eye(n, dtype=bool)
    for _ in range(ORDER):
        reach |= pattern @ reach
    return reach
