"""Consistency of a filter: innovations over their claimed standard deviation.

Two questions to innovations, the same for every filter of this project. `nis_ratio` says how consistent a filter is: a
figure. `loss_step` returns when its estimate became meaningless: innovations ten times as large as claimed, for the
majority of a hundred steps, are not a matter of tuning. A lost estimate may still be finite (a maximum friction of
1e42).
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaincinv

from railgrip.base.errors import EstimatorError


def _chi_square(probability: float, degrees: NDArray[np.float64]) -> NDArray[np.float64]:
    # scipy.stats has these quantiles, but takes a second to import.
    different, place = np.unique(degrees, return_inverse=True)  # many steps use the same few numbers of readings
    return (2.0 * gammaincinv(different / 2.0, probability))[place]


WINDOW = 100
"""Steps over which `loss_step` judges: one odd reading, or the first steps of a start, must not decide."""

FAR = 10.0
"""How many times its claimed deviation an innovation may have before the claim means nothing."""


def nis_ratio(nis: ArrayLike, degrees: ArrayLike) -> float | None:
    """Return the median of NIS over the median of its chi-square: 1 for a consistent filter, None without readings.

    Above 1 the filter is surer than its readings allow, below 1 less sure. The median, because a few outliers would
    decide a mean.

    Args:
        nis: Of each step, shape (k,).
        degrees: Readings that each step used, shape (k,); steps of none are left out.
    """
    values, counts = np.asarray(nis, dtype=np.float64), np.asarray(degrees, dtype=np.float64)
    read = counts > 0
    return float(np.median(values[read] / _chi_square(0.5, counts[read]))) if read.any() else None


def loss_step(nis: ArrayLike, degrees: ArrayLike, readings: ArrayLike | None = None) -> int | None:
    """Return the step at which a filter's belief is known to be meaningless, None while it is not.

    A step speaks against the filter if its NIS is beyond the 99.9 % bound of its chi-square even with deviations `FAR`
    times as large, is NaN, or if the filter rejected the majority of the readings as outliers. A filter is lost at the
    end of the first `WINDOW` steps (of all steps if there are fewer) of which the majority speaks against it.

    Args:
        nis: Of each step, shape (k,).
        degrees: Readings that each step used, shape (k,).
        readings: That there were, shape (k,); as many as were used when None.
    """
    values, counts = np.asarray(nis, dtype=np.float64), np.asarray(degrees, dtype=np.float64)
    there = counts if readings is None else np.asarray(readings, dtype=np.float64)
    steps = np.flatnonzero(there > 0)
    if steps.size == 0:
        return None
    bound = FAR**2 * _chi_square(0.999, np.maximum(counts[steps], 1.0))
    against = ~(values[steps] <= bound) | (2.0 * counts[steps] < there[steps])
    window = min(WINDOW, steps.size)
    total = np.concatenate([[0], np.cumsum(against)])
    windows = np.flatnonzero(2 * (total[window:] - total[:-window]) > window)
    return int(steps[windows[0] + window - 1]) if windows.size else None


def delay(time: NDArray[np.float64], truth: ArrayLike, estimate: ArrayLike, step_at: float, tolerance: float) -> float:
    """Return how long after a step of the truth the estimate is within `tolerance` of it, for good.

    Args:
        time: Instants in s, increasing, shape (k,).
        truth: The quantity that steps, shape (k,).
        estimate: What the filter says, shape (k,), same unit.
        step_at: Instant of the step in s; the record should end before the truth steps again.
        tolerance: Error that counts as arrived, in the unit of the quantity.

    Returns:
        Seconds from `step_at` to the first instant from which on the error stays within `tolerance`; infinity
        if it does not within the record.

    Raises:
        EstimatorError: The record holds nothing after the step.
    """
    after = time >= step_at
    if not np.any(after):
        raise EstimatorError(f"delay: the record ends at {time[-1]} s, before the step at {step_at} s.")
    outside = np.flatnonzero(np.abs(np.asarray(estimate) - np.asarray(truth))[after] > tolerance)
    instants = time[after]
    if outside.size == 0:
        return float(instants[0] - step_at)
    arrival = outside[-1] + 1
    return float(instants[arrival] - step_at) if arrival < instants.size else math.inf
