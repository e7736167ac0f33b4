"""The extended Kalman filter of `ekf`, generated as C for one model."""

import ctypes
import hashlib
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from estimators.belief import Estimate, Matrix, Vector, sealed
from estimators.design import Design
from estimators.discretisation import ORDER, Order
from estimators.errors import FilterDiverged
from estimators.gate import Gate
from estimators.generated import generate
from estimators.prediction import CasadiPrediction
from fmus.native.toolchain import shared_library

DIVERGED = {
    1: "Filter: the predicted mean is not finite.",
    2: "Filter: the covariance of the readings is not positive definite.",
    3: "Filter: the readings threw the mean to a value that is not finite.",
}
"""What the failures of `step.h` mean, mostly in the words of `ekf`."""


class CompiledFilter:
    """The filter of `ExtendedKalmanFilter`, with its arguments, in C: equal but for rounding, much faster.

    `step` works on values as the other filter does. A loop that minds microseconds writes into `held` and
    `seen`, calls `advance` and reads `mean` and `covariance`: nothing is allocated or copied. What is written into
    `mean` and `covariance` from outside counts for `advance`, not for `step`; use `hold`.

    Args:
        prediction: The model; its parameters may be changed in `parameters` without compiling again.
        process_noise: Density in (unit of the state)²/s, shape (n,) or (n, n).
        reading_noise: Covariance of the readings, shape (m,) or (m, m).
        period: Seconds between two steps.
        gate: States to freeze and when, or None.
        outlier_limit: Standard deviations beyond which a reading is left out, or None.
        order: 1 for forward Euler, 4 for RK4; see `discretisation`.
        directory: Where compiled filters are kept and found again.

    Attributes:
        mean: Shape (n,), the belief after the last step; a view of the filter's memory, as are all of these.
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
        order: Order = ORDER,
        directory: Path = Path("build/estimators"),
    ) -> None:
        """Check the parts, generate the step, compile it or find it compiled, and fill its memory."""
        self.design = design = Design.of(prediction, process_noise, reading_noise, period, gate, outlier_limit, order)
        code = generate(prediction, design)
        n, m = len(design.states), len(design.outputs)
        # From the allocator of numpy and never replaced: C keeps working on this very memory.
        self._block = block = np.zeros(max(place.stop for place in code.layout.values()))

        def part(name: str) -> Vector:
            return block[code.layout[name]]

        def by_states(name: str) -> Matrix:
            return part(name).reshape(n, code.width)[:, :n]

        self.mean, self.covariance = part("MEAN"), by_states("COVARIANCE")
        self.held, self.seen, self.used = part("HELD"), part("SEEN"), part("USED")
        self.parameters = part("PARAMETERS")
        self._squared = part("SQUARED")
        self.parameters[:] = prediction.parameters
        self._spread = by_states("SPREAD")
        self._spread[:] = design.spread
        part("READING_NOISE").reshape(m, m)[:] = design.reading_noise
        part("PERIOD")[:] = design.period
        part("THRESHOLD")[:] = design.gate_threshold
        part("LIMIT_SQUARED")[:] = design.outlier_limit**2

        # The name tells filters apart, so that those of several models lie side by side.
        digest = hashlib.sha256("".join(code.sources.values()).encode()).hexdigest()[:16]
        library = shared_library(code.sources, directory, f"filter_{digest}", flags=("-O3",))
        self._step = ctypes.CDLL(str(library.resolve())).step
        self._step.argtypes, self._step.restype = [ctypes.c_void_p], ctypes.c_int
        self._address = ctypes.c_void_p(block.ctypes.data)
        # The estimate that is also in `mean` and `covariance`, so that a step from it need not copy it there.
        self._last: Estimate | None = None

    @property
    def squared_innovation(self) -> float:
        """Normalised innovation squared of the last step, of `used.sum()` degrees."""
        return float(self._squared[0])

    @property
    def entry(self) -> tuple[int, int, int]:
        """Addresses for a caller in C: `int step(double *block)`, its block, and the squared innovation.

        They and the arrays of this filter are valid as long as it lives.
        """
        step = ctypes.cast(self._step, ctypes.c_void_p).value or 0
        return step, self._block.ctypes.data, self._squared.ctypes.data

    def change_process_noise(self, process_noise: ArrayLike) -> None:
        """Trust the model otherwise from the next step on.

        Args:
            process_noise: Density in (unit of the state)²/s, shape (n,) or (n, n).

        Raises:
            EstimatorError: Wrong shape, or no covariance.
        """
        self.design = self.design.with_process_noise(process_noise)
        self._spread[:] = self.design.spread

    def start(self, mean: ArrayLike, covariance: ArrayLike) -> Estimate:
        """Return and hold the belief before the first step; see `ExtendedKalmanFilter.start`."""
        first = self.design.start(mean, covariance)
        self.hold(first)
        self._last = first
        return first

    def hold(self, belief: Estimate) -> None:
        """Make `belief` the one that `advance` goes on from."""
        self.mean[:] = belief.mean
        self.covariance[:] = belief.covariance
        self._last = None

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
        if prior is not self._last:  # the sealed estimate that is still in `mean` and `covariance`
            self.hold(prior)
        held_now[:] = held
        seen_now[:] = seen
        self.advance()
        self._last = posterior = sealed(self.mean.copy(), self.covariance.copy())
        return posterior
