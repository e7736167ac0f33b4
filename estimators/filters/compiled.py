"""The filter in C, compiled together with the equations of its prediction: the fastest form."""

from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.design import FilterKind


class Compiled(CompiledFilter, FilterKind):
    """An extended Kalman filter in C."""

    form = "equations"
