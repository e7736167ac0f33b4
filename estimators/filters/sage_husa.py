"""The adaptive filter of Sage and Husa in numpy."""

from railgrip.estimators.ekf import NumpyFilter
from railgrip.estimators.kind import FilterContext, FilterKind
from railgrip.estimators.sage_husa import SageHusaFilter


class SageHusa(FilterKind):
    """An extended Kalman filter that adapts its reading noise, over an FMU."""

    prediction = "fmu"

    @classmethod
    def start(cls, task: FilterContext) -> NumpyFilter:
        """Return the filter with its first estimate."""
        return SageHusaFilter.of_context(task)
