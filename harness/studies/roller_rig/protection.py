"""Errors of an estimate in and out of the hands of a wheel-slide protection."""

from dataclasses import dataclass

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.estimation.judge import errors
from railgrip.trace.samples import period_of, reading_of

Mask = NDArray[np.bool_]

LIMIT = 0.02
"""Error of adhesion that Schwarz and Keck (2020), §4, keep outside protection events."""

RECOVERY = 0.1
"""Time in which they correct a larger one [s]; a protection answers in 0.2 s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Excursions:
    """Where the error of adhesion is larger than `LIMIT`.

    Attributes:
        largest_outside: Largest error outside protection events [1].
        largest: Largest error anywhere after the start has settled [1].
        outside: Samples outside events that are over the limit.
        count: Stretches over the limit, anywhere.
        longest: The longest of them [s].
    """

    largest_outside: float
    largest: float
    outside: int
    count: int
    longest: float

    @property
    def kept(self) -> bool:
        """Whether the paper's statement holds: within the limit outside events, corrected in time in them."""
        return self.outside == 0 and self.longest <= RECOVERY


def outside_events(recording: xarray.Dataset, settled: float) -> Mask:
    """Return the samples outside protection events, shape (k,).

    An event lasts while the protection keeps the brake from giving what the driver asks for, and `RECOVERY` longer.
    The first `settled` seconds are left out: there the estimate comes from its start.
    """
    time = recording["time"].values
    busy = reading_of(recording, "protecting") > 0.5
    last = np.where(busy, time, -np.inf)
    since = time - np.maximum.accumulate(last)
    return (since > RECOVERY) & (time >= time[0] + settled)


def excursions(recording: xarray.Dataset, estimates: xarray.Dataset, settled: float) -> Excursions:
    """Return where an estimate of adhesion leaves the limit."""
    time = recording["time"].values
    after = time >= time[0] + settled
    error = np.abs(errors(recording, estimates, "alpha"))
    outside = outside_events(recording, settled)
    # A filter that ended early is off for good: what is not a number is over the limit.
    over = ~(error <= LIMIT) & after
    edges = np.flatnonzero(np.diff(np.concatenate([[0], over.astype(int), [0]])))
    lengths = (edges[1::2] - edges[::2]) * period_of(recording)
    return Excursions(
        largest_outside=float(np.max(error[outside], initial=0.0)),
        largest=float(np.max(error[after], initial=0.0)),
        outside=int(np.sum(over & outside)),
        count=lengths.size,
        longest=float(np.max(lengths, initial=0.0)),
    )
