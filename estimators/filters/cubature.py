"""The cubature Kalman filter in numpy."""

from railgrip.estimators.design import FilterKind
from railgrip.estimators.filters.unscented import SigmaPointFilter


class CubatureKalmanFilter(SigmaPointFilter, FilterKind):
    """Sigma-point filter with the points of the cubature rule."""

    alpha, beta = 1.0, 0.0
