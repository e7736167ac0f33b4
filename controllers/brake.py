"""The brake equipment as a controller knows it: torque from pressure and pressure from torque."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class BrakeGroup:
    """Nominal data of the brake units and wheelsets of one group.

    Attributes:
        load: Static wheel-rail force of the group [N].
        inertia: Rotational inertia of its wheelsets and discs [kg·m²].
        wheel_radius: Rolling radius [m].
        units: Number of brake units.
        friction_radius: Mean radius of the pads on the disc [m].
        piston_area: Of one brake cylinder [m²].
        rigging: Lever ratio times efficiency, both pads [1].
        spring_force: Of slack adjuster and return spring, at the piston [N].
        pressure_max: Highest brake cylinder pressure [Pa].
    """

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
            ValueError: A value is not positive, or the spring holds the piston back at full pressure.
        """
        for name in self.__slots__:
            if not getattr(self, name) > 0 and name != "spring_force":
                raise ValueError(f"BrakeGroup: {name} must be positive, got {getattr(self, name)}.")
        if self.spring_force >= self.pressure_max * self.piston_area:
            raise ValueError(
                f"BrakeGroup: the return spring ({self.spring_force} N) holds the piston back at pressure_max "
                f"({self.pressure_max} Pa on {self.piston_area} m²); check both."
            )

    def pressure(self, torque: float, pad_friction: float) -> float:
        """Brake cylinder pressure [Pa] at which the group's units give `torque` [N·m]; within 0 … pressure_max.

        Source: Schwarz, Lüdicke, Heckmann (2019), eq. (3), solved for p_c.
        """
        pad_force = torque / (self.units * pad_friction * self.friction_radius)
        pressure = (pad_force / self.rigging + self.spring_force) / self.piston_area
        if pressure <= 0.0:
            return 0.0
        return pressure if pressure < self.pressure_max else self.pressure_max
