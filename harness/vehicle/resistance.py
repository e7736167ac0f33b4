"""Mean running resistance of a train from the parameters of its plant: bearings, rolling and air."""

from collections.abc import Mapping
from typing import Any

from railgrip.base.units import GRAVITY

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
