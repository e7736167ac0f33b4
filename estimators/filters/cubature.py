"""The cubature Kalman filter in numpy."""

from railgrip.estimators.design import FilterContext, FilterKind
from railgrip.estimators.ekf import NumpyFilter
from railgrip.estimators.sigma_points import CubatureKalmanFilter


class Cubature(FilterKind):
    """A sigma-point filter with cubature points, over an FMU."""

    prediction = "fmu"

    @classmethod
    def start(cls, task: FilterContext) -> NumpyFilter:
        """Return the filter with its first estimate."""
        return CubatureKalmanFilter.of_context(task)
