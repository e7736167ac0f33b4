"""The brake equipment as a controller knows it: the pressure for a torque, and data as parameters of a formula."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict

from railgrip.controllers.sampled import Expression, choose, within
from railgrip.vehicle.brake import Brake, pressure_of


def by_name(groups: Sequence[Brake]) -> dict[str, float]:
    """Return the data of all groups by the names of a formula's parameters, `load[1]` the first group's."""
    return {f"{name}[{g}]": value for g, group in enumerate(groups, 1) for name, value in asdict(group).items()}


_PAD_FRICTION = 0.1, 0.6
"""What pads may have, with a margin: UIC 541-3 has 0.35 to 0.45 by ±20 % between lots; wet ones lose up to 30 %."""


def pressure_for(torque: Expression, pad_friction: Expression, brake: Mapping[str, Expression]) -> Expression:
    """Return the brake cylinder pressure [Pa] at which a group's units give `torque` [N·m]; within 0 … pressure_max.

    An estimate of pad friction that no pad has, as after a sensor has lied, is taken for the nearest that one may have:
    below zero it would leave the brake off for good, because without pressure nothing depends on the pads.

    Source: Schwarz, Lüdicke, Heckmann (2019), eq. (3), solved for p_c.
    """
    pad_force = torque / (brake["units"] * within(pad_friction, *_PAD_FRICTION) * brake["friction_radius"])
    pressure = pressure_of(pad_force, **{name: brake[name] for name in ("piston_area", "spring_force", "rigging")})
    full = brake["pressure_max"]
    return choose(pressure <= 0.0, 0.0, choose(pressure < full, pressure, full))
