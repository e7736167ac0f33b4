"""A minimal wheelset: a torque balance on an adhesion curve in closed form."""

import numpy as np
from synthetic import GROUP

from railgrip.controllers.observation import Observation

SPEED = 15.0  # m/s, constant: the train is heavy


def observed(time, speed, acceleration, slip, adhesion, pad_friction, pressure):
    """An observation of a train whose wheel speeds correspond to the slips."""
    wheels = (1 - np.array(slip)) * speed / 0.38
    full = np.full(len(slip), 3.4e5)
    return Observation(time, speed, acceleration, wheels, np.array(slip), False, adhesion, pad_friction, pressure, full)


def simulate(
    controller, seconds, *, peak_slip=0.03, peak=lambda time, group: 0.06, pad_friction=0.35, lag=0.02, groups=1
):
    """Return slip and adhesion over time of braked wheelsets at constant speed, with a column for each of several.

    α = 2 α* s* s/(s*² + s²), with its only maximum α* at s*; ω̇ from the torque balance; pressure follows the demand
    with a first-order lag. Explicit steps of 0.1 ms: the contact's time constant at the origin is some 3 ms.
    """
    # Python floats: NumPy is ten times slower on a few numbers.
    each, omega, pressure = range(groups), [SPEED / 0.38] * groups, [0.0] * groups
    slips, adhesions = [], []
    for k in range(round(seconds / 1e-3)):
        most = [peak(k * 1e-3, g) for g in each]

        def adhesion_at(slip, g, most=most):
            return 2 * most[g] * peak_slip * slip / (peak_slip**2 + slip**2)

        slip = [1 - 0.38 * omega[g] / SPEED for g in each]
        adhesion = [adhesion_at(slip[g], g) for g in each]
        observation = observed(k * 1e-3, SPEED, 0.0, slip, tuple(adhesion), (pad_friction,) * groups, tuple(pressure))
        for g, demand in enumerate(controller.decide(observation)):
            for _ in range(10):
                force = adhesion_at(1 - 0.38 * omega[g] / SPEED, g) * GROUP.load
                pressure[g] += (demand - pressure[g]) * 1e-4 / lag
                torque = 2 * pad_friction * 5.7 * max(pressure[g] * 0.0324 - 1200, 0.0) * 0.22
                omega[g] = max(omega[g] + 1e-4 * (force * 0.38 - torque) / 209.0, 0.0)
        slips.append(slip)
        adhesions.append(adhesion)
    return np.squeeze(slips), np.squeeze(adhesions)


class Altered:
    """A law that gets its observations as another function returns them."""

    def __init__(self, law, alter):
        self.law, self.alter = law, alter

    def decide(self, observation):
        return self.law.decide(self.alter(observation))


def set_state(law, name, value):
    law.state[[quantity.name for quantity in law.formula.states].index(name)] = value


def state_of(law, name):
    """Return a state of a law by its name."""
    return law.state[[quantity.name for quantity in law.formula.states].index(name)]
