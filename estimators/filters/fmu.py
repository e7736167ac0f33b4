"""The filter as C, with a prediction FMU that it evaluates through FMI 2.0."""

from railgrip.estimators.filters.compiled import Compiled as _Compiled


class Fmu(_Compiled):
    """An extended Kalman filter in C over an FMU."""

    prediction = "fmu"
