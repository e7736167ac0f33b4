"""The extended Kalman filter of `ekf`, generated as C for one model: CasADi functions or an FMU."""

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from railgrip.base.errors import EstimatorError, FilterDiverged
from railgrip.estimators.belief import ORDER, GaussianEstimate, Matrix, Order, Vector, seal
from railgrip.estimators.design import FilterContext, FilterDesign, Gate
from railgrip.estimators.model_in_c import generate
from railgrip.estimators.prediction import PredictionInC
from railgrip.fmus.native.toolchain import shared_library

DIVERGED = {
    1: "Filter: the predicted mean is not finite.",
    2: "Filter: the covariance of the readings is not positive definite.",
    3: "Filter: the correction by the readings made the mean infinite or NaN.",
}
"""Failure codes of `step.h` and their messages, mostly as in `ekf`."""

MODEL_FAILED = 4
"""Failure code of `step.h` whose message comes from the prediction."""


@cache
def _has_avx2() -> bool:
    # A cache may belong to several machines: what a filter is compiled for is part of its key.
    source = files("railgrip.estimators").joinpath("processor.c").read_text(encoding="utf-8")
    return bool(ctypes.CDLL(str(shared_library({"processor.c": source}, "processor"))).has_avx2())


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterRecord:
    """Results of a filter over many steps.

    Attributes:
        mean: Mean after every step, shape (k, n).
        variance: Variance of each state, shape (k, n).
        expectation: Predicted readings, shape (k, m).
        squared_innovation: Normalised innovation squared, shape (k,).
        used: 1 for every reading that a step used, 0 for missing readings and outliers, shape (k, m).
        covariance: Covariance after every step, shape (k, n, n); empty unless requested.
    """

    mean: Matrix
    variance: Matrix
    expectation: Matrix
    squared_innovation: Vector
    used: Matrix
    covariance: Matrix

    @property
    def degrees(self) -> Vector:
        """Number of readings that were used, the degrees of freedom of `squared_innovation`, shape (k,)."""
        return self.used.sum(axis=1)


class StepInC:
    """A filter whose step is C code that works on one block of memory; subclasses allocate it and define its layout.

    Attributes:
        sources: File name to text; `plain.c` has the step `int step_plain(double *block)` for any machine.
    """

    sources: Mapping[str, str]

    _block: Vector
    _nis: Vector

    def load(self, sources: Mapping[str, str]) -> ctypes.CDLL:
        """Return the library with `int step(double *block)`, compiled now or taken from the cache."""
        self.sources = sources
        other, flags = ("plain.c", ("-O3", "-DWIDE")) if _has_avx2() else ("wide.c", ("-O3",))
        units = sorted(name for name in sources if name.endswith(".c") and name != other)
        library = ctypes.CDLL(str(shared_library(sources, "filter", units=units, flags=flags)))
        self._step = library.step
        self._step.argtypes, self._step.restype = [ctypes.c_void_p], ctypes.c_int
        self._address = ctypes.c_void_p(self._block.ctypes.data)
        return library

    @property
    def squared_innovation(self) -> float:
        """Normalised innovation squared of the last step, with `selection.sum()` degrees of freedom."""
        return float(self._nis[0])

    @property
    def entry(self) -> tuple[int, int, int]:
        """Addresses for a caller in C: `int step(double *block)`, its block, and the squared innovation.

        They and the arrays of this filter are valid during its lifetime.
        """
        step = ctypes.cast(self._step, ctypes.c_void_p).value or 0
        return step, self._block.ctypes.data, self._nis.ctypes.data

    def advance(self) -> None:
        """Advance the estimate by one period, with the arrays `inputs` and `readings`.

        Raises:
            FilterDiverged: As for `ExtendedKalmanFilter.step`; the estimate is unchanged.
        """
        outcome = self._step(self._address)
        if outcome:
            raise FilterDiverged(self.failure(outcome))

    def failure(self, outcome: int) -> str:
        """Return the error for a non-zero return value of the function of `entry`."""
        return DIVERGED[outcome]


class CompiledFilter(StepInC):
    """`ExtendedKalmanFilter` in C, with the same arguments: equal except for rounding, and much faster.

    `step` maps values to values like that of the other filter. A fast loop instead writes into `inputs` and `readings`,
    calls `advance` and reads `mean` and `covariance`, without allocation or copy. To set the estimate from outside, use
    `hold`: `step` ignores values that are written into `mean` and `covariance`.

    Args:
        prediction: The model; its parameters may be changed in `parameters` without compiling again.
        process_noise, …: See `FilterDesign.of`.

    Attributes:
        mean: Estimate after the last step, shape (n,). This and the following arrays are views of the filter's memory.
        covariance: Shape (n, n).
        inputs: Inputs of the next step, shape (nu,).
        readings: Readings of the next step, shape (m,).
        parameters: Parameters of the model, in its order.
        selection: 1 for every reading that the last step used, 0 for missing readings and outliers, shape (m,).

    Raises:
        EstimatorError: The arguments do not match each other.
        railgrip.base.errors.CompilerMissing: There is no C compiler on this machine.
    """

    def __init__(
        self,
        prediction: PredictionInC,
        process_noise: ArrayLike,
        reading_noise: ArrayLike,
        period: float,
        gate: Gate | None = None,
        outlier_limit: ArrayLike | None = None,
        order: Order = ORDER,
    ) -> None:
        """Check the arguments, generate and compile the step, and initialise its memory."""
        self.design = design = FilterDesign.of(
            prediction, process_noise, reading_noise, period, gate, outlier_limit, order
        )
        code = generate(prediction.in_c(), design.gated_states, design.gating_inputs, design.order)
        self._prediction = prediction
        n, m = len(design.states), len(design.outputs)
        # Never replaced: the C code keeps a pointer to this memory.
        self._block = block = np.zeros(max(place.stop for place in code.layout.values()))

        def part(name: str) -> Vector:
            return block[code.layout[name]]

        def by_states(name: str) -> Matrix:
            return part(name).reshape(n, code.width)[:, :n]

        self.mean, self.covariance = part("MEAN"), by_states("COVARIANCE")
        self.inputs, self.readings, self.selection = part("INPUT"), part("READING"), part("USED")
        self.parameters = part("PARAMETERS")
        self._nis = part("SQUARED")
        self.parameters[:] = prediction.parameters
        self._process_noise, self._reading_noise = by_states("PROCESS_NOISE"), part("READING_NOISE").reshape(m, m)
        self._process_noise[:] = design.process_noise
        self._reading_noise[:] = design.reading_noise
        part("PERIOD")[:] = design.period
        part("THRESHOLD")[:] = design.gate_threshold
        part("LIMIT_SQUARED")[:] = design.outlier_limit**2

        self._run = self.load(code.sources).run
        self._run.argtypes = [ctypes.c_void_p, *[ctypes.c_int] * 2, *[ctypes.c_void_p] * 10]
        self._run.restype = ctypes.c_int
        # The estimate that `mean` and `covariance` already contain, so that a step from it need not copy it.
        self._last: GaussianEstimate | None = None

    @classmethod
    def of_context(cls, context: FilterContext) -> Self:
        """Return the filter of a scenario with its first estimate."""
        filter_ = cls(*context.arguments)
        filter_.start(context.mean, context.covariance)
        return filter_

    def failure(self, outcome: int) -> str:
        """Return the error for a non-zero return value of a step."""
        return self._prediction.failure() if outcome == MODEL_FAILED else super().failure(outcome)

    def start(self, mean: ArrayLike, covariance: ArrayLike) -> GaussianEstimate:
        """Set and return the estimate before the first step; see `ExtendedKalmanFilter.start`."""
        first = self.design.start(mean, covariance)
        self.hold(first)
        self._last = first
        return first

    def hold(self, belief: GaussianEstimate) -> None:
        """Set the estimate from which `advance` continues."""
        self.mean[:] = belief.mean
        self.covariance[:] = belief.covariance
        self._last = None

    def advance(self) -> None:
        """Advance the estimate in `mean` and `covariance` by one period; see `StepInC.advance`."""
        self._last = None
        super().advance()

    def retune(self, process_noise: ArrayLike, reading_noise: ArrayLike | None = None) -> None:
        """Replace the noises from the next step on, without compiling again.

        Args:
            process_noise: See `FilterDesign.of`.
            reading_noise: See `FilterDesign.of`; None keeps the present one.

        Raises:
            EstimatorError: They do not match the model.
        """
        self.design = design = self.design.with_noises(process_noise, reading_noise)
        self._process_noise[:] = design.process_noise
        self._reading_noise[:] = design.reading_noise

    def follow(
        self,
        prior: GaussianEstimate,
        inputs: Matrix,
        readings: Matrix,
        *,
        every: int = 1,
        integrals: Mapping[str, str] = MappingProxyType({}),
        with_covariance: bool = False,
    ) -> FilterRecord:
        """Return the estimates over many steps from `prior`, in one call to C.

        The call releases the interpreter lock; two threads must not use the same filter at once.

        Args:
            prior: Estimate before the first step.
            inputs: Inputs of every step, shape (k, nu).
            readings: Readings of every step, shape (k, m).
            every: Steps from one row of the results to the next.
            integrals: Input → state whose integral it is (forward Euler), starting from its value in the attribute
                `inputs`; the input's column in the argument is not used.
            with_covariance: Whether the covariances are kept.

        Raises:
            EstimatorError: Wrong shapes or names.
            FilterDiverged: As for `step`; `after` is the number of successful steps.
        """
        input_rows, reading_rows = (np.ascontiguousarray(rows, dtype=np.float64) for rows in (inputs, readings))
        count, n, m = len(input_rows), self.mean.size, self.readings.size
        if input_rows.shape != (count, self.inputs.size) or reading_rows.shape != (count, m):
            raise EstimatorError(
                f"follow: requires k rows of {self.inputs.size} inputs and {m} readings, "
                f"got shapes {np.shape(inputs)} and {np.shape(readings)}."
            )
        sources = self._integrated_states(integrals)
        if every < 1:
            raise EstimatorError(f"follow: every must be 1 or more, got {every}.")
        self.hold(prior)
        rows = count // every
        estimates = FilterRecord(
            mean=np.empty((rows, n)),
            variance=np.empty((rows, n)),
            expectation=np.empty((rows, m)),
            squared_innovation=np.empty(rows),
            used=np.empty((rows, m)),
            covariance=np.empty((rows if with_covariance else 0, n, n)),
        )
        outcome, integral_of = ctypes.c_int(0), np.array([*sources, 0], dtype=np.intc)
        arrays = (
            integral_of, input_rows, reading_rows, estimates.mean, estimates.variance,
            estimates.covariance if with_covariance else None, estimates.expectation, estimates.squared_innovation,
            estimates.used,
        )  # fmt: skip
        pointers = [None if array is None else ctypes.c_void_p(array.ctypes.data) for array in arrays]
        steps = self._run(self._address, count, every, *pointers, ctypes.byref(outcome))
        if outcome.value:
            raise FilterDiverged(self.failure(outcome.value), after=int(steps))
        return estimates

    def _integrated_states(self, integrals: Mapping[str, str]) -> list[int]:
        """Return for each input the index of the state whose integral it is, or -1."""
        states, inputs = list(self.design.states), self.design.inputs
        unknown = sorted((integrals.keys() - {*inputs}) | ({*integrals.values()} - {*states}))
        if unknown:
            raise EstimatorError(f"follow: there is no input or state {unknown[0]}.")
        return [states.index(integrals[name]) if name in integrals else -1 for name in inputs]

    def step(self, prior: GaussianEstimate, inputs: Vector, readings: Vector) -> GaussianEstimate:
        """Predict over one period, then condition on `readings`; see `ExtendedKalmanFilter.step`."""
        own_inputs, own_readings = self.inputs, self.readings
        if inputs.shape != own_inputs.shape or readings.shape != own_readings.shape:
            self.design.check(inputs, readings)
        if prior is not self._last:  # the sealed estimate that is still in `mean` and `covariance`
            self.hold(prior)
        own_inputs[:] = inputs
        own_readings[:] = readings
        self.advance()
        self._last = posterior = seal(self.mean.copy(), self.covariance.copy())
        return posterior
