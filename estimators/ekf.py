"""The extended Kalman filter in numpy: the reference that `compiled` must equal."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import get_lapack_funcs

from railgrip.base.errors import FilterDiverged
from railgrip.estimators.belief import ORDER, GaussianEstimate, Matrix, Order, Vector, advance, seal, transition
from railgrip.estimators.design import FilterContext, FilterDesign, Gate
from railgrip.estimators.prediction import Prediction

(POSV,) = get_lapack_funcs(("posv",), dtype=np.float64)
"""LAPACK's solver for positive definite systems; returns factor, solution, and 0 if the matrix is positive definite."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Innovation:
    """Innovation of the r readings that are used.

    Attributes:
        rows: Indices of the readings that are used, neither missing nor outliers, shape (r,).
        residual: Reading minus expected reading, shape (r,).
        jacobian: d(reading)/d(state) at the predicted mean, shape (r, n).
        noise: Covariance of the reading noise, shape (r, r).
        covariance: Covariance of `residual`, shape (r, r).
    """

    rows: NDArray[np.intp]
    residual: Vector
    jacobian: Matrix
    noise: Matrix
    covariance: Matrix

    @property
    def nis(self) -> float:
        """Normalised innovation squared (NIS) νᵀS⁻¹ν: chi-square of r degrees of freedom for a consistent filter."""
        return float(self.residual @ np.linalg.solve(self.covariance, self.residual)) if self.rows.size else 0.0


class GaussianFilter(ABC):
    """A Gaussian filter for a prediction; a subclass predicts and linearises the readings.

    Args:
        prediction: The model, n states and m outputs.
        process_noise, …: See `FilterDesign.of`.

    Raises:
        EstimatorError: The arguments do not match each other.
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
        """Check the arguments against each other."""
        self.prediction = prediction
        self.design = FilterDesign.of(prediction, process_noise, reading_noise, period, gate, outlier_limit, order)

    @classmethod
    def without_estimate(cls, context: FilterContext) -> Self:
        """Return the filter of a scenario."""
        return cls(*context.arguments)

    @classmethod
    def of_context(cls, context: FilterContext) -> "NumpyFilter":
        """Return the filter of a scenario with its first estimate."""
        filter_ = cls.without_estimate(context)
        return NumpyFilter(filter_, filter_.start(context.mean, context.covariance))

    def start(self, mean: ArrayLike, covariance: ArrayLike) -> GaussianEstimate:
        """Return the estimate before the first step from a mean (n,) and variances (n,) or a covariance (n, n)."""
        return self.design.start(mean, covariance)

    def step(self, prior: GaussianEstimate, inputs: Vector, readings: Vector) -> GaussianEstimate:
        """Predict over one period, then condition on the readings at its end.

        Args:
            prior: Estimate at the start of the period.
            inputs: Inputs during the period, shape (nu,).
            readings: Readings at the end of the period, shape (m,); NaN where a sensor has no new reading. Outputs that
                depend on inputs are predicted with those of the period, just before the instant of the reading.

        Raises:
            EstimatorError: `inputs` or `readings` has the wrong shape.
            FilterDiverged: The mean is not finite, or the covariance of the readings is not positive
                definite, which happens only if the covariance of the states is not.
        """
        self.design.check(inputs, readings)
        forecast = self.predict(prior, inputs)
        return self.condition(forecast, inputs, self.innovation(forecast, inputs, readings))

    @abstractmethod
    def predict(self, prior: GaussianEstimate, inputs: Vector) -> GaussianEstimate:
        """Return the estimate one period later, before the readings."""

    @abstractmethod
    def innovation(self, forecast: GaussianEstimate, inputs: Vector, readings: Vector) -> Innovation:
        """Return the innovation of the readings against `forecast`, without missing readings and outliers."""

    def condition(self, forecast: GaussianEstimate, inputs: Vector, innovation: Innovation) -> GaussianEstimate:
        """Return the estimate after the readings of `innovation`."""
        if innovation.rows.size == 0:
            return forecast
        P, H = forecast.covariance, innovation.jacobian
        # K = P Hᵀ S⁻¹ from S Kᵀ = H P, without an inverse. LAPACK is called directly, because scipy's checks take
        # longer than the rest of this function.
        _, solution, info = POSV(innovation.covariance, H @ P)
        if info != 0:
            raise FilterDiverged("Filter: the covariance of the readings is not positive definite.")
        gain = solution.T * self.free(inputs)[:, np.newaxis]
        joseph = np.eye(len(P)) - gain @ H
        # Joseph form: it is valid for the gated gain too, which is not optimal, and rounding cannot make it indefinite,
        # as it can (I − KH)P.
        covariance = joseph @ P @ joseph.T + gain @ innovation.noise @ gain.T
        mean = forecast.mean + gain @ innovation.residual
        if not np.all(np.isfinite(mean)):
            raise FilterDiverged("Filter: the correction by the readings made the mean infinite or NaN.")
        return seal(mean, 0.5 * (covariance + covariance.T))

    def free(self, inputs: Vector) -> Vector:
        """Return 1 for every state that may change and 0 for one that its gate freezes, shape (n,)."""
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
            noise: Covariance of the reading noise, shape (m, m).
            covariance: Of readings minus expected readings, shape (m, m).
        """
        residual = readings - expected
        # Each reading is tested by its own variance, before the update: one outlier must not reject the others.
        outside = residual**2 > self.design.outlier_limit**2 * np.diagonal(covariance)
        rows = np.flatnonzero(~(np.isnan(readings) | outside))
        if rows.size < residual.size:
            both = np.ix_(rows, rows)
            residual, jacobian, noise, covariance = residual[rows], jacobian[rows], noise[both], covariance[both]
        return Innovation(rows=rows, residual=residual, jacobian=jacobian, noise=noise, covariance=covariance)


class ExtendedKalmanFilter(GaussianFilter):
    """Extended Kalman filter for any prediction, in Joseph form; see `belief` for the prediction step.

    Source: Särkkä, Bayesian Filtering and Smoothing (2013), §5.2; Schmidt gain for gated states, see `Gate`.
    """

    def predict(self, prior: GaussianEstimate, inputs: Vector) -> GaussianEstimate:
        """Return the estimate one period later, before the readings."""
        # Φ is linearised at the prior mean, where RK4 starts: both describe the same map if f is linear.
        return self.predict_linearised(prior, prior.mean, self.transition(prior.mean, inputs), inputs)

    def predict_linearised(
        self, prior: GaussianEstimate, point: Vector, phi: Matrix, inputs: Vector
    ) -> GaussianEstimate:
        """Return the estimate one period later by the linear map `phi` about a point, shape (n,)."""
        # Zero derivative, transition and noise for frozen states: consider states, see `Gate`. The rows of A are zero,
        # but not its columns, so that the other states' covariances with them are updated.
        free = self.free(inputs)
        mean = self.advance(point, inputs, free) + phi @ (prior.mean - point)
        covariance = phi @ prior.covariance @ phi.T + self.design.process_noise * np.outer(free, free)
        # Rounding makes the product slightly asymmetric, and the asymmetry would grow from step to step.
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
        covariance = jacobian @ forecast.covariance @ jacobian.T + noise  # S = H P Hᵀ + R
        return self.select(readings, expected, jacobian, noise, covariance)


class NumpyFilter:
    """Keeps and advances the estimate of a filter, with the interface of `railgrip.estimators.compiled.CompiledFilter`.

    Attributes:
        mean: Shape (n,).
        covariance: Shape (n, n).
        inputs: Inputs of the next step, shape (nu,), initially zero.
        readings: Readings of the next step, shape (m,), initially NaN.
        selection: 1 for every reading that the last step used, shape (m,), initially 0.
        squared_innovation: Normalised innovation squared of the last step, initially 0.
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
        """Advance the estimate by one period, with the arrays `inputs` and `readings`.

        Raises:
            FilterDiverged: As for the step of the filter; the estimate is unchanged.
        """
        forecast = self._filter.predict(self._belief, self.inputs)
        innovation = self._filter.innovation(forecast, self.inputs, self.readings)
        self._belief = self._filter.condition(forecast, self.inputs, innovation)
        self._publish(self._belief, innovation.rows, innovation.nis)

    def _publish(self, belief: GaussianEstimate, rows: NDArray[np.intp], squared_innovation: float) -> None:
        self.mean[:], self.covariance[:] = belief.mean, belief.covariance
        self.selection[:] = 0.0
        self.selection[rows] = 1.0
        self.squared_innovation = squared_innovation
