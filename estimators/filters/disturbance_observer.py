"""Disturbance observer of each wheelset: a reference."""

from railgrip.estimators.design import FilterKind
from railgrip.estimators.references import DisturbanceEstimator


class DisturbanceObserver(FilterKind):
    """Adhesion as the disturbance of an observer of the wheelset speed, over an FMU."""

    prediction = "fmu"
    filter = DisturbanceEstimator
