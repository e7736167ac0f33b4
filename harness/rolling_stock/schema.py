"""The train file as a type: cars on bogies on axles, brakes, couplers, and where each number comes from.

Every table of numbers has an origin: `source = "…"` for published values, `estimated = true`, or a list of keys, for
estimates. No physical value has a default.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, PrivateAttr, StrictBool, StrictInt

from railgrip.base.names import known_names
from railgrip.base.tables import TomlTable
from railgrip.base.units import GRAVITY
from railgrip.rolling_stock.brakes import (
    CONSTANT,
    LAWS,
    AxleBrake,
    BlockLaw,
    Blocks,
    BrakeUnit,
    DynamicBrake,
    LagTime,
    Pads,
    ParkingBrake,
    RailBrake,
    Share,
    SourcedTable,
    TrackBrake,
    TravelSpeed,
    WireDelay,
    kinds_of_dynamic_brakes,
)
from railgrip.rolling_stock.dispersion import Dispersion, Failures
from railgrip.scenario.file import locate
from railgrip.scenario.load import read_toml, require_kind, validate_table
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.surface import Sander
from railgrip.scenario.table import ByKind, Length, Name, Table, optional, table_error

# Values outside the limits are refused: they have a wrong unit, or are of another part. Values outside the usual range
# are valid, and `railgrip.rolling_stock.check` remarks on them.
Drag = Annotated[
    float,
    UnitRange(
        "1",
        above=0,
        at_most=50,
        because="a train has some 0.3 to 1 for its ends and 0.1 to 0.4 for each car (Peters, 1983; Raghunathan, 2002)",
    ),
]
BearingFriction = Annotated[
    float, UnitRange("1", above=0, at_most=0.2, usual=(3e-4, 0.02), because="roller bearings have about 0.002")
]
BearingRadius = Annotated[
    float,
    UnitRange("m", between=(0.005, 0.3), usual=(0.02, 0.12), because="journals have diameters of 0.1 to 0.18 m"),
]
RollingArm = Annotated[
    float,
    UnitRange("m", between=(1e-6, 0.01), or_zero=True, usual=(1e-4, 2e-3), because="steel rolls at 0.5 mm"),
]
WheelRadius = Annotated[
    float,
    UnitRange(
        "m",
        between=(0.15, 0.7),
        usual=(0.25, 0.65),
        because="this is the radius, not the diameter; wheels have diameters of 0.33 m (UIC 510-2) to 1.25 m",
    ),
]
Diameter = Annotated[
    float, UnitRange("m", between=(0.01, 0.1), usual=(0.02, 0.04), because="brake pipes have 25 to 32 mm")
]
CarLength = Annotated[float, UnitRange("m", between=(2, 100), usual=(5, 50), because="cars are 5 to 50 m long")]
AxlePosition = Annotated[
    float, UnitRange("m", between=(0, 20), because="no rigid frame is longer; a car of single axles has 9 m")
]
Height = Annotated[
    float,
    UnitRange(
        "m",
        between=(0.01, 5),
        usual=(0.15, 2.5),
        because="frames and rods are at the height of axles, rods of single axles at the centre of gravity of the car",
    ),
]
CarMass = Annotated[float, UnitRange("kg", between=(500, 5e5), usual=(3e3, 1.6e5), because="cars weigh 3 t to 160 t")]
AxleMass = Annotated[
    float,
    UnitRange(
        "kg",
        between=(200, 6e4),
        usual=(1e3, 4e4),
        because="axles carry 1 t to 40 t; the highest axle load of EN 15528 is 25 t",
    ),
]
WheelsetMass = Annotated[
    float,
    UnitRange(
        "kg", between=(50, 1e4), usual=(300, 6e3), because="wheelsets weigh 0.5 t to 2 t, with a drive up to 5 t"
    ),
]
FrameMass = Annotated[
    float,
    UnitRange("kg", between=(50, 5e4), usual=(300, 2e4), because="bogie frames weigh 0.5 t to 20 t"),
]
WheelsetInertia = Annotated[
    float,
    UnitRange(
        "kg.m2", between=(1, 5e3), usual=(10, 2500), because="wheelsets have 20 to 250 kg.m2, with a drive up to 2000"
    ),
]
FrameInertia = Annotated[
    float,
    UnitRange(
        "kg.m2",
        between=(10, 1e7),
        usual=(100, 1e6),
        because="bogie frames have inertias of 200 to 1e5 kg.m2, cars on single axles up to 1e6 kg.m2",
    ),
]
FrontalArea = Annotated[
    float,
    UnitRange("m2", between=(0.5, 100), usual=(2, 16), because="European gauges (EN 15273) enclose about 12 m2"),
]
Strength = Annotated[
    float,
    UnitRange(
        "N",
        between=(1e4, 1e8),
        usual=(5e4, 5e6),
        because="couplers withstand about 100 kN in trams and 1.5 MN in trains (EN 12663-1)",
    ),
]
Stiffness = Annotated[
    float,
    UnitRange(
        "N/m",
        between=(1e4, 1e10),
        usual=(1e5, 1e9),
        because="axle boxes have 1.2 MN/m in the Manchester benchmarks (Iwnicki, 1998), couplers about 10 MN/m",
    ),
]
Damping = Annotated[
    float,
    UnitRange(
        "N.s/m",
        between=(10, 1e9),
        or_zero=True,
        usual=(500, 1e7),
        because="dampers of trains have 1 kN.s/m to 1 MN.s/m",
    ),
]
Seconds = Annotated[
    float,
    UnitRange("s", between=(1e-3, 120), or_zero=True, usual=(0, 15), because="brakes act within seconds"),
]
FillTime = Annotated[
    float,
    UnitRange("s", between=(1e-6, 60), usual=(1, 35), because="UIC 540 has 3 to 5 s (P) and 18 to 30 s (G)"),
]
SharedBy = Literal["axle", "bogie", "car"]


Volume = Annotated[float, UnitRange("m3", between=(1e-4, 10))]
_MAIN = "main reservoirs have 7 to 10 bar (EN 14198)"
_DELIVERY = "compressors of trains deliver 0.5 to 5 m3 of free air in a minute"


class Resistance(SourcedTable):
    """Resistances of the train: air, bearings, rolling."""

    drag_coefficient: Drag = Field(description="drag coefficient of the whole train, referred to its frontal area")
    frontal_area: FrontalArea = Field(description="frontal area of the train")
    bearing_friction: BearingFriction = Field(description="friction coefficient of the axle bearings")
    bearing_radius: BearingRadius = Field(description="radius at which the bearing friction acts")
    rolling_arm: RollingArm = Field(description="lever arm of the rolling resistance")


class Davis(SourcedTable):
    """Running resistance of the train as A + B v + C v² (Davis), an alternative to [resistance]."""

    constant: Annotated[
        float,
        UnitRange("N", between=(1, 1e6), or_zero=True, usual=(100, 1e5), because="trains roll with 5 to 30 N/t"),
    ] = Field(description="A, resistance at standstill; it acts at the wheels, as rolling resistance")
    linear: Annotated[
        float,
        UnitRange("N.s/m", between=(1e-2, 1e5), or_zero=True, usual=(1, 5e3), because="trains have up to 5 kN.s/m"),
    ] = Field(description="B, increase with speed")
    quadratic: Annotated[
        float,
        UnitRange(
            "N.s2/m2", between=(1e-3, 1e3), or_zero=True, usual=(0.5, 200), because="trains have 3 to 100 N.s2/m2"
        ),
    ] = Field(description="C, increase with the square of the speed, by the air")


class Electropneumatic(SourcedTable):
    """An emergency brake commanded by wire: the same dead time and first-order build-up in the whole train."""

    kind: Literal["electropneumatic"]
    delay: WireDelay = Field(description="time from the demand to the first pressure")
    time_constant: LagTime = Field(description="time constant of the build-up after the delay")


class BrakePipe(SourcedTable):
    """An emergency brake commanded through the brake pipe; a distributor in each car fills its cylinders."""

    kind: Literal["brake_pipe"]
    diameter: Diameter = Field(description="inner diameter of the pipe")
    branch_volume: Annotated[float, UnitRange("m3", between=(1e-6, 1), or_zero=True)] = Field(
        description="volume of branch pipe and dirt collector in each car, upstream of the distributor"
    )
    fill_time: FillTime = Field(
        description="time from the first pressure to 95 % of the highest pressure, through a distributor"
    )
    reservoir: Volume = Field(description="volume of the auxiliary reservoir of each car")


AirPressure = Annotated[float, UnitRange("Pa", between=(1e5, 1.5e6), usual=(5e5, 1.1e6), because=_MAIN)]


class AirSupply(SourcedTable):
    """Reservoirs and compressor; without it there is air without limit behind [command] kind = "electropneumatic".

    Behind a brake pipe there are, without it, auxiliary reservoirs that nothing fills during a stop, and a main
    reservoir of 1 m3 at 8 bar.
    """

    main_reservoir: Volume = Field(description="volume of all main reservoirs and the main pipe")
    pressure: AirPressure = Field(
        description="pressure at the start of main reservoirs, and of brake reservoirs that they feed"
    )
    reservoir: Volume | None = Field(
        default=None, description="brake reservoir of each car; behind a brake pipe it is `reservoir` of [command]"
    )
    feed: Literal["main_pipe", "brake_pipe"] = Field(
        default="main_pipe", description="pipe from which check valves feed the reservoirs of the cars"
    )
    conductance: Annotated[float, UnitRange("m3/(s.Pa)", between=(1e-12, 1e-5))] = Field(
        description="sonic conductance of the check valve of each reservoir; 10 mm2 have about 2e-8"
    )
    compressor: Annotated[
        float, UnitRange("m3/s", between=(1e-4, 1), or_zero=True, usual=(5e-3, 0.1), because=_DELIVERY)
    ] = Field(default=0.0, description="free air that the compressors deliver while they run; 0 for none")
    compressor_on: AirPressure = Field(default=8.5e5, description="pressure below which compressors start")
    compressor_off: AirPressure = Field(default=1e6, description="pressure above which they stop")

    def _check(self) -> None:
        if self.compressor_on >= self.compressor_off:
            raise table_error(
                f"has compressor_on {self.compressor_on / 1e5:g} bar and compressor_off {self.compressor_off / 1e5:g} "
                "bar; compressor_on must be lower"
            )


@dataclass(frozen=True, slots=True)
class Stages:
    """The two stages of a distributor in position R; attributes as the keys of `Distributor`."""

    low_share: float
    speed_up: float
    speed_down: float
    stage_time: float


class Distributor(SourcedTable):
    """A distributor of a car: its times (position G or P), and two stages for position R, all of them or none.

    RailBraking.Pneumatics.Distributor, or TwoStageDistributor with stages.
    """

    fill_time: FillTime | None = Field(
        default=None,
        description="time from the first pressure to 95 % of the highest pressure; that of [command] unless given",
    )
    release_time: (
        Annotated[
            float,
            UnitRange("s", between=(1, 200), usual=(10, 70), because="UIC 540 has 15 to 20 s (P), 45 to 60 s (G)"),
        ]
        | None
    ) = Field(default=None, description="release time from the highest pressure to 0.4 bar; 17 s unless given")
    inshot: Annotated[float, UnitRange("1", between=(0, 0.5), usual=(0, 0.2))] = Field(
        default=0.0, description="share of the highest pressure that comes at once, and brings blocks to the wheel"
    )
    low_share: Share | None = Field(
        default=None, description="ratio of the cylinder pressures of the low and the high stage"
    )
    speed_up: TravelSpeed | None = Field(
        default=None, description="speed at and above which the distributor changes to the high stage"
    )
    speed_down: TravelSpeed | None = Field(
        default=None, description="speed below which the distributor changes to the low stage"
    )
    stage_time: LagTime | None = Field(default=None, description="time constant of the change between the stages")

    def _check(self) -> None:
        keys = ("low_share", "speed_up", "speed_down", "stage_time")
        lacking = [key for key in keys if getattr(self, key) is None]
        if 0 < len(lacking) < len(keys):
            raise table_error(f"has two stages, but no {', '.join(lacking)}: give {', '.join(keys)}, or none of them")
        if lacking and self.fill_time is None and self.release_time is None and self.inshot == 0:
            raise table_error(f"has no key that acts: give fill_time, release_time, inshot, or {', '.join(keys)}")
        if self.stages is not None and self.stages.speed_down >= self.stages.speed_up:
            raise table_error(
                f"has speed_down {3.6 * self.stages.speed_down:g} km/h and speed_up {3.6 * self.stages.speed_up:g} "
                "km/h; speed_down must be lower than speed_up"
            )

    @property
    def stages(self) -> Stages | None:
        """Its two stages; None with a single one."""
        if self.low_share is None or self.speed_up is None or self.speed_down is None or self.stage_time is None:
            return None
        return Stages(self.low_share, self.speed_up, self.speed_down, self.stage_time)


class LoadValve(SourcedTable):
    """A brake that follows the load of its car: a valve that adapts the pressure, or a changeover of the rigging.

    The mass of a car does not change during a stop, so that its share is constant.
    """

    kind: Literal["valve", "changeover"] = Field(
        description="valve: pressure rises linearly with the mass; changeover: one rigging for empty, one for full"
    )
    empty_share: Share = Field(description="share of pressure_max (valve) or of rigging (changeover) of the empty car")
    empty_mass: CarMass | None = Field(default=None, description="mass of the empty car; a valve needs it")
    full_mass: CarMass = Field(
        description="mass from which pressure_max (valve), or the whole rigging ratio (changeover) acts"
    )

    def _check(self) -> None:
        if (self.kind == "valve") == (self.empty_mass is None):
            raise table_error("needs empty_mass with kind 'valve', and no empty_mass with kind 'changeover'")
        if self.empty_mass is not None and self.empty_mass >= self.full_mass:
            raise table_error(
                f"has empty_mass {self.empty_mass / 1e3:g} t and full_mass {self.full_mass / 1e3:g} t; empty_mass must "
                "be lower than full_mass"
            )

    def share(self, mass: float) -> float:
        """Return the share of the pressure or of the rigging for the mass of a car [kg]."""
        if self.empty_mass is None:
            return 1.0 if mass >= self.full_mass else self.empty_share
        load = (mass - self.empty_mass) / (self.full_mass - self.empty_mass)
        return self.empty_share + (1 - self.empty_share) * min(max(load, 0.0), 1.0)


_READY = "above it an accelerator would be ready to open again, and would open and close repeatedly"


class Accelerator(SourcedTable):
    """Valve that vents the brake pipe at a car when its pressure falls fast: RailBraking.Pneumatics.Accelerator."""

    conductance: Annotated[float, UnitRange("m3/(s.Pa)", between=(1e-11, 1e-5))] = Field(
        description="sonic conductance of the vent; 1 cm2 has about 2e-7"
    )
    opening_rate: Annotated[float, UnitRange("Pa/s", between=(1, 1e7))] = Field(
        description="rate of decrease of the pipe pressure at which it opens"
    )
    closing_pressure: Annotated[float, UnitRange("Pa", at_least=1, below=4.5e5, because=_READY)] = Field(
        description="pipe pressure at which it closes again"
    )
    sensing_time: LagTime = Field(description="time over which the decrease is measured")


Command = Annotated[Electropneumatic | BrakePipe, Field(discriminator="kind")]


class Bogie(SourcedTable):
    """A bogie whose axles have the same wheels and brake units."""

    axles: tuple[AxlePosition, ...] = Field(
        min_length=2, max_length=8, description="equally spaced positions relative to the first axle, which is at 0"
    )
    brake: Name = Field(description="name of its brake units in [brakes]")
    units: tuple[Annotated[StrictInt, Field(ge=1, le=16)], ...] = Field(
        min_length=1, description="number of brake units per axle: one value for all axles, or one for each"
    )
    coupled: StrictBool = Field(description="whether shafts couple all its axles")
    valve: SharedBy = Field(description="whether each axle, bogie or car has its own brake valve")
    build_up_delay: WireDelay | None = Field(
        default=None, description="delay of its brakes instead of that of an electropneumatic [command]"
    )
    build_up_time: LagTime | None = Field(
        default=None, description="time constant of its brakes instead of that of an electropneumatic [command]"
    )
    track_brake: Name | None = Field(
        default=None, description="name of its track brakes in [track_brakes], used in an emergency"
    )
    dynamic_brake: Name | None = Field(
        default=None, description="name in [dynamic_brakes] of the electrodynamic or eddy-current brake"
    )
    dynamic_units: tuple[Annotated[StrictInt, Field(ge=0, le=4)], ...] = Field(
        default=(1,), min_length=1, description="number of dynamic brakes of an axle: one value, or one for each axle"
    )
    parking_brake: Name | None = Field(default=None, description="name of its parking brake in [parking_brakes]")
    parking_units: tuple[Annotated[StrictInt, Field(ge=0, le=16)], ...] = Field(
        default=(1,), min_length=1, description="number of parking units of an axle: one value, or one for each axle"
    )
    wheel_radius: WheelRadius = Field(description="rolling radius")
    inertia: tuple[WheelsetInertia, ...] = Field(
        min_length=1,
        description="inertia of an axle with wheels, discs and drive: one value for all axles, or one for each",
    )
    axle_mass: WheelsetMass = Field(description="mass of one wheelset")
    frame_mass: FrameMass = Field(description="mass of the frame without wheelsets")
    frame_inertia: FrameInertia = Field(description="pitch moment of inertia of the frame")
    frame_height: Height = Field(description="height of its centre of gravity above the rail")
    rod_height: Height = Field(description="height of the traction rod above the rail")
    stiffness: Stiffness = Field(description="stiffness of the primary suspension of one axle")
    damping: Damping = Field(description="damping of the primary suspension of one axle")

    def _check(self) -> None:
        if self.axles[0] != 0 or list(self.axles) != sorted(set(self.axles)):
            raise table_error("has axles whose positions do not start at 0 or do not increase")
        gap = self.wheelbase / (len(self.axles) - 1)
        if any(abs(at - i * gap) > 0.05 * gap for i, at in enumerate(self.axles)):
            raise table_error(
                "has axles that are not equally spaced; RailBraking.Components.BogieFrame needs equal spacing"
            )
        for key in ("units", "inertia", "dynamic_units", "parking_units"):
            count = len(getattr(self, key))
            if count not in (1, len(self.axles)):
                raise table_error(
                    f"has {len(self.axles)} axles and {count} {key}; give one value for all, or one for each"
                )

    @property
    def wheelbase(self) -> float:
        """Distance from the first axle to the last [m]."""
        return self.axles[-1]

    def each(self, values: Sequence[float]) -> list[float]:
        """Return one value for each axle, from one common value or one value for each."""
        return list(values) * (len(self.axles) // len(values))


class BogiePlacement(Table):
    """A bogie under a car."""

    kind: Name = Field(description="name of the bogie in [bogies]")
    at: Length = Field(description="distance from the front end of the car to the pivot in the middle of the bogie")
    reversed: StrictBool = Field(default=False, description="whether the last axle in [bogies] leads")
    shared: StrictBool = Field(default=False, description="whether it also carries the next car (a Jacobs bogie)")


class Coupler(SourcedTable):
    """Connection of two cars: a spring and a damper with slack."""

    stiffness: Stiffness = Field(description="stiffness of the spring")
    damping: Damping = Field(description="damping of the damper")
    slack: Annotated[float, UnitRange("m", between=(1e-5, 1), or_zero=True)] = Field(description="play of the coupler")
    strength: Strength = Field(description="maximum permissible force")


MOST_CARS = 64


class Car(SourcedTable):
    """A car: its mass in the stop, and its bogies."""

    name: Name = Field(description="name of the car in figures and messages")
    count: Annotated[StrictInt, Field(ge=1, le=MOST_CARS)] | None = optional(
        "number of such cars, one behind the other, with names NAME-1, NAME-2, …; the other keys are those of each, "
        "but the last car of the train has no coupler"
    )
    length: CarLength = Field(description="length over couplers")
    mass: CarMass = Field(description="mass during the stop, with bogies and load")
    axle_masses: tuple[AxleMass, ...] = Field(
        default=(), description="mass on each axle of its bogies; without them all axles carry equal masses"
    )
    bogies: tuple[BogiePlacement, ...] = Field(
        default=(), max_length=16, description="bogies under the car, the leading one first"
    )
    coupler: Name | None = Field(
        default=None, description="name in [couplers] of the coupler to the next car; without one both move as one body"
    )
    distributor: Name | None = Field(
        default=None,
        description="name of its distributor in [distributors]; without one a car has the fill_time of [command]",
    )
    accelerator: Name | None = Field(
        default=None, description="name in [accelerators] of the accelerator on its brake pipe"
    )
    load_valve: Name | None = Field(
        default=None, description="name in [load_valves] of what adapts its brakes to its mass"
    )
    _entry: int = PrivateAttr(default=1)

    @property
    def entry(self) -> int:
        """Number of its entry in [[cars]], from 1."""
        return self._entry

    def each(self, entry: int) -> Sequence["Car"]:
        """Return the cars of this entry of [[cars]], whose number is given."""
        names = [self.name] if self.count is None else [f"{self.name}-{i + 1}" for i in range(self.count)]
        cars = [self.model_copy(update={"name": name, "count": None}) for name in names]
        for car in cars:
            car._entry = entry
        return cars


def _cars_of(entries: tuple[Car, ...]) -> tuple[Car, ...]:
    cars = [car for number, entry in enumerate(entries, start=1) for car in entry.each(number)]
    if len(cars) > MOST_CARS:
        raise table_error(f"has {len(cars)} cars with those of count; a train has {MOST_CARS} at most")
    if entries and entries[-1].count is not None:
        cars[-1] = cars[-1].model_copy(update={"coupler": None})
    return tuple(cars)


class PublishedStop(Table):
    """A published stop on dry level track."""

    speed: TravelSpeed = Field(description="initial speed")
    distance: Annotated[float, UnitRange("m", between=(1, 1e4))] = Field(description="braking distance")
    limit: StrictBool = Field(default=False, description="whether the distance is an upper limit, not a measurement")
    source: str = Field(description="publication of the stop")


BrakePosition = Literal["passenger P", "freight P", "freight G"]


class EtcsData(SourcedTable):
    """What ETCS has to know of a train besides its brakes; see docs/etcs.md for the values of trains without it."""

    maximum_speed: TravelSpeed | None = Field(
        default=None, description="maximum speed; that of the fastest published stop unless given"
    )
    brake_position: BrakePosition = Field(description="brake position of SUBSET-026 3.13.2.2.4")
    k_wet: Annotated[float, UnitRange("1", above=0, at_most=1)] = Field(
        description="K_wet_rst, for all speeds: 1 over the increase of the deceleration distance on wet rail (EN 15595)"
    )
    traction_cut_off_time: Seconds = Field(description="T_traction_cut_off")
    service_time: Seconds | None = Field(
        default=None,
        description="T_brake_service; unless given that of the emergency brake, with a pipe of A.3.9",
    )
    brakes_without_adhesion: StrictBool = Field(
        default=False, description="whether brakes that need no adhesion count on reduced adhesion (A_NVMAXREDADH1)"
    )


@dataclass(frozen=True, slots=True)
class Axle:
    """An axle at its place in the train.

    Attributes:
        position: Distance from the front end of the train [m].
        mass: Mass on the rail, its own included [kg].
        inertia: Moment of inertia about its axis of rotation [kg m2].
        units, dynamic_units, parking_units: Numbers of brake units, dynamic brakes and parking units.
        bogie, car, group: Zero-based numbers; the axles of a group are coupled.
    """

    position: float
    mass: float
    inertia: float
    units: float
    dynamic_units: int
    parking_units: int
    bogie: int
    car: int
    group: int


@dataclass(frozen=True, slots=True)
class BogieInTrain:
    """A bogie at its place in the train.

    Attributes:
        kind: Name in [bogies].
        data: Data of that kind.
        brake: One of its brake units, with pressure or rigging for the load of its car, and the friction of the law of
            its blocks.
        pads: Pads of that unit; for blocks those without effects, whose friction `law` multiplies.
        law: Law of its blocks over the force of the unit; `CONSTANT` for pads.
        track_brake: Track brakes of the bogie, if it has any.
        dynamic_brake: Its electrodynamic or eddy-current brake, if it has one.
        position: Distance of its leading axle from the front end of the train [m].
        axles: Zero-based numbers of its axles.
        cars: Zero-based numbers of the one or two cars that it carries.
        reversed: Whether the last axle in [bogies] leads.
    """

    kind: str
    data: Bogie
    brake: BrakeUnit
    pads: Pads
    law: BlockLaw
    track_brake: TrackBrake | None
    dynamic_brake: DynamicBrake | None
    position: float
    axles: range
    cars: tuple[int, ...]
    reversed: bool

    @property
    def pad_friction(self) -> float:
        """Nominal friction of its pads or blocks."""
        return self.brake.pad_friction or 0.0  # never None in a train, whose blocks have the friction of their law

    @property
    def rail_brakes(self) -> tuple[tuple[str, RailBrake], ...]:
        """Names and data of its brakes that act on the rail itself."""
        brakes: list[tuple[str, RailBrake]] = []
        if self.track_brake is not None:
            brakes.append((str(self.data.track_brake), self.track_brake))
        if isinstance(self.dynamic_brake, RailBrake):
            brakes.append((str(self.data.dynamic_brake), self.dynamic_brake))
        return tuple(brakes)


@dataclass(frozen=True, slots=True)
class DynamicGroup:
    """The dynamic brakes of a group of coupled axles.

    Attributes:
        group, valve: Zero-based numbers.
        brake: Data of one brake.
        units: Number of brakes.
        load: Static load of the group [N].
    """

    group: int
    valve: int
    brake: AxleBrake
    units: int
    load: float

    def force_at(self, speed: Any) -> Any:
        """Return the available force at the rim at a speed [m/s] [N]; numbers or arrays."""
        return self.brake.force_at(speed, self.units, self.load)


class Train(Table):
    """A train, the leading car first."""

    name: Name = Field(description="name of the train")
    description: str = Field(default="", description="description in one line")
    command: Command | None = Field(
        default=None,
        description="command of the emergency brake; without it the pressure follows the demand immediately",
    )
    air: AirSupply | None = Field(default=None, description="reservoirs and compressor of the brakes")
    resistance: Resistance | None = Field(default=None, description="running resistance by its causes")
    davis: Davis | None = Field(default=None, description="running resistance by speed, instead of [resistance]")
    pads: dict[Name, Pads] = Field(default={}, description="kinds of pads, by name")
    blocks: dict[Name, Blocks] = Field(default={}, description="kinds of brake blocks, by name")
    brakes: dict[Name, BrakeUnit] = Field(description="kinds of brake units, by name")
    track_brakes: dict[Name, TrackBrake] = Field(default={}, description="kinds of magnetic track brakes, by name")
    dynamic_brakes: dict[Name, Annotated[DynamicBrake, ByKind(kinds_of_dynamic_brakes)]] = Field(
        default={}, description="kinds of electrodynamic and eddy-current brakes, by name"
    )
    parking_brakes: dict[Name, ParkingBrake] = Field(default={}, description="kinds of parking brakes, by name")
    bogies: dict[Name, Bogie] = Field(description="kinds of bogies, by name")
    couplers: dict[Name, Coupler] = Field(default={}, description="kinds of couplers, by name")
    distributors: dict[Name, Distributor] = Field(default={}, description="kinds of distributors, by name")
    accelerators: dict[Name, Accelerator] = Field(default={}, description="kinds of accelerators, by name")
    load_valves: dict[Name, LoadValve] = Field(default={}, description="brakes that follow the load, by name")
    cars: Annotated[tuple[Car, ...], AfterValidator(_cars_of)] = Field(
        min_length=1, max_length=MOST_CARS, description="cars, the leading one first"
    )
    sanders: tuple[Sander, ...] = Field(
        default=(), max_length=256, description="sanders, for scenarios with [adhesion.sand]"
    )
    reference: tuple[PublishedStop, ...] = Field(default=(), description="published stops of the train")
    etcs: EtcsData | None = Field(default=None, description="data for braking curves of ETCS")
    dispersion: tuple[Dispersion, ...] = Field(
        default=(), max_length=32, description="dispersion of the brake, for K_dry"
    )
    failures: Failures | None = Field(default=None, description="failures of the brake, for K_dry")

    def __hash__(self) -> int:
        return hash(self.model_dump_json())

    def _check(self) -> None:
        if (self.resistance is None) == (self.davis is None):
            raise table_error(
                "needs one of [resistance] and [davis]: the running resistance by its causes, or by speed"
            )
        for kind, brake in self.brakes.items():
            self._require_names(brake, f"[brakes.{kind}]")
        for kind, bogie in self.bogies.items():
            self._require_names(bogie, f"[bogies.{kind}]")
            of_build_up = (bogie.build_up_delay, bogie.build_up_time)
            if of_build_up != (None, None):
                if None in of_build_up:
                    raise table_error(f"[bogies.{kind}] needs build_up_delay and build_up_time together")
                if not isinstance(self.command, Electropneumatic):
                    raise table_error(
                        f"[bogies.{kind}] build_up_delay needs [command] kind = 'electropneumatic'; behind a brake "
                        "pipe the distributor of its car has the times"
                    )
            for key in ("dynamic", "parking"):
                units = getattr(bogie, f"{key}_units")
                if units != (1,) and getattr(bogie, f"{key}_brake") is None:
                    raise table_error(f"[bogies.{kind}] {key}_units needs {key}_brake")
                if not any(units):
                    raise table_error(f"[bogies.{kind}] {key}_units has only zeros: leave out {key}_brake")
            is_on_rail = bogie.dynamic_brake and isinstance(self.dynamic_brakes[bogie.dynamic_brake], RailBrake)
            if is_on_rail and bogie.dynamic_units != (1,):
                raise table_error(
                    f"[bogies.{kind}] dynamic_units: a brake on the rail belongs to the bogie, not to axles"
                )
        for number, car in enumerate(self.cars, start=1):
            where = f"[cars[{car.entry}]]"
            self._require_names(car, where)
            for key in ("distributor", "accelerator"):
                if getattr(car, key) and not isinstance(self.command, BrakePipe):
                    raise table_error(f"{where} {key} needs a brake pipe: give [command] kind = 'brake_pipe', too")
            count = sum(len(self.bogies[mount.kind].axles) for mount in car.bogies)
            if car.load_valve and any(mount.shared for mount in car.bogies):
                raise table_error(f"{where} load_valve: the load of a shared bogie is not that of one car")
            if car.axle_masses and len(car.axle_masses) != count:
                raise table_error(
                    f"{where} axle_masses has {len(car.axle_masses)} values, {car.name} has {count} axles"
                )
            if not car.axle_masses and any(mount.shared for mount in car.bogies):
                raise table_error(
                    f"{where} has a shared bogie, so its mass does not determine the axle masses: give axle_masses"
                )
            last = number == len(self.cars)
            if last and (car.coupler or any(mount.shared for mount in car.bogies)):
                raise table_error(f"{where} is the last car: it can have neither a shared bogie nor a coupler")
        if not self.axles:
            raise table_error("[[cars]] have no bogies: a train needs at least one axle")
        beyond = next((i for i, sander in enumerate(self.sanders, start=1) if sander.wheelset > len(self.axles)), None)
        if beyond is not None:
            raise table_error(
                f"[sanders[{beyond}]] is at wheelset {self.sanders[beyond - 1].wheelset}, "
                f"the train has {len(self.axles)}"
            )
        positions = [axle.position for axle in self.axles]
        if positions != sorted(set(positions)):
            raise table_error(
                "[[cars]] bogies: the positions of the axles do not increase along the train; check 'at' and axles"
            )
        self._check_blending()
        self._check_air()

    def _require_names(self, entry: Table, where: str) -> None:
        """Raise an error for a name in an entry, as in its key `coupler`, that is not in the table, as [couplers]."""
        for key in type(entry).model_fields:
            value, table = getattr(entry, key), f"{key.removesuffix('s')}s"
            if value is None or table not in type(self).model_fields:
                continue
            choice = getattr(self, table)
            for name in [mount.kind for mount in value] if key == "bogies" else [value]:
                if name not in choice:
                    raise table_error(
                        f"{where} {key} names '{name}', which is not in [{table}]; it has "
                        + (known_names(choice, name) or "no entries")
                    )

    def _check_air(self) -> None:
        if self.air is None:
            return
        if self.command is None:
            raise table_error("[air] supplies the brakes that a [command] reaches: give [command], too")
        is_pipe = isinstance(self.command, BrakePipe)
        if is_pipe == (self.air.reservoir is not None):
            raise table_error(
                "[air] needs no reservoir behind a brake pipe, where [command] has it"
                if is_pipe
                else "[air] needs the reservoir of each car"
            )
        if not is_pipe and self.air.feed == "brake_pipe":
            raise table_error("[air] feed = 'brake_pipe' needs [command] kind = 'brake_pipe'")

    def _check_blending(self) -> None:
        modes = {brake.brake.blending for brake in self.dynamic_groups} - {"added"}
        if len(modes) > 1:
            raise table_error("[dynamic_brakes] have blending 'valve' and 'train': friction brakes follow one of them")
        if modes and self.command is None:
            raise table_error("[dynamic_brakes] blending needs a [command], whose pressure is the demand")
        for valve in self.blended_valves:
            groups = [group for group, of in enumerate(self.valve_of_group) if of == valve]
            bogies = {self.bogie_of(group).kind: self.bogie_of(group).data for group in groups}
            same = {(bogie.brake, bogie.build_up_delay, bogie.build_up_time) for bogie in bogies.values()}
            if len(same) > 1:
                raise table_error(
                    f"[bogies] {', '.join(bogies)} share a brake valve, but have different brake or build_up: blending "
                    "relieves one pressure; give each bogie its own valve"
                )

    @property
    def entries(self) -> tuple[Car, ...]:
        """The first car of each entry of [[cars]]."""
        return tuple(next(cars) for _, cars in groupby(self.cars, key=lambda car: car.entry))

    @property
    def rail_brakes(self) -> tuple[tuple[BogieInTrain, str, RailBrake], ...]:
        """Bogie, name and data of each brake that acts on the rail itself, leading first."""
        return tuple((bogie, *named) for bogie in self.bogies_in_train for named in bogie.rail_brakes)

    @property
    def track_brake_force(self) -> float:
        """Maximum total force of all brakes on the rail itself [N]."""
        return sum(brake.largest() for *_, brake in self.rail_brakes)

    @cached_property
    def dynamic_groups(self) -> tuple[DynamicGroup, ...]:
        """Groups with electrodynamic or rotating eddy-current brakes, leading first."""
        found: list[DynamicGroup] = []
        for group, members in enumerate(self.groups):
            brake = self.bogie_of(group).dynamic_brake
            units = sum(self.axles[i].dynamic_units for i in members)
            if isinstance(brake, AxleBrake) and units:
                load = GRAVITY * sum(self.axles[i].mass for i in members)
                found.append(DynamicGroup(group, self.valve_of_group[group], brake, units, load))
        return tuple(found)

    @cached_property
    def valve_of_group(self) -> tuple[int, ...]:
        """Zero-based number of the brake valve of each group."""
        return tuple(valve for valve, count in enumerate(self.groups_per_valve) for _ in range(count))

    @property
    def blends_across(self) -> bool:
        """Whether dynamic brakes relieve the friction brakes of the whole train."""
        return any(brake.brake.blending == "train" for brake in self.dynamic_groups)

    @property
    def blended_valves(self) -> tuple[int, ...]:
        """Brake valves whose pressure falls where dynamic brakes act."""
        if self.blends_across:
            return tuple(range(len(self.groups_per_valve)))
        return tuple(sorted({brake.valve for brake in self.dynamic_groups if brake.brake.blending == "valve"}))

    @cached_property
    def bogies_in_train(self) -> tuple[BogieInTrain, ...]:
        """All bogies, leading first."""
        bogies: list[BogieInTrain] = []
        front, first = 0.0, 0
        for number, car in enumerate(self.cars):
            for mount in car.bogies:
                data = self.bogies[mount.kind]
                last = first + len(data.axles)
                brake, pads, law = self._friction(self.brakes[data.brake])
                bogies.append(
                    BogieInTrain(
                        kind=mount.kind,
                        data=data,
                        brake=self._with_load(brake, car),
                        pads=pads,
                        law=law,
                        track_brake=self.track_brakes[data.track_brake] if data.track_brake else None,
                        dynamic_brake=self.dynamic_brakes[data.dynamic_brake] if data.dynamic_brake else None,
                        position=front + mount.at - data.wheelbase / 2,
                        axles=range(first, last),
                        cars=(number, number + 1) if mount.shared else (number,),
                        reversed=mount.reversed,
                    )
                )
                first = last
            front += car.length
        return tuple(bogies)

    @cached_property
    def axles(self) -> tuple[Axle, ...]:
        """All axles, leading first."""
        axles: list[Axle] = []
        group = 0
        masses = [mass for car in self.cars for mass in self._axle_masses(car)]
        for number, bogie in enumerate(self.bogies_in_train):
            data = bogie.data
            values = (data.units, data.inertia, data.dynamic_units, data.parking_units)
            of_axles = list(zip(*map(data.each, values), strict=True))
            offsets = list(data.axles)
            if bogie.reversed:
                offsets = [data.wheelbase - offset for offset in reversed(offsets)]
                of_axles.reverse()
            half = len(offsets) / 2
            for index, offset in enumerate(offsets):
                # Half of the axles of a shared bogie belong to each car.
                car = bogie.cars[0] if len(bogie.cars) == 1 or index < half else bogie.cars[1]
                units, inertia, dynamic_units, parking_units = of_axles[index]
                axles.append(
                    Axle(
                        position=bogie.position + offset,
                        mass=masses[len(axles)],
                        inertia=inertia,
                        units=units,
                        dynamic_units=int(dynamic_units) if isinstance(bogie.dynamic_brake, AxleBrake) else 0,
                        parking_units=int(parking_units) if data.parking_brake else 0,
                        bogie=number,
                        car=car,
                        group=group,
                    )
                )
                group += not data.coupled
            group += data.coupled
        return tuple(axles)

    @cached_property
    def groups(self) -> tuple[tuple[int, ...], ...]:
        """Zero-based axles of each group of coupled axles."""
        count = self.axles[-1].group + 1
        return tuple(tuple(i for i, axle in enumerate(self.axles) if axle.group == g) for g in range(count))

    def bogie_of(self, group: int) -> BogieInTrain:
        """Return the bogie that a group's axles belong to."""
        return self.bogies_in_train[self.axles[self.groups[group][0]].bogie]

    @cached_property
    def groups_per_valve(self) -> tuple[int, ...]:
        """Number of groups that share each brake valve, leading first."""
        keys: list[tuple[str, int]] = []
        for number, members in enumerate(self.groups):
            axle, shared_by = self.axles[members[0]], self.bogie_of(number).data.valve
            keys.append((shared_by, {"axle": axle.group, "bogie": axle.bogie, "car": axle.car}[shared_by]))
        return tuple(len(list(same)) for _, same in groupby(keys))

    @property
    def distributor_of_car(self) -> tuple[Distributor | None, ...]:
        """Distributor of each car that has one in [distributors]."""
        return tuple(self.distributors[car.distributor] if car.distributor else None for car in self.cars)

    @property
    def stages_of_car(self) -> tuple[Stages | None, ...]:
        """Stages of the distributor of each car; None for a car with a single stage."""
        return tuple(None if distributor is None else distributor.stages for distributor in self.distributor_of_car)

    @property
    def filling_of_car(self) -> tuple[tuple[float, float], ...]:
        """Filling time to 95 % [s] and inshot of each car behind a brake pipe; empty without one."""
        if not isinstance(self.command, BrakePipe):
            return ()
        of_command = self.command.fill_time
        return tuple(
            (of_command, 0.0) if d is None else (of_command if d.fill_time is None else d.fill_time, d.inshot)
            for d in self.distributor_of_car
        )

    @property
    def accelerator_of_car(self) -> tuple[Accelerator | None, ...]:
        """Accelerator of the brake pipe of each car; None for a car without one."""
        return tuple(self.accelerators[car.accelerator] if car.accelerator else None for car in self.cars)

    @property
    def mass(self) -> float:
        """Mass on all axles [kg]."""
        return sum(axle.mass for axle in self.axles)

    @property
    def length(self) -> float:
        """Length over couplers [m]."""
        return sum(car.length for car in self.cars)

    @cached_property
    def physics(self) -> Resistance:
        """[resistance], or the values with which the same equations give the constant and quadratic part of [davis].

        Rolling resistance acts on the load of each wheelset, drag on 1 m² in air of 1.2 kg/m³.
        """
        if self.resistance is not None:
            return self.resistance
        assert self.davis is not None
        lever = sum(axle.mass * GRAVITY / self.bogies_in_train[axle.bogie].data.wheel_radius for axle in self.axles)
        return Resistance.model_construct(
            drag_coefficient=self.davis.quadratic / 0.6, frontal_area=1.0, bearing_friction=1e-9,
            bearing_radius=0.065, rolling_arm=self.davis.constant / lever, source=self.davis.source,
        )  # fmt: skip

    @property
    def linear_resistance(self) -> float:
        """Running resistance over speed [N s/m], the linear part of [davis]."""
        return 0.0 if self.davis is None else self.davis.linear

    # The nominal point of blocks is that of a full car, so that all bogies of a kind have the same.
    def _with_load(self, brake: BrakeUnit, car: Car) -> BrakeUnit:
        if car.load_valve is None:
            return brake
        valve = self.load_valves[car.load_valve]
        key = "pressure_max" if valve.kind == "valve" else "rigging"
        return brake.model_copy(update={key: getattr(brake, key) * valve.share(car.mass)})

    def _friction(self, brake: BrakeUnit) -> tuple[BrakeUnit, Pads, BlockLaw]:
        if brake.blocks is None or brake.block_count is None:
            return brake, self.pads[str(brake.pads)], CONSTANT
        blocks = self.blocks[brake.blocks]
        law = LAWS[blocks.law].for_unit(brake.block_count)
        pads = Pads.model_construct(
            speed_effect=0.0, speed_nominal=blocks.speed_nominal, force_effect=0.0, force_nominal=brake.full_force,
            temperature_effect=0.0, temperature_nominal=333.15, temperature_range=150.0,
            settle_energy=blocks.settle_energy, source=blocks.source,
        )  # fmt: skip
        by_law = law.factor * law.shape(blocks.speed_nominal, brake.full_force)
        nominal = by_law if brake.pad_friction is None else brake.pad_friction
        return brake.model_copy(update={"pad_friction": float(nominal)}), pads, law

    def _axle_masses(self, car: Car) -> Sequence[float]:
        count = sum(len(self.bogies[mount.kind].axles) for mount in car.bogies)
        return car.axle_masses or [car.mass / max(count, 1)] * count


NAMED = ("vt642", "emu387", "loco_coaches", "tram")
"""Trains of this package whose stops docs/studies/trains.py compares."""


def load_train(path: Path) -> Train:
    """Return the train of a TOML file, or of this package by its name.

    Raises:
        ScenarioError: The file is missing, not TOML, or not a train; there is one sentence for each problem, with file
            and key.
    """
    path = locate(path, "trains")
    table = read_toml(path)
    require_kind(table, "train", path)
    return train_of(table, path.name)


def train_of(table: TomlTable, origin: str) -> Train:
    """Return the train described by plain tables; `origin` is the name of their source in messages.

    Raises:
        ScenarioError: The tables do not describe a valid train.
    """
    return validate_table(Train, table, directory=Path(), origin=origin)
