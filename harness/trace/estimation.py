"""Figures of the estimator: how wrong, how sure, how late."""

import numpy as np
import xarray

from railgrip.base.arrays import Array
from railgrip.estimators.consistency import loss_step, nis_ratio
from railgrip.vehicle.signals import READINGS

SLOWEST = 10 / 3.6  # m/s; below, slip is the ratio of two small numbers and no one asks for the adhesion
_LONGEST_DELAY = 0.5  # s
_DELAY_STEP = 0.005  # s


_OF_ADHESION = (
    "adhesion_rmse", "adhesion_bias", "adhesion_error_95", "adhesion_sd", "adhesion_nees", "adhesion_delay",
    "adhesion_outside",
)  # fmt: skip
"""Fields of `Metrics` that `adhesion_errors` gives."""


def adhesion_errors(trace: xarray.Dataset) -> dict[str, tuple[float, ...] | None]:
    """Return the errors of the estimated adhesion of each group by their names in `Metrics`.

    They are estimate minus truth above 10 km/h; all are None of a stop without estimates, or that was never as fast.
    Without a standard deviation there is no NEES, the mean of (error/deviation)², which is 1 for a consistent
    estimator, and no share outside ±2σ, which is 0.046 then. Delays are 0 to 0.5 s in steps of 5 ms.
    """
    truth, estimate = _moving(trace, "group_adhesion"), _moving(trace, "estimate_adhesion")
    if truth is None or estimate is None or len(truth) < 2:
        return dict.fromkeys(_OF_ADHESION)
    error, deviation = estimate - truth, _moving(trace, "estimate_adhesion_sd")
    period = float(trace["time"].values[1] - trace["time"].values[0])
    errors = (
        _row(np.sqrt(np.mean(error**2, axis=0))),
        _row(np.mean(error, axis=0)),
        _row(np.quantile(np.abs(error), 0.95, axis=0)),
        None if deviation is None else _row(np.mean(deviation, axis=0)),
        None if deviation is None else _row(np.mean((error / deviation) ** 2, axis=0)),
        _row(_delay(truth, estimate, period)),
        None if deviation is None else _row(_outside(error, deviation)),
    )
    return dict(zip(_OF_ADHESION, errors, strict=True))


def _moving(trace: xarray.Dataset, name: str) -> Array | None:
    """Return a signal above 10 km/h, or None: some estimators provide no standard deviation."""
    return trace[name].values[trace["speed"].values > SLOWEST] if name in trace else None


def _delay(truth: Array, estimate: Array, period: float) -> Array:
    """Return the shift that minimises the mean square of estimate(t + shift) − truth(t), shape (groups,) [s].

    All shifts are judged on the same samples of the truth, so that a hard passage cannot drop out with a
    shift.
    """
    step = max(1, round(_DELAY_STEP / period))
    longest = min(round(_LONGEST_DELAY / period), len(truth) // 2)
    shifts = np.arange(0, longest + 1, step)
    count = len(truth) - longest
    rows, fixed = np.ascontiguousarray(estimate.T), np.ascontiguousarray(truth[:count].T)
    errors = (rows[:, s : s + count] - fixed for s in shifts)
    squares = np.stack([np.einsum("ij,ij->i", error, error) for error in errors])
    return np.asarray(shifts[np.argmin(squares, axis=0)] * period, dtype=np.float64)


def rmse(trace: xarray.Dataset, estimated: str, true: str) -> tuple[float, ...] | None:
    """Return the root mean square error of another estimate above 10 km/h, or None without it."""
    error = _error(trace, estimated, true)
    return None if error is None else _row(np.atleast_1d(np.sqrt(np.mean(error**2, axis=0))))


def outside(trace: xarray.Dataset, estimated: str, true: str) -> tuple[float, ...] | None:
    """Return the share of time above 10 km/h with the truth outside ±2σ of an estimate, or None without it."""
    error, deviation = _error(trace, estimated, true), _moving(trace, f"{estimated}_sd")
    return None if error is None or deviation is None else _row(_outside(error, deviation))


def _error(trace: xarray.Dataset, estimated: str, true: str) -> Array | None:
    estimate = _moving(trace, estimated)
    truth = _moving(trace, true)
    return None if estimate is None or truth is None or not len(estimate) else estimate - truth


def _outside(error: Array, deviation: Array) -> Array:
    """Return the share of samples beyond two deviations, shape (groups,); NaN without a truth."""
    return np.where(np.isnan(error).any(axis=0), np.nan, np.mean(np.abs(error) > 2.0 * deviation, axis=0))


def innovations(trace: xarray.Dataset) -> tuple[float | None, float | None]:
    """Return the ratio of the median NIS to its expected value, and the time of divergence [s]; None if absent.

    See `railgrip.estimators.consistency`. Between two steps of the estimator rows repeat the last one.
    """
    if "estimate_nis" not in trace:
        return None, None
    nis, readings = trace["estimate_nis"].values, trace["estimate_readings"].values
    divergence = loss_step(nis, readings)
    return nis_ratio(nis, readings), None if divergence is None else float(trace["time"].values[divergence])


READING_ERRORS = tuple(f"{signal.name.removeprefix('reading_')}_error" for signal in READINGS)
"""Fields of `Metrics` that `reading_errors` gives."""


def reading_errors(trace: xarray.Dataset) -> dict[str, float]:
    """Return the RMS error of each reading over the RMS of the true value, by the names in `Metrics`.

    Errors are means over the channels of a reading; missing readings are left out. NaN if the trace lacks the reading
    or the true value, or the true value is always 0 and the reading is not.
    """
    names = (signal.name for signal in READINGS)
    errors = (_relative_error(trace, name, name.removeprefix("reading_")) for name in names)
    return dict(zip(READING_ERRORS, errors, strict=True))


def _relative_error(trace: xarray.Dataset, reading: str, true: str) -> float:
    if reading not in trace or true not in trace:
        return float("nan")
    truth = trace[true].values
    error = trace[reading].values - truth
    if np.isnan(error).all():
        return float("nan")
    error_rms, scale = np.sqrt(np.nanmean(error**2)), np.sqrt(np.mean(truth**2))
    return float(error_rms / scale) if scale > 0 else 0.0 if error_rms == 0 else float("nan")


def _row(values: Array) -> tuple[float, ...]:
    return tuple(map(float, values))
