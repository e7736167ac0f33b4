"""The unscented Kalman filter in numpy."""

from railgrip.estimators.design import FilterKind
from railgrip.estimators.sigma_points import UnscentedKalmanFilter


class Unscented(FilterKind):
    """A sigma-point filter with unscented points, over an FMU."""

    prediction = "fmu"
    filter = UnscentedKalmanFilter
