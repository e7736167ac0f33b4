"""Consistency of a filter: innovations over their claimed standard deviation.

Two measures of the innovations, the same for every filter of this project. `nis_ratio` quantifies how consistent a
filter is. `loss_step` is the step at which the estimate became meaningless: innovations ten times as large as claimed
in the majority of a hundred steps are not a matter of tuning. A lost estimate may still be finite (such as a maximum
friction of 1e42).
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railgrip.base.errors import EstimatorError


def _chi_square(probability: float, degrees: NDArray[np.float64]) -> NDArray[np.float64]:
    # scipy.stats has these quantiles, but takes a second to import; stops without estimates do without both.
    from scipy.special import gammaincinv

    different, place = np.unique(degrees, return_inverse=True)  # many steps use the same few numbers of readings
    return (2.0 * gammaincinv(different / 2.0, probability))[place]


WINDOW = 100
"""Number of steps that `loss_step` considers: a single outlier, or the first steps, must not decide."""

FAR = 10.0
"""Ratio of an innovation to its claimed standard deviation beyond which the claim is meaningless."""


def nis_ratio(nis: ArrayLike, degrees: ArrayLike) -> float | None:
    """Return the median of NIS over the median of its chi-square: 1 for a consistent filter, None without readings.

    Above 1 the filter is overconfident, below 1 it is too cautious. Medians are used because a few outliers would
    dominate a mean.

    Args:
        nis: Normalised innovation squared of each step, shape (k,).
        degrees: Number of readings that each step used, shape (k,); steps without readings are ignored.
    """
    values, counts = np.asarray(nis, dtype=np.float64), np.asarray(degrees, dtype=np.float64)
    read = counts > 0
    return float(np.median(values[read] / _chi_square(0.5, counts[read]))) if read.any() else None


def loss_step(nis: ArrayLike, degrees: ArrayLike, readings: ArrayLike | None = None) -> int | None:
    """Return the step at which a filter's estimate is known to be meaningless, or None.

    A step counts against the filter if its NIS exceeds the 99.9 % bound of its chi-square even with standard deviations
    `FAR` times as large, if its NIS is NaN, or if the filter rejected the majority of the readings as outliers. A
    filter is lost at the end of the first window of `WINDOW` steps (or of all steps, if there are fewer) in which the
    majority of steps counts against it.

    Args:
        nis: Normalised innovation squared of each step, shape (k,).
        degrees: Number of readings that each step used, shape (k,).
        readings: Number of readings that were available, shape (k,); None if all were used.
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
    """Return the settling time of an estimate after a step of the true value.

    Args:
        time: Instants, increasing [s], shape (k,).
        truth: True value of the quantity, shape (k,).
        estimate: Estimate, shape (k,), in the same unit.
        step_at: Instant of the step [s]; the record should end before the next step.
        tolerance: Largest error that counts as settled, in the unit of the quantity.

    Returns:
        Time from `step_at` to the first instant after which the error remains within `tolerance` [s]; infinity if it
        does not within the record.

    Raises:
        EstimatorError: The record has no samples after the step.
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
