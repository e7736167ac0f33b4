"""Disturbance observer of each wheelset: a reference."""

from railgrip.estimators.design import FilterContext, FilterKind
from railgrip.estimators.references import DisturbanceEstimator


class DisturbanceObserver(FilterKind):
    """Adhesion as the disturbance of an observer of the wheelset speed, over an FMU."""

    prediction = "fmu"

    @classmethod
    def start(cls, task: FilterContext) -> DisturbanceEstimator:
        """Return the estimator with its first belief."""
        return DisturbanceEstimator.of_context(task)
