"""The filter in numpy: the reference."""

from railgrip.estimators.design import FilterKind
from railgrip.estimators.ekf import ExtendedKalmanFilter


class Python(ExtendedKalmanFilter, FilterKind):
    """An extended Kalman filter in numpy."""

    form = "equations"
