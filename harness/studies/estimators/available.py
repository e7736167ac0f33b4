"""Errors of the adhesion available, where the slope of the creep curve determines it."""

import math
from typing import Final

import numpy as np
import xarray
from scipy.ndimage import maximum_filter1d

from railgrip.estimation.judge import rms
from railgrip.estimators.belief import Array, Matrix, Vector
from railgrip.estimators.rail import estimate_slope
from railgrip.studies.estimators.recordings import PERIOD
from railgrip.trace.estimation import SLOWEST

TRUTH: Final = "peak_adhesion"
"""Variable of the recordings: maximum of the creep curve of a group at its place and instant."""

RECENT: Final = 1.0
"""Time over which the reference takes the largest adhesion [s]."""


def with_slip(
    trace: xarray.Dataset, speed: Vector, wheels: Matrix, deviations: tuple[Vector, Matrix], radius: Vector
) -> xarray.Dataset:
    """Return a recording with the slip 1 − rω/v of estimated speeds, and its deviation, as a trace has them.

    Args:
        trace: The recording, k samples.
        speed: Of the train, shape (k,) [m/s].
        wheels: Rotational speeds, shape (k, groups) [rad/s].
        deviations: Standard deviations of both.
        radius: Nominal radius of each group, shape (groups,) [m].
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = radius * wheels / speed[:, np.newaxis]
        deviation = np.hypot(radius * deviations[1], ratio * deviations[0][:, np.newaxis]) / speed[:, np.newaxis]
    groups = ("time", "group")
    return trace.assign(estimate_slip=(groups, 1.0 - ratio), estimate_slip_sd=(groups, np.abs(deviation)))


def available_errors(trace: xarray.Dataset, constant: float, quantile: float) -> dict[str, float]:
    """Return the errors of the available adhesion in a recording with estimates of adhesion and slip, over all groups.

    `known` is the share of samples above 10 km/h in which the estimator knows it; NaN without estimates of adhesion and
    slip. All others are of these samples, NaN without any: `rmse` and `bias`; `coverage`, the share of samples within
    the claimed 95 % interval of adhesion, NaN without a claim; `recent`, the root mean square error of the largest
    estimated adhesion of the last `RECENT`; `constant`, that of the best constant.

    Args:
        trace: The recording.
        constant: Mean of the available adhesion in the training set.
        quantile: Half of the claimed interval, in standard deviations.
    """
    errors = dict.fromkeys(("known", "rmse", "bias", "coverage", "recent", "constant"), math.nan)
    if "estimate_slip" not in trace or "estimate_adhesion" not in trace:
        return errors
    moving = trace["speed"].values > SLOWEST
    adhesion, slip, truth = (trace[name].values[moving] for name in ("estimate_adhesion", "estimate_slip", TRUTH))
    deviation, slip_deviation = (
        trace[name].values[moving] if name in trace else np.full(slip.shape, math.nan)
        for name in ("estimate_adhesion_sd", "estimate_slip_sd")
    )
    if not np.isfinite(slip).any():
        return errors
    columns = zip(adhesion.T, slip.T, np.nan_to_num(slip_deviation).T, strict=True)
    found = np.stack([estimate_slope(a, s, PERIOD, slip_deviation=sd).available for a, s, sd in columns], axis=1)
    is_known = np.isfinite(found)
    errors["known"] = float(np.mean(is_known))
    if not is_known.any():
        return errors
    error, claimed = (found - truth)[is_known], deviation[is_known]
    recent = largest_of_last(adhesion, round(RECENT / PERIOD))
    return errors | {
        "rmse": rms(error),
        "bias": float(np.mean(error)),
        "coverage": coverage(error, claimed, quantile),
        "recent": rms((recent - truth)[is_known]),
        "constant": rms((constant - truth)[is_known]),
    }


def coverage(error: Array, deviation: Array, quantile: float) -> float:
    """Return the share of errors within `quantile` claimed deviations; NaN without errors or without a claim."""
    is_claimed = deviation.size > 0 and bool(np.isfinite(deviation).all())
    return float(np.mean(np.abs(error) <= quantile * deviation)) if is_claimed else math.nan


def largest_of_last(values: Matrix, count: int) -> Matrix:
    """Return the largest of the last `count` rows at each row, shape as `values`."""
    return maximum_filter1d(values, count, axis=0, mode="nearest", origin=(count - 1) // 2)
