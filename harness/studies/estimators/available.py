"""Errors of the adhesion available, where the slope of the creep curve determines it."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray
from scipy.ndimage import maximum_filter1d

from railgrip.estimation.judge import rms
from railgrip.estimators.belief import Matrix, Vector
from railgrip.estimators.slope import estimate_slope
from railgrip.studies.estimators.recordings import PERIOD
from railgrip.trace.estimation import SLOWEST

TRUTH: Final = "peak_adhesion"
"""Variable of the recordings: maximum of the creep curve of a group at its place and instant."""

RECENT: Final = 1.0
"""Time over which the reference takes the largest adhesion [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AvailableErrors:
    """Errors of the available adhesion of an estimator in one recording above 10 km/h, over all groups.

    All but `known` are of the samples in which the estimator knows it, NaN without any.

    Attributes:
        known: Share of samples in which it is known; NaN without estimates of adhesion and slip.
        rmse: Root mean square error.
        bias: Mean error.
        coverage: Share of samples within the claimed 95 % interval of adhesion; NaN without a claim.
        recent: Root mean square error of the largest estimated adhesion of the last `RECENT`.
        constant: Root mean square error of the best constant.
    """

    known: float
    rmse: float = math.nan
    bias: float = math.nan
    coverage: float = math.nan
    recent: float = math.nan
    constant: float = math.nan


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


def available_errors(trace: xarray.Dataset, constant: float, quantile: float) -> AvailableErrors:
    """Return the errors of a recording with estimates of adhesion and slip.

    Args:
        trace: The recording.
        constant: Mean of the available adhesion in the training set.
        quantile: Half of the claimed interval, in standard deviations.
    """
    if "estimate_slip" not in trace or "estimate_adhesion" not in trace:
        return AvailableErrors(known=math.nan)
    moving = trace["speed"].values > SLOWEST
    adhesion, slip, truth = (trace[name].values[moving] for name in ("estimate_adhesion", "estimate_slip", TRUTH))
    deviation, slip_deviation = (
        trace[name].values[moving] if name in trace else np.full(slip.shape, math.nan)
        for name in ("estimate_adhesion_sd", "estimate_slip_sd")
    )
    if not np.isfinite(slip).any():
        return AvailableErrors(known=math.nan)
    columns = zip(adhesion.T, slip.T, np.nan_to_num(slip_deviation).T, strict=True)
    found = np.stack([estimate_slope(a, s, PERIOD, slip_deviation=sd).available for a, s, sd in columns], axis=1)
    is_known = np.isfinite(found)
    if not is_known.any():
        return AvailableErrors(known=0.0)
    error, claimed = (found - truth)[is_known], deviation[is_known]
    recent = largest_of_last(adhesion, round(RECENT / PERIOD))
    is_claimed = bool(np.isfinite(claimed).all())
    return AvailableErrors(
        known=float(np.mean(is_known)),
        rmse=rms(error),
        bias=float(np.mean(error)),
        coverage=float(np.mean(np.abs(error) <= quantile * claimed)) if is_claimed else math.nan,
        recent=rms((recent - truth)[is_known]),
        constant=rms((constant - truth)[is_known]),
    )


def largest_of_last(values: Matrix, count: int) -> Matrix:
    """Return the largest of the last `count` rows at each row, shape as `values`."""
    return maximum_filter1d(values, count, axis=0, mode="nearest", origin=(count - 1) // 2)
