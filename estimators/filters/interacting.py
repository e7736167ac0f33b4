"""Interacting multiple models in numpy."""

from railgrip.estimators.interacting import InteractingFilters
from railgrip.estimators.kind import FilterContext, FilterKind


class Interacting(FilterKind):
    """Extended Kalman filters that differ by the process noise of adhesion, over an FMU."""

    prediction = "fmu"

    @classmethod
    def start(cls, task: FilterContext) -> InteractingFilters:
        """Return the filter with its first estimate."""
        return InteractingFilters.of_context(task)
