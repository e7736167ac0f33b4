"""Friction that pads ought to have: the law of RailBraking.Friction along what was measured."""

from functools import cache

import casadi as ca
import numpy as np

from railgrip.estimators.belief import Vector
from railgrip.fmus.native import lower

NOMINAL = 0.35
"""Friction at nominal conditions, `mu_nominal` of RailBraking.Friction.PadFriction."""

_START = ("pad.mu", "disc.T_bulk", "disc.T_surface")


def nominal_friction(
    pad_force: Vector, wheelset_speed: Vector, speed: Vector, period: float, friction_radius: float, temperature: float
) -> Vector:
    """Return the friction of healthy pads in the same stop, shape (k,).

    Args:
        pad_force: Of both pads of one unit [N], shape (k,).
        wheelset_speed: [rad/s].
        speed: Of the train [m/s], cools the disc.
        period: Between samples [s].
        friction_radius: [m].
        temperature: Of the disc at the first sample [K].
    """
    start, step = _stepper(friction_radius, period)
    first = np.array([start, temperature, temperature])
    inputs = np.stack([pad_force, np.maximum(wheelset_speed, 0.0), speed])
    run = step.mapaccum(pad_force.size - 1)
    states = np.asarray(run(first, inputs[:, :-1]), dtype=np.float64)
    return np.concatenate([[start], states[0]])


@cache
def _stepper(friction_radius: float, period: float) -> tuple[float, ca.Function]:
    """Return friction at the start and (state, inputs) → state one period later, by RK4."""
    model = lower("RailBraking.Components.GroupBrake")
    names = [v.name for v in model.states]
    assert tuple(names) == _START, names
    values = [friction_radius if v.name == "r_friction" else v.start for v in model.parameters]
    start = next(v.start for v in model.parameters if v.name == "pad.mu_start")
    x, u = ca.SX.sym("x", len(names)), ca.SX.sym("u", len(model.inputs))
    slope = ca.Function("slope", [x, u], [model.derivative(0.0, x, u, ca.DM(values))])
    k1 = slope(x, u)
    k2 = slope(x + 0.5 * period * k1, u)
    k3 = slope(x + 0.5 * period * k2, u)
    k4 = slope(x + period * k3, u)
    return float(start), ca.Function("step", [x, u], [x + period / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4)])
