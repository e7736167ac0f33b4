"""Smoothers: the belief at each sample of a recording from the readings before and after it."""

from dataclasses import dataclass

import numpy as np

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import Array, GaussianEstimate, Matrix
from railgrip.estimators.ekf import ExtendedKalmanFilter


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
    count, n = len(inputs), len(first.mean)
    if lag is not None and lag < 0:
        raise EstimatorError(f"smooth: lag is a number of samples, 0 or more, got {lag}.")
    if len(readings) != count:
        raise EstimatorError(f"smooth: {count} rows of inputs require as many of readings, got {len(readings)}.")
    mean, covariance = np.empty((count + 1, n)), np.empty((count + 1, n, n))
    forecast_mean, forecast_covariance, gain = np.empty((count, n)), np.empty((count, n, n)), np.empty((count, n, n))
    belief = first
    mean[0], covariance[0] = first.mean, first.covariance
    for k, (held, seen) in enumerate(zip(inputs, readings, strict=True)):
        filter_.design.check(held, seen)
        forecast = filter_.predict(belief, held)
        phi = filter_.transition(belief.mean, held)
        gain[k] = np.linalg.solve(forecast.covariance, phi @ belief.covariance).T
        belief = filter_.condition(forecast, held, filter_.innovation(forecast, held, seen))
        forecast_mean[k], forecast_covariance[k] = forecast.mean, forecast.covariance
        mean[k + 1], covariance[k + 1] = belief.mean, belief.covariance
    smoothed = SmoothedRecording(mean=mean.copy(), covariance=covariance.copy())
    window = count if lag is None else lag
    # With all readings, one pass from the end is every window.
    ends = range(count, count + 1) if lag is None else range(1, count + 1)
    for end in ends:
        later_mean, later_covariance = mean[end], covariance[end]
        for k in range(end - 1, max(end - window, 0) - 1, -1):
            later_mean = mean[k] + gain[k] @ (later_mean - forecast_mean[k])
            later_covariance = covariance[k] + gain[k] @ (later_covariance - forecast_covariance[k]) @ gain[k].T
            smoothed.mean[k], smoothed.covariance[k] = later_mean, later_covariance
    return smoothed
