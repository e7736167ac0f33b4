"""A moving horizon estimator: maximum a posteriori states of a window, by Gauss-Newton steps."""

from collections import deque
from dataclasses import replace
from typing import Final

import numpy as np

from railgrip.estimators.belief import GaussianEstimate, Matrix, Vector, tangent
from railgrip.estimators.design import FilterContext, FilterKind
from railgrip.estimators.ekf import ExtendedKalmanFilter, NumpyFilter
from railgrip.estimators.smoother import iterate_smoother

WINDOW: Final = 30
"""Number of steps of the window, 0.3 s at 10 ms: the filter determines adhesion within 0.1 s."""

EVERY: Final = 20
"""Number of steps from one solution to the next: a solution costs as much as a hundred steps of the filter in numpy."""

ITERATIONS: Final = 3
"""Largest number of linearisations of a window; the predictions are nearly linear."""


class HorizonFilter(ExtendedKalmanFilter):
    """Extended Kalman filter whose transition matrix is the exact derivative of the Runge-Kutta step.

    Without it the iteration would end near the solution, but not at it. It has no outlier limit.
    """

    def __init__(self, filter_: ExtendedKalmanFilter) -> None:
        """Take model, noises and gate of a filter."""
        self.prediction = filter_.prediction
        self.design = replace(filter_.design, outlier_limit=np.full(len(filter_.design.outputs), np.inf))

    def transition(self, mean: Vector, inputs: Vector) -> Matrix:
        """Return the derivative of the state after a period by `mean`, shape (n, n)."""
        if self.design.order == 1:
            return super().transition(mean, inputs)
        free, prediction = self.free(inputs), self.prediction
        return tangent(
            lambda x: prediction.derivative(x, inputs) * free,
            lambda x: prediction.derivative_jacobian(x, inputs) * free[:, np.newaxis],
            mean,
            self.design.period,
        )


class MovingHorizonEstimator(NumpyFilter, FilterKind):
    """Keeps the maximum a posteriori states of a moving window, given its readings and the estimate at its start.

    The cost of the start is the estimate of that time, as in a filter. Each solution starts from the extended Kalman
    filter over the window. Between two solutions the estimate advances by the extended Kalman filter, which also
    decides once about every outlier. For a linear model it is the Kalman filter. Variables have no bounds: adhesion
    is negative in traction, and the start keeps pad friction positive.

    Args:
        filter_: Extended Kalman filter with the model and its noises.
        first: Estimate before the first step.
        window: Number of steps of the window, 1 or more.
        every: Number of steps from one solution to the next, 1 or more.
        iterations: Largest number of linearisations of a window, 1 or more.

    Attributes are those of `railgrip.estimators.ekf.NumpyFilter`.

    Sources: Rao, Rawlings, Mayne, Constrained State Estimation for Nonlinear Discrete-Time Systems, IEEE Trans.
    Automatic Control 48 (2003) 246, for the window and the cost of its start.
    """

    def __init__(
        self,
        filter_: ExtendedKalmanFilter,
        first: GaussianEstimate,
        window: int = WINDOW,
        every: int = EVERY,
        iterations: int = ITERATIONS,
    ) -> None:
        super().__init__(filter_, first)
        self._every, self._iterations, self._count = every, iterations, 0
        self._steps: deque[tuple[GaussianEstimate, Vector, Vector]] = deque(maxlen=window)
        self._solver = HorizonFilter(filter_)

    @classmethod
    def of_context(cls, context: FilterContext) -> "MovingHorizonEstimator":
        """Return the estimator of a scenario with its first estimate."""
        filter_ = ExtendedKalmanFilter.without_estimate(context)
        return cls(filter_, filter_.start(context.mean, context.covariance))

    def advance(self) -> None:
        """Advance the estimate by one period, with the arrays `inputs` and `readings`.

        Raises:
            FilterDiverged: As for the step of the filter.
        """
        prior = self._belief
        super().advance()
        accepted = np.where(self.selection > 0.0, self.readings, np.nan)
        self._steps.append((prior, self.inputs.copy(), accepted))
        self._count += 1
        if self._count % self._every == 0:
            starts, inputs, readings = zip(*self._steps, strict=True)
            solved = iterate_smoother(self._solver, starts[0], np.array(inputs), np.array(readings), self._iterations)
            self._belief = GaussianEstimate(mean=solved.mean[-1], covariance=solved.covariance[-1])
            self.mean[:], self.covariance[:] = self._belief.mean, self._belief.covariance
