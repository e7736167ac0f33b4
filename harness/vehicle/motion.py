"""Slip of a wheelset, and running resistance of a train."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railgrip.base.units import GRAVITY

SMALL_SPEED: Final = 0.05
"""Train speed [m/s] below which slip counts as 0, because it would be a ratio of noises."""


def slip_of(speed: ArrayLike, rim_speed: ArrayLike) -> NDArray[np.float64]:
    """Return the slip 1 − rω/v; 0 if the train is slower than `SMALL_SPEED`, NaN if its speed is unknown.

    The loop in C has the same function in `slip_of` of harness/kernel/onboard.c.

    Args:
        speed: v of the train [m/s].
        rim_speed: rω of each wheelset [m/s]; its shape is that of the result.
    """
    rim_speed = np.asarray(rim_speed, dtype=np.float64)
    # Not `>=`, with which an unknown speed (NaN) would have a slip of 0.
    is_moving = np.logical_not(np.asarray(speed) < SMALL_SPEED)
    return 1.0 - np.divide(rim_speed, speed, out=np.ones_like(rim_speed), where=is_moving)


Values = Any
"""A number or an array."""


def rolling_resistance(parameters: Mapping[str, float], mass: Values, wheel_radius: float) -> Values:
    """Return the force of bearings and rolling on a train [N].

    It approximates `RailBraking.Components.bearingFriction` for small friction, with a relative error of 1e-6.

    Args:
        parameters: Parameters, including mu_bearing, r_bearing and e_rolling.
        mass: Mass of the train [kg].
        wheel_radius: Mean wheel radius [m].
    """
    bearing = parameters["mu_bearing"] * parameters["r_bearing"] / wheel_radius
    return mass * GRAVITY * (bearing + parameters["e_rolling"] / wheel_radius)


def resistance_lever(parameters: Mapping[str, float]) -> float:
    """Return the torque of bearings and rolling on a wheelset over its load [m]; 0 without parameters for it."""
    bearing = parameters.get("mu_bearing", 0.0) * parameters.get("r_bearing", 0.0)
    return bearing + parameters.get("e_rolling", 0.0)


def air_resistance(parameters: Mapping[str, float]) -> float:
    """Return the aerodynamic drag of a train over its squared speed [N s2/m2]; 0 without parameters for it."""
    return 0.5 * parameters.get("rho_air", 0.0) * parameters.get("c_drag", 0.0) * parameters.get("A_drag", 0.0)
