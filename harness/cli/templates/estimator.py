"""An estimator of adhesion; `python NAME.py` checks it and compares its estimates with the truth of a stop.

railgrip run trapezoid --import-from . --set estimator.kind=NAME:ESTIMATOR --set controller.kind=slip_two_state
"""

import numpy as np

import railgrip as rg


class ESTIMATOR:
    """Estimate the adhesion of each group by the smoothed deceleration of the train."""

    provides: tuple[str, ...] = ("adhesion",)  # fields of rg.Estimate that each step gives

    def __init__(self, smoothing: float = 0.05) -> None:
        """Take the arguments that a scenario may give in [estimator] parameters: here a time constant [s]."""
        self.smoothing = smoothing

    def start(self, first: rg.Observation, formation: rg.Formation) -> None:
        """Start a stop with the first observation; called again for each further stop."""
        self.groups = formation.groups
        self.adhesion, self.time = 0.0, first.time

    def step(self, observation: rg.Observation) -> rg.Estimate:
        """Return the estimates for an observation; called once in each estimator period."""
        passed, self.time = observation.time - self.time, observation.time
        share = passed / (passed + self.smoothing)
        self.adhesion += share * (-observation.acceleration / 9.81 - self.adhesion)
        return rg.Estimate(adhesion=np.full(self.groups, self.adhesion))


if __name__ == "__main__":
    rg.testing.check_estimator(ESTIMATOR)
    stop = rg.run("trapezoid", estimator=ESTIMATOR, controller="slip_two_state")
    error = stop.trace["estimate_adhesion"] - stop.trace["group_adhesion"]
    print("root mean square error of each group:", ((error**2).mean("time") ** 0.5).values.round(3))
