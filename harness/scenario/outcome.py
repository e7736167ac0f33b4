"""Outcomes of a stop."""

from enum import StrEnum


class Outcome(StrEnum):
    """Outcome of a stop; only `standstill` has a braking distance."""

    STANDSTILL = "standstill"
    """The speed fell to the scenario's stop speed."""
    HORIZON = "horizon"
    """Still moving when the scenario's horizon was reached."""
    DIVERGED = "diverged"
    """The estimate became invalid: not finite, or a covariance that is not positive semidefinite."""
    PLANT_FAILED = "plant_failed"
    """The plant FMU refused a step or returned a value that is not a number."""
    IMPLAUSIBLE = "implausible"
    """The plant returned impossible outputs: in contradiction to its inputs or to physics."""
    SENSORS_FAILED = "sensors_failed"
    """User-defined sensors failed to return a reading."""
    CONTROLLER_FAILED = "controller_failed"
    """The controller returned an invalid command."""
