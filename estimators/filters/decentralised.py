"""The decentralised filter: one part for each bogie or group, at a cost linear in their number."""

from railgrip.estimators.decentralised import DecentralisedFilter
from railgrip.estimators.kind import FilterContext, FilterKind


class Decentralised(FilterKind):
    """Coupled filters of the parts of a train, without outlier rejection."""

    prediction = "parts"

    @classmethod
    def start(cls, task: FilterContext) -> DecentralisedFilter:
        """Return the filter with its first estimate."""
        filter_ = DecentralisedFilter(task.prediction, task.process_noise, task.reading_noise, task.period, task.gate)
        filter_.start(task.mean, task.covariance)
        return filter_
