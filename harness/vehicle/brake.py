"""The friction brake of a group, slip of a wheelset, and running resistance of a train.

Source of the relation of cylinder pressure and pad force: Schwarz, Lüdicke, Heckmann (2019), eq. (3).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, Final, get_type_hints

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railgrip.base.units import GRAVITY

Values = Any
"""A number, an array, or a `casadi.SX`."""


def piston_force(pressure: Values, *, piston_area: Values, spring_force: Values) -> Values:
    """Return the force of a piston on its rigging [N]; 0 if the pressure does not overcome the spring.

    Args:
        pressure: Cylinder pressure [Pa].
        piston_area: Area of the piston [m2].
        spring_force: Force of slack adjuster and return spring at the piston [N].
    """
    force = pressure * piston_area - spring_force
    # Symbols of CasADi require its own maximum; the import of CasADi takes a third of a second.
    return force.fmax(0.0) if hasattr(force, "fmax") else np.maximum(force, 0.0)


def pad_force(pressure: Values, *, piston_area: Values, spring_force: Values, rigging: Values) -> Values:
    """Return the normal force of both pads of a brake unit [N].

    Args:
        pressure: Cylinder pressure [Pa].
        piston_area: Area of the piston [m2].
        spring_force: Force of slack adjuster and return spring at the piston [N].
        rigging: Force of both pads over force of the piston, including the efficiency.
    """
    return rigging * piston_force(pressure, piston_area=piston_area, spring_force=spring_force)


def pressure_of(force: Values, *, piston_area: Values, spring_force: Values, rigging: Values) -> Values:
    """Return the cylinder pressure [Pa] at which both pads press with a force [N]; the inverse of `pad_force`."""
    return (force / rigging + spring_force) / piston_area


LOWEST_PAD_FRICTION = 0.05
"""Friction that pads and blocks keep on wet or hot discs and wheels; a law that goes below it does not hold."""


def lowest_friction(
    friction: float,
    *,
    effects: Mapping[str, float],
    speed: float,
    force: float,
    shape: Callable[[float, float], float] = lambda speed, force: 1.0,
) -> tuple[float, float, float]:
    """Return the lowest friction of pads in a stop: friction, sliding speed [m/s], force of both pads [N].

    Each effect of `RailBraking.Friction.PadFriction` is linear, and laws of blocks are monotone, so that the minimum is
    at an end of its range.

    Args:
        friction: Nominal friction.
        effects: speed_effect, speed_nominal [m/s], force_effect, force_nominal [N] and temperature_effect.
        speed: Highest sliding speed [m/s].
        force: Highest force of both pads [N].
        shape: Factor by sliding speed and force, monotone in both, that multiplies friction.
    """
    heat = 1 - abs(effects["temperature_effect"])
    return min(
        (
            friction
            * heat
            * (1 + effects["speed_effect"] * (1 - v / effects["speed_nominal"]))
            * (1 - effects["force_effect"] * (normal / effects["force_nominal"] - 1))
            * shape(v, normal),
            v,
            normal,
        )
        for v in (0.0, speed)
        for normal in (0.0, force)
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Brake:
    """The brake units and wheelsets of one group, with nominal or true data; the type of each states unit and meaning.

    A datum that is neither given nor required is NaN.
    """

    load: Annotated[float, "N", "static wheel-rail force of the group"]
    inertia: Annotated[float, "kg.m2", "rotational inertia of its wheelsets and discs"]
    wheel_radius: Annotated[float, "m", "rolling radius"]
    units: Annotated[float, "1", "number of brake units"]
    friction_radius: Annotated[float, "m", "mean radius of the pads on the disc"]
    piston_area: Annotated[float, "m2", "of one brake cylinder"]
    rigging: Annotated[float, "1", "lever ratio times efficiency, both pads"]
    spring_force: Annotated[float, "N", "of slack adjuster and return spring, at the piston"]
    pressure_max: Annotated[float, "Pa", "highest brake cylinder pressure"]

    def __post_init__(self) -> None:
        """Check the data.

        Raises:
            ValueError: A value is not positive (the spring force may be zero), or the spring holds the piston back at
                full pressure.
        """
        for name in BRAKE:
            if getattr(self, name) <= 0 and name != "spring_force":
                raise ValueError(f"Brake: {name} must be positive, got {getattr(self, name)}.")
        if self.spring_force < 0:
            raise ValueError(f"Brake: spring_force must not be negative, got {self.spring_force}.")
        if self.spring_force >= self.pressure_max * self.piston_area:
            raise ValueError(
                f"Brake: the return spring ({self.spring_force} N) holds the piston back at pressure_max "
                f"({self.pressure_max} Pa on {self.piston_area} m²); check both."
            )

    def pad_force(self, pressure: Values) -> Values:
        """Return the normal force of both pads of a unit [N] at a cylinder pressure [Pa]."""
        return pad_force(pressure, piston_area=self.piston_area, spring_force=self.spring_force, rigging=self.rigging)

    def pressure_of(self, force: Values) -> Values:
        """Return the cylinder pressure [Pa] at which both pads of a unit press with a force [N]."""
        return pressure_of(force, piston_area=self.piston_area, spring_force=self.spring_force, rigging=self.rigging)


BRAKE: Mapping[str, tuple[str, str]] = MappingProxyType(
    {name: hint.__metadata__ for name, hint in get_type_hints(Brake, include_extras=True).items()}
)
"""Unit and meaning of each datum of a group's brake."""

PRESSURE_OF_FORCE = frozenset({"piston_area", "spring_force", "rigging"})
"""Data that `Brake.pressure_of` and `Brake.pad_force` use."""


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
