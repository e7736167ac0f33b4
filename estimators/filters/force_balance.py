"""Force balance of each wheelset with a low-pass: a reference."""

from railgrip.estimators.design import FilterKind
from railgrip.estimators.references import ForceBalanceEstimator


class ForceBalance(FilterKind):
    """Adhesion from the differentiated wheelset speed, over an FMU."""

    prediction = "fmu"
    filter = ForceBalanceEstimator
