"""The filter in C with a prediction FMU, which it evaluates through FMI 2.0."""

from railgrip.estimators.filters.compiled import Compiled as _Compiled


class Fmu(_Compiled):
    """An extended Kalman filter in C with an FMU as its model."""

    prediction = "fmu"
