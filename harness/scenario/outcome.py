"""How a stop ended."""

from enum import StrEnum


class Outcome(StrEnum):
    """The way a stop ends; only `standstill` has a braking distance."""

    STANDSTILL = "standstill"
    """The speed fell to the scenario's stop speed."""
    HORIZON = "horizon"
    """Still moving when the scenario's horizon was reached."""
    DIVERGED = "diverged"
    """The estimator's belief became meaningless (not finite, or a covariance that is none)."""
    PLANT_FAILED = "plant_failed"
    """The plant FMU refused a step or returned something that is no number."""
    IMPLAUSIBLE = "implausible"
    """The plant returned impossible outputs: other than its inputs require, or against physics."""
    SENSORS_FAILED = "sensors_failed"
    """Sensors of the user's own gave no reading."""
    CONTROLLER_FAILED = "controller_failed"
    """The controller returned a command that is none."""
