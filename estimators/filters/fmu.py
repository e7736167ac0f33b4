"""The filter in C with a prediction FMU, which it evaluates through FMI 2.0."""

from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.design import FilterKind


class Fmu(CompiledFilter, FilterKind):
    """An extended Kalman filter in C with an FMU as its model."""
