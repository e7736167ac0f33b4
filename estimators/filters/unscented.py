"""The unscented Kalman filter in numpy."""

from railgrip.estimators.design import FilterContext, FilterKind
from railgrip.estimators.ekf import NumpyFilter
from railgrip.estimators.sigma_points import UnscentedKalmanFilter


class Unscented(FilterKind):
    """A sigma-point filter with unscented points, over an FMU."""

    prediction = "fmu"

    @classmethod
    def start(cls, task: FilterContext) -> NumpyFilter:
        """Return the filter with its first estimate."""
        return UnscentedKalmanFilter.of_context(task)
