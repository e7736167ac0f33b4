"""Errors of an estimate with respect to the known truth."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.base.errors import EstimationError
from railgrip.base.names import state_name
from railgrip.estimators.belief import Array, Vector
from railgrip.recording.samples import truth_of

NORMAL_95: Final = 1.96
"""Half of a 95 % interval of a normal distribution, in standard deviations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """Errors of one state, estimate minus truth, in its unit.

    Attributes:
        samples: Number of samples judged.
        rmse: Root-mean-square error.
        constant: RMSE of the best constant, the mean of the truth; a useful filter is better.
        bias: Mean error.
        largest: Maximum magnitude of the error.
        nees: Mean of (error/sd)²: 1 for a consistent filter, more for an overconfident one.
        coverage: Share of samples within two standard deviations: 0.954 for a consistent filter.
        sd: Median of the filter's standard deviation.
    """

    samples: int
    rmse: float
    constant: float
    bias: float
    largest: float
    nees: float
    coverage: float
    sd: float


def rms(values: Array) -> float:
    """Return the root mean square of values of any shape."""
    return float(np.sqrt(np.mean(values**2)))


def _of_state(estimates: xarray.Dataset, what: str, state: str) -> Vector:
    """Return a result of a state by its name or its symbol; older estimates have the symbols."""
    known = set(estimates["state"].values.tolist())
    return estimates[what].sel(state=state if state in known else state_name(state)).values


def errors(recording: xarray.Dataset, estimates: xarray.Dataset, state: str) -> Vector:
    """Return estimate minus truth at every sample, shape (k,).

    Raises:
        EstimationError: The recording lacks the true state.
    """
    return _of_state(estimates, "mean", state) - truth_of(recording, state)


def judge(
    recording: xarray.Dataset, estimates: xarray.Dataset, state: str, where: NDArray[np.bool_] | None = None
) -> Judgement:
    """Return the errors of an estimate with respect to the truth and to the filter's standard deviation.

    Args:
        estimates: Result of `estimate` for that recording.
        where: Mask of the samples to judge; None for all after the first.

    Raises:
        EstimationError: The recording lacks the true state, or no sample is left to judge.
    """
    error = errors(recording, estimates, state)
    sd = _of_state(estimates, "sd", state)
    mask = (np.arange(error.size) > 0) if where is None else where
    mask = mask & np.isfinite(error)
    if not mask.any():
        raise EstimationError(f"judge: no sample of {state} is left to judge.")
    e, s = error[mask], sd[mask]
    return Judgement(
        samples=int(mask.sum()),
        rmse=rms(e),
        constant=float(np.std(truth_of(recording, state)[mask])),
        bias=float(np.mean(e)),
        largest=float(np.max(np.abs(e))),
        nees=float(np.mean((e / s) ** 2)),
        coverage=float(np.mean(np.abs(e) <= 2.0 * s)),
        sd=float(np.median(s)),
    )
