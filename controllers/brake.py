"""The brake equipment as a controller uses it: the pressure for a torque, and brake data as parameters of a formula."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict

from railgrip.controllers.sampled import Expression, choose, within
from railgrip.vehicle.brake import Brake, pressure_of


def by_name(groups: Sequence[Brake]) -> dict[str, float]:
    """Return the data of all groups by the names of a formula's parameters, such as `load[1]` of the first group."""
    return {f"{name}[{g}]": value for g, group in enumerate(groups, 1) for name, value in asdict(group).items()}


_PAD_FRICTION = 0.1, 0.6
"""Limits of pad friction, with a margin: UIC 541-3 has 0.35 to 0.45, ±20 % between lots; wet pads lose up to 30 %."""


def pressure_for(torque: Expression, pad_friction: Expression, brake: Mapping[str, Expression]) -> Expression:
    """Return the brake cylinder pressure [Pa] at which a group's units give `torque` [N·m]; within 0 … pressure_max.

    An impossible estimate of pad friction, as after wrong readings, is limited to the possible range. A negative one
    would leave the brake off for good: without pressure no reading depends on the pads, so the estimate would not
    recover.

    Source: Schwarz, Lüdicke, Heckmann (2019), eq. (3), solved for p_c.
    """
    pad_force = torque / (brake["units"] * within(pad_friction, *_PAD_FRICTION) * brake["friction_radius"])
    pressure = pressure_of(pad_force, **{name: brake[name] for name in ("piston_area", "spring_force", "rigging")})
    full = brake["pressure_max"]
    return choose(pressure <= 0.0, 0.0, choose(pressure < full, pressure, full))
