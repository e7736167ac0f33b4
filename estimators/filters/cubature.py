"""The cubature Kalman filter in numpy."""

from railgrip.estimators.design import FilterKind
from railgrip.estimators.filters.unscented import CubatureKalmanFilter


class Cubature(FilterKind):
    """A sigma-point filter with cubature points, over an FMU."""

    prediction = "fmu"
    filter = CubatureKalmanFilter
