"""The brake equipment as a controller knows it: torque from pressure and pressure from torque."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from types import MappingProxyType

from railgrip.controllers.sampled import Expression, choose, within

BRAKE = MappingProxyType(
    {
        "load": ("N", "static wheel-rail force of the group"),
        "inertia": ("kg.m2", "rotational inertia of its wheelsets and discs"),
        "wheel_radius": ("m", "rolling radius"),
        "units": ("1", "number of brake units"),
        "friction_radius": ("m", "mean radius of the pads on the disc"),
        "piston_area": ("m2", "of one brake cylinder"),
        "rigging": ("1", "lever ratio times efficiency, both pads"),
        "spring_force": ("N", "of slack adjuster and return spring, at the piston"),
        "pressure_max": ("Pa", "highest brake cylinder pressure"),
    }
)
"""Unit and meaning of each datum of a group's brake."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BrakeGroup:
    """Nominal data of the brake units and wheelsets of one group; units and meanings are in `BRAKE`."""

    load: float
    inertia: float
    wheel_radius: float
    units: float
    friction_radius: float
    piston_area: float
    rigging: float
    spring_force: float
    pressure_max: float

    def __post_init__(self) -> None:
        """Refuse data that no brake has.

        Raises:
            ValueError: A value is not positive, where that of the spring may be zero, or the spring holds the piston
                back at full pressure.
        """
        for name in self.__slots__:
            if not getattr(self, name) > 0 and name != "spring_force":
                raise ValueError(f"BrakeGroup: {name} must be positive, got {getattr(self, name)}.")
        if not self.spring_force >= 0:
            raise ValueError(f"BrakeGroup: spring_force must not be negative, got {self.spring_force}.")
        if self.spring_force >= self.pressure_max * self.piston_area:
            raise ValueError(
                f"BrakeGroup: the return spring ({self.spring_force} N) holds the piston back at pressure_max "
                f"({self.pressure_max} Pa on {self.piston_area} m²); check both."
            )


def by_name(groups: Sequence[BrakeGroup]) -> dict[str, float]:
    """Return the data of all groups by the names of a formula's parameters, `load[1]` the first group's."""
    return {f"{name}[{g}]": value for g, group in enumerate(groups, 1) for name, value in asdict(group).items()}


_PAD_FRICTION = 0.1, 0.6
"""What pads may have, with a margin: UIC 541-3 has 0.35 to 0.45 by ±20 % between lots; wet ones lose up to 30 %."""


def pressure_for(torque: Expression, pad_friction: Expression, brake: Mapping[str, Expression]) -> Expression:
    """Return the brake cylinder pressure [Pa] at which a group's units give `torque` [N·m]; within 0 … pressure_max.

    An estimate of pad friction that no pad has, as after a sensor has lied, is taken for the nearest that one may have:
    below zero it would leave the brake off for good, for without pressure nothing tells of pads.

    Source: Schwarz, Lüdicke, Heckmann (2019), eq. (3), solved for p_c.
    """
    pad_force = torque / (brake["units"] * within(pad_friction, *_PAD_FRICTION) * brake["friction_radius"])
    pressure = (pad_force / brake["rigging"] + brake["spring_force"]) / brake["piston_area"]
    full = brake["pressure_max"]
    return choose(pressure <= 0.0, 0.0, choose(pressure < full, pressure, full))
