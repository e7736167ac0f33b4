"""The extended Kalman filter in numpy: the reference that `compiled` must equal."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import get_lapack_funcs

from railgrip.base.errors import FilterDiverged
from railgrip.estimators.belief import GaussianEstimate, Matrix, Vector, seal
from railgrip.estimators.design import FilterDesign, Gate
from railgrip.estimators.discretisation import ORDER, Order, advance, transition
from railgrip.estimators.kind import FilterContext
from railgrip.estimators.prediction import Prediction

(POSV,) = get_lapack_funcs(("posv",), dtype=np.float64)
"""LAPACK's solver for positive definite systems: factor, solution, and 0 if there was a factor."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Innovation:
    """Innovation of the r readings that are used.

    Attributes:
        rows: Which readings are used, shape (r,): those that are there and no outliers.
        residual: Reading minus expected reading, shape (r,).
        jacobian: d(reading)/d(state) at the predicted mean, shape (r, n).
        noise: Covariance of the readings themselves, shape (r, r).
        covariance: Of `residual`, shape (r, r).
    """

    rows: NDArray[np.intp]
    residual: Vector
    jacobian: Matrix
    noise: Matrix
    covariance: Matrix

    @property
    def nis(self) -> float:
        """Normalised innovation squared (NIS) νᵀS⁻¹ν: chi-square of r degrees for a consistent filter."""
        return float(self.residual @ np.linalg.solve(self.covariance, self.residual)) if self.rows.size else 0.0


class GaussianFilter(ABC):
    """A Gaussian filter over a prediction: how it predicts and linearises readings is left to each subclass.

    Args:
        prediction: The model, n states and m outputs.
        process_noise, …: See `FilterDesign.of`.

    Raises:
        EstimatorError: The parts do not fit each other.
    """

    def __init__(
        self,
        prediction: Prediction,
        process_noise: ArrayLike,
        reading_noise: ArrayLike,
        period: float,
        gate: Gate | None = None,
        outlier_limit: ArrayLike | None = None,
        order: Order = ORDER,
    ) -> None:
        """Check the parts against each other."""
        self.prediction = prediction
        self.design = FilterDesign.of(prediction, process_noise, reading_noise, period, gate, outlier_limit, order)

    @classmethod
    def of_context(cls, context: FilterContext) -> "NumpyFilter":
        """Return the filter of a scenario with its first belief."""
        filter_ = cls(
            context.prediction,
            context.process_noise,
            context.reading_noise,
            context.period,
            context.gate,
            context.outlier_limit,
        )
        return NumpyFilter(filter_, filter_.start(context.mean, context.covariance))

    def start(self, mean: ArrayLike, covariance: ArrayLike) -> GaussianEstimate:
        """Return the belief before the first step: mean (n,), covariance (n,) of variances or (n, n)."""
        return self.design.start(mean, covariance)

    def step(self, prior: GaussianEstimate, inputs: Vector, readings: Vector) -> GaussianEstimate:
        """Predict over one period, then condition on the readings at its end.

        Args:
            prior: Belief at the start of the period.
            inputs: Inputs during the period, shape (nu,).
            readings: Readings at its end, shape (m,); NaN where a sensor had nothing new. Outputs that depend on
                inputs are expected under those of the period, just before the instant of the reading.

        Raises:
            EstimatorError: `inputs` or `readings` has the wrong shape.
            FilterDiverged: The mean is no longer finite, or the covariance of the readings is not positive
                definite, which happens only if the covariance of the states is not.
        """
        self.design.check(inputs, readings)
        forecast = self.predict(prior, inputs)
        return self.condition(forecast, inputs, self.innovation(forecast, inputs, readings))

    @abstractmethod
    def predict(self, prior: GaussianEstimate, inputs: Vector) -> GaussianEstimate:
        """Return the belief one period later, before anything is seen."""

    @abstractmethod
    def innovation(self, forecast: GaussianEstimate, inputs: Vector, readings: Vector) -> Innovation:
        """Return the innovation of the readings against `forecast`, without missing readings and outliers."""

    def condition(self, forecast: GaussianEstimate, inputs: Vector, innovation: Innovation) -> GaussianEstimate:
        """Return the belief after the readings of `innovation`."""
        if innovation.rows.size == 0:
            return forecast
        P, H = forecast.covariance, innovation.jacobian
        # Straight from LAPACK: scipy's checked wrapper takes longer than the rest of this function.
        _, solution, info = POSV(innovation.covariance, H @ P)
        if info != 0:
            raise FilterDiverged("Filter: the covariance of the readings is not positive definite.")
        gain = solution.T * self.free(inputs)[:, np.newaxis]
        joseph = np.eye(len(P)) - gain @ H
        # Joseph form: holds for the gated gain too, and rounding cannot make it indefinite, as (I − KH)P can.
        covariance = joseph @ P @ joseph.T + gain @ innovation.noise @ gain.T
        mean = forecast.mean + gain @ innovation.residual
        if not np.all(np.isfinite(mean)):
            raise FilterDiverged("Filter: the readings threw the mean to a value that is not finite.")
        return seal(mean, 0.5 * (covariance + covariance.T))

    def free(self, inputs: Vector) -> Vector:
        """Return 1 for every state that may move and 0 for one that its gate freezes, shape (n,)."""
        free = np.ones(len(self.design.states))
        for state, deciding in zip(self.design.gated_states, self.design.gating_inputs, strict=True):
            if inputs[deciding] < self.design.gate_threshold:
                free[state] = 0.0
        return free

    def advance(self, points: Matrix, inputs: Vector, free: Vector) -> Matrix:
        """Return states one period later, shape (…, n) as `points`; states with 0 in `free` stay.

        Raises:
            FilterDiverged: The result is not finite.
        """
        slope = self.prediction.derivative
        is_single = points.ndim == 1

        def derivative(x: Matrix) -> Matrix:
            return (slope(x, inputs) if is_single else np.array([slope(row, inputs) for row in x])) * free

        moved = advance(derivative, points, self.design.period, self.design.order)
        if not np.all(np.isfinite(moved)):
            columns = np.atleast_2d(moved).T
            pairs = zip(self.design.states, columns, strict=True)
            names = ", ".join(name for name, column in pairs if not np.all(np.isfinite(column)))
            raise FilterDiverged(f"Filter: the predicted {names} is not a finite number.")
        return moved

    def select(
        self, readings: Vector, expected: Vector, jacobian: Matrix, noise: Matrix, covariance: Matrix
    ) -> Innovation:
        """Return the innovation of the readings that are neither missing nor outliers.

        Args:
            readings: Shape (m,), NaN where a reading is missing.
            expected: Expected readings, shape (m,).
            jacobian: d(reading)/d(state), shape (m, n).
            noise: Covariance of the readings themselves, shape (m, m).
            covariance: Of readings minus expected readings, shape (m, m).
        """
        residual = readings - expected
        outside = residual**2 > self.design.outlier_limit**2 * np.diagonal(covariance)
        rows = np.flatnonzero(~(np.isnan(readings) | outside))
        if rows.size < residual.size:
            both = np.ix_(rows, rows)
            residual, jacobian, noise, covariance = residual[rows], jacobian[rows], noise[both], covariance[both]
        return Innovation(rows=rows, residual=residual, jacobian=jacobian, noise=noise, covariance=covariance)


class ExtendedKalmanFilter(GaussianFilter):
    """Extended Kalman filter over any prediction, in Joseph form; see `discretisation` for its period.

    Source: Särkkä, Bayesian Filtering and Smoothing (2013), §5.2; Schmidt gain for gated states, see `Gate`.
    """

    def predict(self, prior: GaussianEstimate, inputs: Vector) -> GaussianEstimate:
        """Return the belief one period later, before anything is seen."""
        free = self.free(inputs)
        mean, phi = self.advance(prior.mean, inputs, free), self.transition(prior.mean, inputs)
        covariance = phi @ prior.covariance @ phi.T + self.design.process_noise * np.outer(free, free)
        return seal(mean, 0.5 * (covariance + covariance.T))

    def transition(self, mean: Vector, inputs: Vector) -> Matrix:
        """Return Φ, the derivative of the state after a period by `mean`, shape (n, n)."""
        jacobian = self.prediction.derivative_jacobian(mean, inputs) * self.free(inputs)[:, np.newaxis]
        return transition(jacobian, self.design.period, self.design.order)

    def innovation(self, forecast: GaussianEstimate, inputs: Vector, readings: Vector) -> Innovation:
        """Return the innovation of the readings against `forecast`, without missing readings and outliers."""
        return self.linearise(forecast, forecast.mean, inputs, readings)

    def linearise(self, forecast: GaussianEstimate, point: Vector, inputs: Vector, readings: Vector) -> Innovation:
        """Return the innovation against `forecast` with outputs linearised at a point, shape (n,)."""
        jacobian = self.prediction.output_jacobian(point, inputs)
        expected = self.prediction.output(point, inputs) + jacobian @ (forecast.mean - point)
        noise = self.design.reading_noise
        covariance = jacobian @ forecast.covariance @ jacobian.T + noise
        return self.select(readings, expected, jacobian, noise, covariance)


class NumpyFilter:
    """Holds the belief of a filter and moves it on, as `railgrip.estimators.compiled.CompiledFilter` does by itself.

    Attributes:
        mean: Shape (n,).
        covariance: Shape (n, n).
        inputs: Inputs of the next step, shape (nu,), zero at first.
        readings: Readings of the next step, shape (m,), NaN at first.
        selection: 1 for every reading that the last step used, shape (m,), 0 at first.
        squared_innovation: Normalised innovation squared of the last step, 0 at first.
    """

    def __init__(self, filter_: GaussianFilter, first: GaussianEstimate) -> None:
        self._filter = filter_
        self._belief = first
        self.mean, self.covariance = first.mean.copy(), first.covariance.copy()
        outputs = len(filter_.design.outputs)
        self.inputs = np.zeros(len(filter_.design.inputs))
        self.readings, self.selection = np.full(outputs, np.nan), np.zeros(outputs)
        self.squared_innovation = 0.0

    def advance(self) -> None:
        """Move the belief on by one period, from the arrays `inputs` and `readings`.

        Raises:
            FilterDiverged: As the steps of the filter; the estimate is unchanged.
        """
        forecast = self._filter.predict(self._belief, self.inputs)
        innovation = self._filter.innovation(forecast, self.inputs, self.readings)
        self._belief = belief = self._filter.condition(forecast, self.inputs, innovation)
        self.selection[:] = 0.0
        self.selection[innovation.rows] = 1.0
        self.squared_innovation = innovation.nis
        self.mean[:] = belief.mean
        self.covariance[:] = belief.covariance
