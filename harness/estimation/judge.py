"""How good an estimate is, where the truth is known."""

from dataclasses import dataclass

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.errors import EstimationError
from railgrip.estimators.belief import Vector
from railgrip.trace.samples import truth_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """Errors of one state, estimate minus truth, in its unit.

    Attributes:
        samples: How many were judged.
        rmse: Root of the mean square.
        constant: The same of the best constant, the mean of the truth: what a filter must be better than.
        bias: Mean.
        largest: Largest magnitude.
        nees: Mean of (error/sd)²: 1 for a filter that knows its error, above it believes too much.
        coverage: Share of samples within two standard deviations: 0.954 for a filter that knows its error.
        sd: Median of the standard deviation that the filter claims.
    """

    samples: int
    rmse: float
    constant: float
    bias: float
    largest: float
    nees: float
    coverage: float
    sd: float


def errors(recording: xarray.Dataset, estimates: xarray.Dataset, state: str) -> Vector:
    """Return estimate minus truth at every sample, shape (k,).

    Raises:
        EstimationError: The recording does not know the truth.
    """
    return estimates["mean"].sel(state=state).values - truth_of(recording, state)


def judge(
    recording: xarray.Dataset, estimates: xarray.Dataset, state: str, where: NDArray[np.bool_] | None = None
) -> Judgement:
    """Return how far an estimate was from the truth and from its own claim.

    Args:
        estimates: Of `estimate`, from that recording.
        where: Samples to judge; all after the first when None.

    Raises:
        EstimationError: The truth is not known, or nothing is left to judge.
    """
    error = errors(recording, estimates, state)
    sd = estimates["sd"].sel(state=state).values
    mask = (np.arange(error.size) > 0) if where is None else where
    mask = mask & np.isfinite(error)
    if not mask.any():
        raise EstimationError(f"judge: no sample of {state} is left to judge.")
    e, s = error[mask], sd[mask]
    return Judgement(
        samples=int(mask.sum()),
        rmse=float(np.sqrt(np.mean(e**2))),
        constant=float(np.std(truth_of(recording, state)[mask])),
        bias=float(np.mean(e)),
        largest=float(np.max(np.abs(e))),
        nees=float(np.mean((e / s) ** 2)),
        coverage=float(np.mean(np.abs(e) <= 2.0 * s)),
        sd=float(np.median(s)),
    )
