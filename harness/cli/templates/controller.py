"""A wheel-slide controller; `python NAME.py` checks it and compares its braking distance with others.

railgrip run trapezoid --import-from . --set controller.kind=NAME:CONTROLLER --set controller.parameters.threshold=0.02
"""

import numpy as np
from numpy.typing import NDArray

import railgrip as rg


class CONTROLLER:
    """Vent a group whose slip is above a threshold; a group is the wheelsets that turn together and share a brake."""

    def __init__(self, threshold: float = 0.05) -> None:
        """Take the arguments that a scenario may give in [controller] parameters."""
        self.threshold = threshold

    def start(self, formation: rg.Formation) -> None:
        """Start a stop; called again for each further stop."""
        self.pressure_max = formation.pressure_max  # of each group, the leading one first [Pa]

    def decide(self, observation: rg.Observation) -> NDArray[np.float64]:
        """Return the demanded brake cylinder pressure of each group [Pa]; called once in each controller period."""
        # Slip is NaN until a sensor has read the speed. There are also time, speed, acceleration, wheelset_speed,
        # pressure, driver_demand and, with an estimator, adhesion and pad_friction.
        return np.where(observation.slip > self.threshold, 0.0, self.pressure_max)


if __name__ == "__main__":
    rg.testing.check_controller(CONTROLLER)
    for controller in (CONTROLLER, "slip_two_state", "adhesion_based"):
        stop = rg.run("trapezoid", controller=controller)
        name = controller if isinstance(controller, str) else controller.__name__
        print(f"{name}: {stop.outcome.value}, {stop.metrics.distance:.1f} m")
