"""The filter in C, compiled together with the equations of its prediction: the fastest form."""

from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.design import FilterContext, FilterKind


class Compiled(FilterKind):
    """An extended Kalman filter in C."""

    @classmethod
    def start(cls, task: FilterContext) -> CompiledFilter:
        """Return the filter with its first estimate."""
        filter_ = CompiledFilter(
            task.prediction, task.process_noise, task.reading_noise, task.period, task.gate, task.outlier_limit
        )
        filter_.start(task.mean, task.covariance)
        return filter_
