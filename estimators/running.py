"""A filter on values as one whose belief moves on in place."""

import numpy as np

from railgrip.estimators.belief import Estimate
from railgrip.estimators.ekf import ExtendedKalmanFilter


class Running:
    """Holds the belief of a filter and moves it on, as `railgrip.estimators.compiled.CompiledFilter` does by itself.

    Attributes:
        mean: Shape (n,).
        covariance: Shape (n, n).
        inputs: Inputs of the next step, shape (nu,), zero at first.
        readings: Readings of the next step, shape (m,), NaN at first.
        selection: 1 for every reading that the last step used, shape (m,), 0 at first.
        squared_innovation: Normalised innovation squared of the last step, 0 at first.
    """

    def __init__(self, filter_: ExtendedKalmanFilter, first: Estimate, *, inputs: int, outputs: int) -> None:
        """Begin with the belief `first` of a filter with so many inputs and outputs."""
        self._filter = filter_
        self._belief = first
        self.mean, self.covariance = first.mean.copy(), first.covariance.copy()
        self.inputs, self.readings, self.selection = np.zeros(inputs), np.full(outputs, np.nan), np.zeros(outputs)
        self.squared_innovation = 0.0

    def advance(self) -> None:
        """Move the belief on by one period, from the arrays `inputs` and `readings`.

        Raises:
            FilterDiverged: As the filter's steps; the belief stays what it was.
        """
        forecast = self._filter.predict(self._belief, self.inputs)
        innovation = self._filter.innovation(forecast, self.inputs, self.readings)
        self._belief = belief = self._filter.condition(forecast, self.inputs, innovation)
        self.selection[:] = 0.0
        self.selection[innovation.rows] = 1.0
        self.squared_innovation = innovation.nis
        self.mean[:] = belief.mean
        self.covariance[:] = belief.covariance
