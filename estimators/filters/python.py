"""The filter in numpy: the reference."""

from railgrip.estimators.ekf import ExtendedKalmanFilter, Running
from railgrip.estimators.kind import FilterContext, FilterKind


class Python(FilterKind):
    """An extended Kalman filter in numpy."""

    @classmethod
    def start(cls, task: FilterContext) -> Running:
        """Return the filter with its first estimate."""
        filter_ = ExtendedKalmanFilter(
            task.prediction, task.process_noise, task.reading_noise, task.period, task.gate, task.outlier_limit
        )
        return Running(filter_, filter_.start(task.mean, task.covariance))
