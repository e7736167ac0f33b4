"""The filter in numpy: the reference."""

from railgrip.estimators.design import FilterContext, FilterKind
from railgrip.estimators.ekf import ExtendedKalmanFilter, NumpyFilter


class Python(FilterKind):
    """An extended Kalman filter in numpy."""

    @classmethod
    def start(cls, task: FilterContext) -> NumpyFilter:
        """Return the filter with its first estimate."""
        return ExtendedKalmanFilter.of_context(task)
