"""The signals of a trace: name, extent, unit and meaning, in the order of a recorded row."""

from dataclasses import dataclass
from typing import Literal

GROUPS = 4
WHEELSETS = 6

Extent = Literal["train", "group", "wheelset"]
_WIDTH: dict[Extent, int] = {"train": 1, "group": GROUPS, "wheelset": WHEELSETS}


@dataclass(frozen=True, slots=True)
class Signal:
    """One column or one block of columns of a trace.

    Attributes:
        name: Of the variable; the plant's output of the same name, or with a prefix who says it.
        extent: What it has one value of each: the train, each ω-group, each wheelset.
        unit: SI, "1" for ratios.
        meaning: For axes and for readers of the file.
    """

    name: str
    extent: Extent
    unit: str
    meaning: str

    @property
    def width(self) -> int:
        """Number of columns."""
        return _WIDTH[self.extent]


PLANT = (
    Signal("distance", "train", "m", "distance since the brake demand"),
    Signal("speed", "train", "m/s", "speed of the train"),
    Signal("acceleration", "train", "m/s2", "acceleration of the train, forward positive"),
    Signal("wheelset_speed", "group", "rad/s", "rotational speed of the wheelsets"),
    Signal("slip", "group", "1", "slip 1 - r*omega/v, braking positive"),
    Signal("adhesion", "wheelset", "1", "adhesion, braking force over wheel load"),
    Signal("group_adhesion", "group", "1", "adhesion, braking forces over wheel loads of the group"),
    Signal("wheelset_load", "wheelset", "N", "vertical wheelset load on the rail"),
    Signal("deflection", "wheelset", "m", "primary suspension deflection from static, compression positive"),
    Signal("cylinder_pressure", "group", "Pa", "brake cylinder pressure"),
    Signal("pad_force", "group", "N", "normal force of one brake unit"),
    Signal("pad_friction", "group", "1", "friction of the brake pads"),
    Signal("disc_temperature", "group", "K", "temperature of the brake discs"),
    Signal("brake_torque", "group", "N.m", "torque of the brakes"),
    Signal("air_used", "train", "m3", "free air used since the brake demand"),
    Signal("contact_heat", "train", "J", "energy dissipated in the wheel/rail contacts"),
    Signal("pad_heat", "train", "J", "energy dissipated in the brake pads"),
    Signal("damper_heat", "train", "J", "energy dissipated in the primary dampers"),
    Signal("resistance_work", "train", "J", "work of running and track resistance"),
    Signal("kinetic_energy", "train", "J", "kinetic energy of the train and its wheelsets"),
    Signal("locked", "group", "1", "1 while the wheelsets are locked"),
    Signal("standstill", "train", "1", "1 once the train stands"),
)
"""Truth: the plant's outputs."""

SENT = (
    Signal(
        "command",
        "group",
        "1",
        "command to the plant: cylinder pressure [Pa] or valve (-1 vent, 0 hold, 1 fill)",
    ),
    Signal("mu0", "wheelset", "1", "maximum friction at the wheelset"),
    Signal("track_force", "train", "N", "force of the track, forward positive"),
)
"""What the plant was given, in the order of its inputs."""

READINGS = (
    Signal("reading_speed", "train", "m/s", "read speed of the train"),
    Signal("reading_wheelset_speed", "group", "rad/s", "read rotational speed of the wheelsets"),
    Signal("reading_deflection", "wheelset", "m", "read primary suspension deflection"),
    Signal("reading_acceleration", "train", "m/s2", "read acceleration of the train"),
    Signal("reading_cylinder_pressure", "group", "Pa", "read brake cylinder pressure"),
)
"""What the sensors showed."""

BELIEVED = (
    Signal("estimate_speed", "train", "m/s", "estimated speed of the train"),
    Signal("estimate_wheelset_speed", "group", "rad/s", "estimated rotational speed of the wheelsets"),
    Signal("estimate_adhesion", "group", "1", "estimated adhesion"),
    Signal("estimate_pad_friction", "group", "1", "estimated friction of the brake pads"),
)
"""States of the estimator."""

SPREAD = (
    Signal("estimate_adhesion_sd", "group", "1", "standard deviation of the estimated adhesion"),
    Signal("estimate_pad_friction_sd", "group", "1", "standard deviation of the estimated pad friction"),
)
"""How sure it was of them."""

INNOVATION = (
    Signal("estimate_nis", "train", "1", "normalised innovation squared of the estimator's last step"),
    Signal("estimate_readings", "train", "1", "readings that this step used, the degrees of the former"),
)
"""How far the readings were from what the estimator expected, in its own claim."""

ESTIMATES = (*BELIEVED, *SPREAD, *INNOVATION, Signal("estimate_slip", "group", "1", "estimated slip"))
"""What the estimator believed; absent from the trace of a stop without one."""
