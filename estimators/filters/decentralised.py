"""A part for each bogie or group, at a cost linear in them."""

from railgrip.estimators.decentralised import DecentralisedFilter
from railgrip.estimators.kind import FilterContext, FilterKind


class Decentralised(FilterKind):
    """Coupled filters of the parts of a train; they use every reading."""

    prediction = "parts"

    @classmethod
    def start(cls, task: FilterContext) -> DecentralisedFilter:
        """Return the filter with its first belief."""
        filter_ = DecentralisedFilter(task.prediction, task.process_noise, task.reading_noise, task.period, task.gate)
        filter_.start(task.mean, task.covariance)
        return filter_
