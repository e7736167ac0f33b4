"""The signals of a stop: these tables determine what the parts of a stop exchange, and the content of a trace."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from types import MappingProxyType
from typing import Final, Literal, cast

from railgrip.base.names import ElementName
from railgrip.vehicle.formation import Extent, Formation


@dataclass(frozen=True, slots=True)
class Signal:
    """One column or one block of columns of a trace.

    Attributes:
        name: Name of the variable: that of the plant's output, with a prefix if it comes from another part.
        extent: What has one value: the train, each car, each group, each wheelset, or each coupler between two cars.
        unit: SI unit, "1" for ratios.
        meaning: Label of axes, and description in files.
    """

    name: str
    extent: Extent
    unit: str
    meaning: str


def places(signals: Iterable[Signal], formation: Formation) -> Mapping[str, slice]:
    """Return the place of each signal in a vector that contains them one after the other."""
    first, columns = 0, dict[str, slice]()
    for signal in signals:
        width = formation.width(signal.extent)
        columns[signal.name] = slice(first, first + width)
        first += width
    return MappingProxyType(columns)


def names_of(signal: Signal, formation: Formation) -> tuple[str, ...]:
    """Return the name of each value of a signal, such as `slip[1]` of the leading group."""
    if signal.extent == "train":
        return (signal.name,)
    return tuple(f"{signal.name}[{i + 1}]" for i in range(formation.width(signal.extent)))


def length(columns: Mapping[str, slice]) -> int:
    """Return the length of a vector of signals at these places."""
    return max(place.stop for place in columns.values())


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
"""True values: outputs of the plant. The trace has all of them, with NaN for those that a plant lacks."""

EXTRA = (
    Signal("contact_force", "wheelset", "N", "force of rail or roller along the track, positive in braking"),
    Signal("resistance_torque", "group", "N.m", "torque of bearing and rolling resistance"),
    Signal("coupler_force", "coupler", "N", "force in the coupler behind each car, positive when it pulls"),
    Signal("reservoir_pressure", "train", "Pa", "lowest pressure of the reservoirs that supply the cylinders"),
    Signal("dynamic_work", "train", "J", "work of electrodynamic and eddy-current brakes, in resistance_work"),
    Signal("drive_torque", "train", "N.m", "torque of a roller's drive, driving positive"),
)
"""Outputs that follow those of `PLANT` in the trace of a plant that has them."""

PLANT_INPUTS = (
    Signal("command", "group", "1", "command to the plant: cylinder pressure [Pa] or valve (-1 vent, 0 hold, 1 fill)"),
    Signal("mu0", "wheelset", "1", "maximum friction at the wheelset"),
    Signal("track_force", "train", "N", "force of the track on the train, forward positive"),
)
"""Inputs of the plant, which are bound by these names; see `railgrip.simulate.bound_plant`."""

CAR_TRACK_FORCE = (
    Signal("car_track_force", "car", "N", "force of the track on each car less its share of track_force by mass"),
)
"""Input that follows `PLANT_INPUTS` for a train with couplers on a track whose gradient or curvature changes."""

CURVE = (
    Signal("curve_k_A", "wheelset", "1", "Polach's k_A of the creep curve at the wheelset"),
    Signal("curve_k_S", "wheelset", "1", "Polach's k_S of the creep curve at the wheelset"),
    Signal("curve_A", "wheelset", "1", "friction at infinite slip speed over maximum friction, at the wheelset"),
    Signal("curve_B", "wheelset", "s/m", "decay of friction with slip speed, at the wheelset"),
)
"""Inputs that follow `PLANT_INPUTS` on a rail with several creep curves."""

MAGNETS = (Signal("magnets", "train", "1", "demand for the magnetic track brakes: 1 lowered, 0 lifted"),)
"""Input that follows `PLANT_INPUTS` for a train that has them, unless it is an emergency brake from the start."""

BRAKE_DEMAND = (Signal("brake_demand", "train", "1", "brake demand of the driver: 0 released, 1 emergency brake"),)
"""Input that follows them for a train whose [command] carries a [demand] of the driver to the brakes."""

CONTROLLER_DEMAND = (Signal("demand", "group", "Pa", "brake cylinder pressure that the controller demands"),)
"""Decisions of the controller; absent from the trace of a stop whose controller commands valves."""


def of_law(states: Iterable[tuple[str, str, str]]) -> tuple[Signal, ...]:
    """Return the signals of a law's visible states; `states` are name (`x[1]` for a group), unit and meaning.

    Elements of groups are contiguous for each name.
    """
    by_base = {ElementName.of(name).array: (name, unit, meaning) for name, unit, meaning in states}
    return tuple(
        Signal(f"law_{base}", "group" if name.endswith("]") else "train", unit, meaning)
        for base, (name, unit, meaning) in by_base.items()
    )


DRIVER_DEMAND = (Signal("driver_demand", "group", "Pa", "brake cylinder pressure that the driver demands"),)
"""Demand of the driver; absent from the trace of a stop whose scenario has no [demand]."""

TRACTION = (Signal("traction", "train", "N", "force of the traction, forward positive, a part of track_force"),)
"""Absent from the trace of a stop whose [demand] has no traction."""


READINGS = (
    Signal("reading_speed", "train", "m/s", "read speed of the train"),
    Signal("reading_wheelset_speed", "group", "rad/s", "read rotational speed of the wheelsets"),
    Signal("reading_deflection", "wheelset", "m", "read primary suspension deflection"),
    Signal("reading_acceleration", "train", "m/s2", "read acceleration of the train"),
    Signal("reading_cylinder_pressure", "group", "Pa", "read brake cylinder pressure"),
)
"""Readings of all kinds of sensors."""


def reading_of(signal: Signal) -> Signal:
    """Return the reading of a signal."""
    return Signal(f"reading_{signal.name}", signal.extent, signal.unit, f"read {signal.meaning}")


EXTRA_READINGS = (
    *(
        reading_of(signal)
        for signal in (*PLANT, *EXTRA)
        if signal.extent != "coupler" and f"reading_{signal.name}" not in {s.name for s in READINGS}
    ),
    Signal("reading_acceleration_along", "group", "m/s2", "read acceleration with the gravity of the gradient"),
    Signal("reading_latitude", "train", "deg", "read latitude"),
    Signal("reading_longitude", "train", "deg", "read longitude"),
    Signal("reading_height", "train", "m", "read height above the ellipsoid"),
)
"""Readings that follow those of `READINGS` in the trace if [sensors] requests them."""

ESTIMATED_STATES = (
    Signal("estimate_speed", "train", "m/s", "estimated speed of the train"),
    Signal("estimate_wheelset_speed", "group", "rad/s", "estimated rotational speed of the wheelsets"),
    Signal("estimate_adhesion", "group", "1", "estimated adhesion"),
    Signal("estimate_pad_friction", "group", "1", "estimated friction of the brake pads"),
)
"""States of the estimator."""

DEVIATIONS = (
    Signal("estimate_adhesion_sd", "group", "1", "standard deviation of the estimated adhesion"),
    Signal("estimate_pad_friction_sd", "group", "1", "standard deviation of the estimated pad friction"),
)
"""Standard deviations of estimates."""

INNOVATION = (
    Signal("estimate_nis", "train", "1", "normalised innovation squared of the estimator's last step"),
    Signal("estimate_readings", "train", "1", "readings that this step used, the degrees of the former"),
)
"""Deviation of the readings from those that the estimator expected, relative to its covariance."""

REFERENCE = (
    Signal("reference_speed", "train", "m/s", "speed that the estimator was given, of the radar or a rolling wheel"),
    Signal("test_release", "group", "1", "1 while the brake is released for a reference speed"),
)
"""Replacement of a missing radar reading; absent from the trace of a stop whose estimator has no free_wheels."""

ESTIMATES = (*ESTIMATED_STATES, *DEVIATIONS, *INNOVATION, Signal("estimate_slip", "group", "1", "estimated slip"))
"""Estimates; absent from the trace of a stop without an estimator."""


OBSERVATION = (
    Signal("speed", "train", "m/s", "speed of the train"),
    Signal("acceleration", "train", "m/s2", "acceleration of the train, negative in braking"),
    Signal("slip", "group", "1", "slip 1 - r*omega/v of the group"),
    Signal("adhesion", "group", "1", "estimated adhesion of the group, positive in braking"),
    Signal("pad_friction", "group", "1", "estimated friction of the group's brake pads"),
    Signal("wheelset_speed", "group", "rad/s", "rotational speed of the group's wheelsets"),
    Signal("driver_demand", "group", "Pa", "brake cylinder pressure that the driver asks for"),
    Signal("pressure", "group", "Pa", "measured brake cylinder pressure"),
)
"""Observation: inputs of a control law, estimated if there is an estimator of them, else read or computed."""

ONLY_ESTIMATED = frozenset({"adhesion", "pad_friction"})
"""Signals of an observation that exist only if they are estimated."""

_PRESSURE = OBSERVATION[-1]

TRAIN_INPUTS = (*OBSERVATION, *CONTROLLER_DEMAND)
"""Inputs of the decisions for the whole train over a law in Python."""

VALVE_INPUTS = (Signal("demand", "group", "Pa", "demanded brake cylinder pressure"), _PRESSURE)
"""Inputs of the valve logic."""

REFERENCE_INPUTS = (
    Signal("speed", "train", "m/s", "reading of the train speed; NaN while there is none"),
    Signal("wheelset_speed", "group", "rad/s", "newest reading"),
    Signal("pressure", "group", "Pa", "newest reading of the brake cylinder pressure"),
)
"""Inputs of the formula whose outputs are `REFERENCE`."""

BODY_FORCE_INPUTS = (
    Signal("speed", "train", "m/s", "estimated speed of the train"),
    Signal("applied", "train", "1", "1 while any group is to brake"),
    Signal("emergency", "train", "1", "1 while the command of the train, if it has one, is for full braking"),
    Signal("magnets", "train", "1", "demand for the magnetic track brakes: 1 lowered, 0 lifted"),
)
"""Inputs of the formula for the braking force on the body, which the estimator assumes."""

Role = Literal[
    "input", "output", "reading", "estimate", "observation", "driver", "train_input", "valve_input", "reference_input",
    "reference", "body_force_input",
]  # fmt: skip
"""Vectors that the parts of a loop exchange; inputs and outputs are those of the plant."""

TABLE: Final[Mapping[Role, tuple[Signal, ...]]] = MappingProxyType(
    {
        "input": PLANT_INPUTS, "output": PLANT, "reading": READINGS, "estimate": ESTIMATES, "observation": OBSERVATION,
        "driver": (*DRIVER_DEMAND, *TRACTION), "train_input": TRAIN_INPUTS, "valve_input": VALVE_INPUTS,
        "reference_input": REFERENCE_INPUTS, "reference": REFERENCE, "body_force_input": BODY_FORCE_INPUTS,
    }
)  # fmt: skip
"""Signals of each vector, in their order."""


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """Places of all quantities in the vectors that the parts of a loop exchange.

    Attributes:
        formation: Formation of the vehicle.
        signals: Signals of each vector, in their order.
        places: Place of each signal in its vector, by its name without the role as a prefix.
    """

    formation: Formation
    signals: Mapping[Role, tuple[Signal, ...]]
    places: Mapping[Role, Mapping[str, slice]]

    @property
    def input(self) -> Mapping[str, slice]:
        """Places of the plant's inputs."""
        return self.places["input"]

    @property
    def output(self) -> Mapping[str, slice]:
        """Places of the plant's outputs."""
        return self.places["output"]

    @property
    def reading(self) -> Mapping[str, slice]:
        """Places of the readings; an entry is NaN where a sensor has no new reading."""
        return self.places["reading"]

    @property
    def inputs(self) -> int:
        """Length of the plant's vector of inputs."""
        return length(self.input)

    @property
    def outputs(self) -> int:
        """Length of the plant's vector of outputs."""
        return length(self.output)

    @property
    def readings(self) -> int:
        """Length of a reading."""
        return length(self.reading)

    def elements(self, role: Role) -> tuple[str, ...]:
        """Return the names of the elements of a vector, such as `slip[1]` of the leading group."""
        return tuple(name for signal in self.signals[role] for name in names_of(signal, self.formation))

    def header(self) -> str:
        """Return sizes and places as C names, such as GROUPS, OUTPUTS and OUTPUT_SPEED."""
        formation = self.formation
        sizes = {"CARS": formation.cars, "GROUPS": formation.groups, "WHEELSETS": formation.wheelsets}
        sizes |= {f"{role}s".upper(): length(places) for role, places in self.places.items()}
        for role, places in self.places.items():
            sizes |= {f"{role}_{name}".upper(): place.start for name, place in places.items()}
        return "".join(f"#define {name} {value}\n" for name, value in sizes.items())


@cache
def layout_of(formation: Formation, **vectors: tuple[Signal, ...]) -> Layout:
    """Return the layout for a formation; `vectors` replace the signals of `TABLE`, by role."""
    signals = cast("Mapping[Role, tuple[Signal, ...]]", {**TABLE, **vectors})
    by_role: dict[Role, Mapping[str, slice]] = {
        role: MappingProxyType({n.removeprefix(f"{role}_"): place for n, place in places(vector, formation).items()})
        for role, vector in signals.items()
    }
    return Layout(formation, MappingProxyType(dict(signals)), MappingProxyType(by_role))


def plant_inputs(layout: Layout, *, pneumatic: bool) -> tuple[Signal, ...]:
    """Return the inputs of a plant, with the unit of the command: the position of a valve, or a pressure."""
    unit, meaning = ("1", "command to the valves: -1 vent, 0 hold, 1 fill") if pneumatic else (
        "Pa", "commanded brake cylinder pressure",
    )  # fmt: skip
    return tuple(
        replace(signal, unit=unit, meaning=meaning) if signal.name == "command" else signal
        for signal in layout.signals["input"]
    )
