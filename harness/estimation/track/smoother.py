"""The Rauch–Tung–Striebel smoother of a linear model whose readings may be missing."""

from dataclasses import dataclass

import numpy as np

from railgrip.estimators.arrays import Array


@dataclass(frozen=True, slots=True)
class Smoothed:
    """What all readings, earlier and later, tell about every instant.

    Attributes:
        mean: Shape (k, n).
        covariance: Shape (k, n, n).
    """

    mean: Array
    covariance: Array


def smooth(
    *,
    transition: Array,
    noise: Array,
    observation: Array,
    reading_noise: Array,
    readings: Array,
    start: Array,
    spread: Array,
) -> Smoothed:
    """Return the smoothed states of x[j+1] = F x[j] + q, y[j] = H[j] x[j] + r.

    Args:
        transition: F, shape (n, n).
        noise: Covariance of q, shape (n, n).
        observation: H of every instant, shape (k, m, n).
        reading_noise: Variances of independent r, shape (m,).
        readings: Readings, shape (k, m); NaN where there is none.
        start: Mean at the first instant before its readings, shape (n,).
        spread: Its covariance, shape (n, n), positive definite.

    Source: Särkkä, Bayesian Filtering and Smoothing (2013), theorems 4.2 and 8.2.
    """
    count, n = len(readings), start.size
    mean, covariance = np.empty((count, n)), np.empty((count, n, n))
    expected_mean, expected = np.empty((count, n)), np.empty((count, n, n))
    m, spread_now = start, spread
    for j in range(count):
        if j > 0:
            m, spread_now = transition @ m, transition @ spread_now @ transition.T + noise
        expected_mean[j], expected[j] = m, spread_now
        there = np.isfinite(readings[j])
        if there.any():
            H, R = observation[j][there], np.diag(reading_noise[there])
            gain = np.linalg.solve(H @ spread_now @ H.T + R, H @ spread_now).T
            remainder = np.eye(n) - gain @ H
            m = m + gain @ (readings[j][there] - H @ m)
            spread_now = remainder @ spread_now @ remainder.T + gain @ R @ gain.T
        mean[j], covariance[j] = m, spread_now
    for j in range(count - 2, -1, -1):
        G = np.linalg.solve(expected[j + 1], transition @ covariance[j]).T
        mean[j] = mean[j] + G @ (mean[j + 1] - expected_mean[j + 1])
        update = covariance[j] + G @ (covariance[j + 1] - expected[j + 1]) @ G.T
        covariance[j] = 0.5 * (update + update.T)
    return Smoothed(mean, covariance)
