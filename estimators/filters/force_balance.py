"""Force balance of each wheelset with a low-pass: a reference."""

from railgrip.estimators.design import FilterContext, FilterKind
from railgrip.estimators.references import ForceBalanceEstimator


class ForceBalance(FilterKind):
    """Adhesion from the differentiated wheelset speed, over an FMU."""

    prediction = "fmu"

    @classmethod
    def start(cls, task: FilterContext) -> ForceBalanceEstimator:
        """Return the estimator with its first belief."""
        return ForceBalanceEstimator.of_context(task)
