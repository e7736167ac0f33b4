"""Smoothers: the belief at each sample of a recording from the readings before and after it."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import Array, GaussianEstimate, Matrix
from railgrip.estimators.ekf import ExtendedKalmanFilter

CONVERGED: Final = 1e-6
"""Change of a state, in its standard deviations, below which the iteration ends."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SmoothedRecording:
    """Beliefs about a recording of k steps, the start first.

    Attributes:
        mean: Shape (k + 1, n).
        covariance: Shape (k + 1, n, n).
    """

    mean: Matrix
    covariance: Array


def smooth(
    filter_: ExtendedKalmanFilter, first: GaussianEstimate, inputs: Matrix, readings: Matrix, lag: int | None = None
) -> SmoothedRecording:
    """Return the beliefs of the extended Rauch-Tung-Striebel smoother.

    Args:
        filter_: The filter that runs forwards.
        first: Belief before the first step.
        inputs: Inputs of every step, shape (k, nu).
        readings: Readings of every step, NaN where missing, shape (k, m).
        lag: Number of later readings that each belief uses (fixed lag); None for all (fixed interval).

    Raises:
        EstimatorError: A negative lag, or shapes that do not fit.
        FilterDiverged: As the steps of the filter.

    Source: Särkkä, Bayesian Filtering and Smoothing (2013), §9.1; the fixed lag repeats it for every window.
    """
    count = len(inputs)
    if lag is not None and lag < 0:
        raise EstimatorError(f"smooth: lag is a number of samples, 0 or more, got {lag}.")
    if len(readings) != count:
        raise EstimatorError(f"smooth: {count} rows of inputs require as many of readings, got {len(readings)}.")
    forward = _filter(filter_, first, inputs, readings)
    if lag is None:
        return forward.smoothed(0, count)
    mean, covariance = forward.mean.copy(), forward.covariance.copy()
    for end in range(1, count + 1):
        begin = max(end - lag, 0)
        window = forward.smoothed(begin, end)
        mean[begin:end], covariance[begin:end] = window.mean[:-1], window.covariance[:-1]
    return SmoothedRecording(mean=mean, covariance=covariance)


def iterate_smoother(
    filter_: ExtendedKalmanFilter, first: GaussianEstimate, inputs: Matrix, readings: Matrix, iterations: int
) -> SmoothedRecording:
    """Return the maximum a posteriori states of a window, by Gauss-Newton steps.

    They minimise |x₀ − first|² + Σ |xₖ₊₁ − f(xₖ)|² + Σ |yₖ − h(xₖ)|², each weighted by its inverse covariance. A
    smoother of the model linearised along the last solution is a Gauss-Newton step. The iteration ends when no state
    changes by more than `CONVERGED`. Covariances are those of the last linearisation. The transition matrix of
    `filter_` must be the exact derivative of its step, as that of
    `railgrip.estimators.filters.moving_horizon.HorizonFilter`.

    Arguments and errors are those of `smooth`; `iterations` is the largest number of linearisations, 1 or more.

    Source: Bell, The Iterated Kalman Smoother as a Gauss-Newton Method, SIAM J. Optimization 4 (1994) 626.
    """
    found = smooth(filter_, first, inputs, readings)
    for _ in range(iterations - 1):
        points = found.mean
        found = _filter(filter_, first, inputs, readings, points).smoothed(0, len(inputs))
        if np.all((found.mean - points) ** 2 <= CONVERGED**2 * np.einsum("kii->ki", found.covariance)):
            break
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class _Filtered(SmoothedRecording):
    """Beliefs of a filter, the start first, forecasts between them, and the gains of the smoother.

    Shapes (k + 1, n) and (k + 1, n, n), else (k, n) and (k, n, n).
    """

    forecast_mean: Matrix
    forecast_covariance: Array
    gain: Array

    def smoothed(self, begin: int, end: int) -> SmoothedRecording:
        """Return the beliefs from step `begin` to `end` by the readings up to `end`."""
        mean, covariance = self.mean[begin : end + 1].copy(), self.covariance[begin : end + 1].copy()
        for k in range(end - 1, begin - 1, -1):
            gain, row = self.gain[k], k - begin
            mean[row] += gain @ (mean[row + 1] - self.forecast_mean[k])
            covariance[row] += gain @ (covariance[row + 1] - self.forecast_covariance[k]) @ gain.T
        return SmoothedRecording(mean=mean, covariance=covariance)


def _filter(
    filter_: ExtendedKalmanFilter,
    first: GaussianEstimate,
    inputs: Matrix,
    readings: Matrix,
    points: Matrix | None = None,
) -> _Filtered:
    """Return the beliefs of the filter, linearised at its own means, or at `points` of shape (k + 1, n)."""
    beliefs, forecasts, gains = [first], list[GaussianEstimate](), list[Matrix]()
    for k, (held, seen) in enumerate(zip(inputs, readings, strict=True)):
        filter_.design.check(held, seen)
        prior = beliefs[-1]
        point = prior.mean if points is None else points[k]
        phi = filter_.transition(point, held)
        forecast = filter_.predict_linearised(prior, point, phi, held)
        if points is None:
            innovation = filter_.innovation(forecast, held, seen)
        else:
            innovation = filter_.linearise(forecast, points[k + 1], held, seen)
        gain = np.linalg.solve(forecast.covariance, phi @ prior.covariance).T
        gains.append(np.asarray(gain, dtype=np.float64))
        forecasts.append(forecast)
        beliefs.append(filter_.condition(forecast, held, innovation))
    return _Filtered(
        mean=np.array([belief.mean for belief in beliefs]),
        covariance=np.array([belief.covariance for belief in beliefs]),
        forecast_mean=np.array([forecast.mean for forecast in forecasts]),
        forecast_covariance=np.array([forecast.covariance for forecast in forecasts]),
        gain=np.array(gains),
    )
