"""The filter in numpy: the reference."""

from railgrip.estimators.ekf import ExtendedKalmanFilter, NumpyFilter
from railgrip.estimators.kind import FilterContext, FilterKind


class Python(FilterKind):
    """An extended Kalman filter in numpy."""

    @classmethod
    def start(cls, task: FilterContext) -> NumpyFilter:
        """Return the filter with its first estimate."""
        filter_ = ExtendedKalmanFilter(
            task.prediction, task.process_noise, task.reading_noise, task.period, task.gate, task.outlier_limit
        )
        return NumpyFilter(filter_, filter_.start(task.mean, task.covariance))
