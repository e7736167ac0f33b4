"""A filter on values as one whose belief moves on in place."""

from typing import Protocol

import numpy as np

from estimators.belief import Estimate, Vector


class Filter(Protocol):
    """A filter on values, as `estimators.ekf.ExtendedKalmanFilter`."""

    def step(self, prior: Estimate, held: Vector, seen: Vector) -> Estimate:
        """Return the belief one period after `prior`."""
        ...


class Running:
    """Holds the belief of a filter and moves it on, as `estimators.compiled.CompiledFilter` does by itself.

    Attributes:
        mean: Shape (n,).
        covariance: Shape (n, n).
        held: Inputs of the next step, shape (nu,), zero at first.
        seen: Readings of the next step, shape (m,), NaN at first.
    """

    def __init__(self, filter_: Filter, first: Estimate, *, inputs: int, outputs: int) -> None:
        """Begin with the belief `first` of a filter with so many inputs and outputs."""
        self._filter = filter_
        self._belief = first
        self.mean, self.covariance = first.mean.copy(), first.covariance.copy()
        self.held, self.seen = np.zeros(inputs), np.full(outputs, np.nan)

    def advance(self) -> None:
        """Move the belief on by one period, from the arrays `held` and `seen`.

        Raises:
            FilterDiverged: As the filter's step; the belief stays what it was.
        """
        self._belief = belief = self._filter.step(self._belief, self.held, self.seen)
        self.mean[:] = belief.mean
        self.covariance[:] = belief.covariance
