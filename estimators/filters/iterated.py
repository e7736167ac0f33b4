"""The iterated extended Kalman filter in numpy."""

from railgrip.estimators.ekf import NumpyFilter
from railgrip.estimators.iterated import IteratedKalmanFilter
from railgrip.estimators.kind import FilterContext, FilterKind


class Iterated(FilterKind):
    """An extended Kalman filter that iterates its update, over an FMU."""

    prediction = "fmu"

    @classmethod
    def start(cls, task: FilterContext) -> NumpyFilter:
        """Return the filter with its first estimate."""
        return IteratedKalmanFilter.of_context(task)
