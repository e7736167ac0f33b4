"""Figures of the estimator: how wrong, how sure, how late."""

from dataclasses import dataclass

import numpy as np
import xarray
from numpy.typing import NDArray

Array = NDArray[np.float64]

SLOWEST = 10 / 3.6  # m/s; below, slip is the ratio of two small numbers and no one asks for the adhesion
_LONGEST_DELAY = 0.5  # s
_DELAY_STEP = 0.005  # s


@dataclass(frozen=True, slots=True)
class Errors:
    """Error of the estimated adhesion above 10 km/h, for each group.

    Attributes:
        rmse: Root mean square error.
        bias: Mean of estimate minus truth.
        within_95: Magnitude that 95 % of the errors do not exceed.
        nees: Mean of (error/standard deviation)²; 1 for an estimator as sure as it is right.
        delay: Shift of the estimate against the truth that fits best [s], 0 to 0.5 in steps of 5 ms.
    """

    rmse: tuple[float, ...]
    bias: tuple[float, ...]
    within_95: tuple[float, ...]
    nees: tuple[float, ...]
    delay: tuple[float, ...]


def adhesion_errors(trace: xarray.Dataset) -> Errors | None:
    """Return the errors of the estimated adhesion, or None of a stop without estimates or above 10 km/h."""
    if "estimate_adhesion" not in trace:
        return None
    moving = trace["speed"].values > SLOWEST
    truth = trace["group_adhesion"].values[moving]
    estimate = trace["estimate_adhesion"].values[moving]
    spread = trace["estimate_adhesion_sd"].values[moving]
    if len(truth) < 2:
        return None
    error = estimate - truth
    period = float(trace["time"].values[1] - trace["time"].values[0])
    return Errors(
        rmse=_row(np.sqrt(np.mean(error**2, axis=0))),
        bias=_row(np.mean(error, axis=0)),
        within_95=_row(np.quantile(np.abs(error), 0.95, axis=0)),
        nees=_row(np.mean((error / spread) ** 2, axis=0)),
        delay=_row(_delay(truth, estimate, period)),
    )


def _delay(truth: Array, estimate: Array, period: float) -> Array:
    """Return the shift that minimises the mean square of estimate(t + shift) − truth(t), shape (4,) [s].

    All shifts are judged on the same samples of the truth, so that a hard passage cannot drop out with a
    shift.
    """
    step = max(1, round(_DELAY_STEP / period))
    longest = min(round(_LONGEST_DELAY / period), len(truth) // 2)
    shifts = np.arange(0, longest + 1, step)
    judged = len(truth) - longest
    squares = np.stack([np.mean((estimate[s : s + judged] - truth[:judged]) ** 2, axis=0) for s in shifts])
    return np.asarray(shifts[np.argmin(squares, axis=0)] * period, dtype=np.float64)


def rmse(trace: xarray.Dataset, estimated: str, true: str) -> tuple[float, ...] | None:
    """Return the root mean square error of another estimate above 10 km/h, or None without it."""
    if estimated not in trace:
        return None
    moving = trace["speed"].values > SLOWEST
    if not moving.any():
        return None
    error = trace[estimated].values[moving] - trace[true].values[moving]
    return _row(np.atleast_1d(np.sqrt(np.mean(error**2, axis=0))))


def _row(values: Array) -> tuple[float, ...]:
    return tuple(map(float, values))
