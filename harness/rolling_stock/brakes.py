"""The brakes of a train file: tables of their data, and their forces by published laws.

Karwatzki's form of the laws of blocks on the tread is k1 (F + k2)/(F + k3) (v + k4)/(v + k5), with the force F of one
block. The law of eddy-current brakes is that of Wouterse (IEE Proceedings B 138, 1991), 2 F/(v/v1 + v1/v).
"""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Final, Literal, Self

import numpy as np
from pydantic import Field, StrictBool, StrictInt, model_validator

from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.table import FASTEST, Name, Table, table_error


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockLaw:
    """A law of block friction; with equal numbers above and below the lines it is a constant.

    Attributes:
        factor: Friction at infinite force and speed, k1.
        force_upper, force_lower: k2 and k3 [N].
        speed_upper, speed_lower: k4 and k5 [m/s].
        source: Publication.
    """

    factor: float
    force_upper: float
    force_lower: float
    speed_upper: float
    speed_lower: float
    source: str = ""

    def shape(self, speed: Any, force: Any) -> Any:
        """Return friction over `factor` at a sliding speed [m/s] and a force [N]; numbers or arrays."""
        of_force = (force + self.force_upper) / (force + self.force_lower)
        return of_force * (speed + self.speed_upper) / (speed + self.speed_lower)

    def for_unit(self, blocks: int) -> Self:
        """Return the law over the force of all blocks of a unit, which share it equally."""
        return replace(self, force_upper=blocks * self.force_upper, force_lower=blocks * self.force_lower)


SHAPE: Final = ("force_upper", "force_lower", "speed_upper", "speed_lower")
"""Numbers of a law that `BlockLaw.shape` uses."""


def _karwatzki(factor: float, k2: float, k3: float, k4: float, k5: float, source: str) -> BlockLaw:
    """Return a law from its published numbers: forces [kN], speeds [km/h]."""
    return BlockLaw(
        factor=factor, force_upper=1e3 * k2, force_lower=1e3 * k3, speed_upper=k4 / 3.6, speed_lower=k5 / 3.6,
        source=source,
    )  # fmt: skip


_WENDE = "Karwatzki, in Wende, Fahrdynamik des Schienenverkehrs (2003), as used by Open Rails (TrainCar.cs)"

_RULES = "Rules for traction calculations (Moscow, 1985), phosphorous cast iron, as used by maisvendoo/RRS"

LAWS: Final[Mapping[str, BlockLaw]] = MappingProxyType(
    {
        "cast_iron_p6": _karwatzki(0.024, 62.5, 12.5, 100, 20, _WENDE),
        # 0.5 (16 K + 100)/(52 K + 100), K in tf. Open Rails has 0.05 and 31.25 kN, as if 52 were 32: 31 % more friction
        # at 30 kN, and braked weights 42 % above the k-curve of UIC 544-1.
        "cast_iron_p10": _karwatzki(0.5 * 16 / 52 / 5, 62.5, 100 / 5.2, 100, 20, _RULES),
        "composite_k": _karwatzki(0.055, 200, 50, 150, 75, f"{_WENDE}, and RailProfAC/ShuntingBrakingCurves"),
    }
)
"""Name in a train file → law.

There is none for LL blocks: the published model (Cantone and Ottati, 2018) has polynomials for each initial speed, and
its coefficients are not in the paper.
"""

CONSTANT: Final = BlockLaw(factor=1, force_upper=1, force_lower=1, speed_upper=1, speed_lower=1)
"""A law without an effect, for pads."""

# Values outside the limits are refused: they have a wrong unit, or are of another part. Values outside the usual range
# are valid, and `railgrip.rolling_stock.check` remarks on them.
Ratio = Annotated[
    float, UnitRange("1", at_least=0.1, at_most=100, usual=(1, 15), because="riggings multiply by 2 to 10")
]
Efficiency = Annotated[
    float, UnitRange("1", at_least=0.1, at_most=1, because="EN 14531-1 has efficiencies of 0.83 to 0.98 for riggings")
]
Share = Annotated[float, UnitRange("1", above=0, at_most=1)]
PadFriction = Annotated[
    float,
    UnitRange(
        "1",
        at_least=0.02,
        at_most=0.7,
        usual=(0.08, 0.5),
        because="blocks of cast iron have 0.08 to 0.2, organic and sintered pads 0.25 to 0.45 (EN 14531-1)",
    ),
]
Effect = Annotated[float, UnitRange("1", at_least=-1, at_most=1)]
PadRadius = Annotated[
    float,
    UnitRange("m", at_least=0.02, at_most=0.7, usual=(0.08, 0.65), because="pads and blocks act within the wheel"),
]
PistonArea = Annotated[
    float,
    UnitRange(
        "m2",
        at_least=1e-4,
        at_most=0.3,
        usual=(5e-4, 0.15),
        because="pistons have diameters of 30 mm (hydraulic) to 406 mm (16 in)",
    ),
]
Spring = Annotated[
    float,
    UnitRange(
        "N",
        at_least=10,
        at_most=3e4,
        or_zero=True,
        usual=(50, 8e3),
        because="springs of cylinders have 0.2 to 3 kN; 0 is none",
    ),
]
PadForce = Annotated[
    float,
    UnitRange("N", at_least=100, at_most=1e6, usual=(2e3, 2e5), because="pads are pressed by 5 kN to 100 kN"),
]
Attraction = Annotated[
    float,
    UnitRange(
        "N",
        at_least=1e3,
        at_most=1e6,
        usual=(2e4, 1.5e5),
        because="magnets of track brakes have attractive forces of about 40 kN to 100 kN",
    ),
]
Pressure = Annotated[
    float,
    UnitRange(
        "Pa",
        at_least=1e4,
        at_most=3e7,
        because="brake cylinders have 2 to 6 bar of air, or up to 200 bar of oil",
    ),
]
WireDelay = Annotated[
    float,
    UnitRange(
        "s",
        at_least=1e-3,
        at_most=1,
        or_zero=True,
        because="commands by wire take tenths of a second, and RailBraking.Pneumatics.DelayLine holds 1 s",
    ),
]
TravelSpeed = Annotated[
    float,
    UnitRange(
        "m/s",
        at_least=0.1,
        at_most=FASTEST,
        usual=(0.1, 95.0),
        because="no train on wheels has been faster than 159.7 m/s",
    ),
]
Temperature = Annotated[
    float,
    UnitRange(
        "K",
        at_least=200,
        at_most=1300,
        usual=(250, 700),
        because="brakes work between 230 K and 1300 K; write '60 degC' for 60 °C",
    ),
]
TemperatureRange = Annotated[
    float, UnitRange("K", at_least=1, at_most=2e3, usual=(20, 800), difference=True, because="discs get 500 K hotter")
]
LagTime = Annotated[
    float, UnitRange("s", at_least=1e-3, at_most=60, usual=(0.02, 12), because="cylinders fill in 1 to 30 s")
]


class SourcedTable(Table):
    """A table of numbers with their origin."""

    source: str = Field(default="", description="publication of these numbers")
    estimated: StrictBool | tuple[str, ...] = Field(
        default=False, description="true if all numbers are estimates, or the keys of those that are estimates"
    )

    @model_validator(mode="after")
    def _check_sources(self) -> Self:
        if not self.source and self.estimated is False:
            raise table_error("has numbers without an origin: give source = '…', or estimated = true for your own")
        if isinstance(self.estimated, tuple):
            if not self.source:
                raise table_error("has estimated keys, but no source for the others: give source = '…', too")
            for key in self.estimated:
                if key not in type(self).model_fields:
                    choice = ", ".join(
                        name for name in type(self).model_fields if name not in SourcedTable.model_fields
                    )
                    raise table_error(f"calls '{key}' estimated, which it does not have; it has {choice}")
        return self


class Blocks(SourcedTable):
    """Friction of blocks on the tread by a published law of speed and block force: RailBraking.Friction.BlockFriction.

    The laws, with their sources, are in `LAWS`.
    """

    law: Literal["cast_iron_p6", "cast_iron_p10", "composite_k"] = Field(
        description="law by Karwatzki: cast iron P6 or P10, or composite K"
    )
    speed_nominal: TravelSpeed = Field(description="speed at which friction is nominal, with full force")
    settle_energy: Annotated[
        float, UnitRange("J", at_least=10, at_most=1e9, because="blocks and pads of trains settle over 50 to 200 kJ")
    ] = Field(description="friction energy of one unit after which friction has settled")


class Pads(SourcedTable):
    """Friction of pads on discs as a function of speed, force and temperature: RailBraking.Friction.PadFriction."""

    speed_effect: Effect = Field(description="relative increase in friction from the nominal speed to standstill")
    speed_nominal: TravelSpeed = Field(description="sliding speed at which friction is nominal")
    force_effect: Effect = Field(description="relative decrease in friction from the nominal force to twice that force")
    force_nominal: PadForce = Field(description="force of both pads at which friction is nominal")
    temperature_effect: Effect = Field(description="relative increase in friction over the temperature range")
    temperature_nominal: Temperature = Field(description="temperature at which friction is nominal")
    temperature_range: TemperatureRange = Field(
        description="temperature range over which friction changes by the temperature effect"
    )
    settle_energy: Annotated[
        float, UnitRange("J", at_least=10, at_most=1e9, because="pads of trains settle over 50 to 200 kJ")
    ] = Field(description="friction energy of one unit after which friction has settled")


class BrakeUnit(SourcedTable):
    """A unit of the friction brake: cylinder, rigging, and two pads on a disc or blocks on the tread."""

    pads: Name | None = Field(default=None, description="name of the pads in [pads]; tread brakes have blocks instead")
    blocks: Name | None = Field(default=None, description="name of the blocks in [blocks]")
    block_count: Annotated[StrictInt, Field(ge=1, le=64)] | None = Field(
        default=None, description="number of blocks of the unit, which share its force; needed with blocks"
    )
    friction_radius: PadRadius = Field(
        description="mean radius of the pads on the disc; the wheel radius for blocks on the tread"
    )
    piston_area: PistonArea = Field(description="area of the piston of the cylinder")
    rigging: Ratio = Field(description="ratio of the force of both pads, or of all blocks, to the force of the piston")
    efficiency: Efficiency = Field(description="efficiency of the rigging")
    spring_force: Spring = Field(description="force of slack adjuster and return spring at the piston")
    pressure_max: Pressure = Field(description="highest cylinder pressure")
    pad_friction: PadFriction | None = Field(
        default=None,
        description="nominal friction coefficient of the pads; without one for blocks it is that of their law",
    )

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if (self.pads is None) == (self.blocks is None):
            raise table_error("has pads and blocks, or neither: give pads = '…' (disc) or blocks = '…' (tread)")
        if (self.blocks is None) != (self.block_count is None):
            raise table_error("needs blocks and block_count together: the laws of blocks are over the force of one")
        if self.pads is not None and self.pad_friction is None:
            raise table_error("lacks pad_friction, the nominal friction of its pads")
        return self

    @property
    def full_force(self) -> float:
        """Force of both pads, or of all blocks, at the highest pressure [N]."""
        at_piston = max(self.pressure_max * self.piston_area - self.spring_force, 0.0)
        return self.efficiency * self.rigging * at_piston


class TrackBrake(SourcedTable):
    """The magnetic track brakes of a bogie: RailBraking.Components.MagneticTrackBrake."""

    is_dynamic: ClassVar[bool] = False
    instance: ClassVar[str] = "track_brake"
    speed_max: ClassVar[float] = 56.0
    """Speed above which the plant does not lower it [m/s], its v_max."""

    magnets: Annotated[StrictInt, Field(ge=1, le=8)] = Field(description="number of magnets on the bogie")
    attraction: Attraction = Field(description="force that attracts one magnet to the rail")
    friction_slow: Share = Field(description="friction coefficient at standstill")
    friction_fast: Share = Field(description="friction coefficient at high speed")
    friction_speed: TravelSpeed = Field(description="speed at which friction is halfway between the two")
    delay: WireDelay = Field(description="time from the demand until the magnets are on the rail")
    time_constant: LagTime = Field(description="time constant of the magnetic field")

    def force_at(self, speed: Any) -> Any:
        """Return the developed force at a speed [m/s] [N]; numbers, arrays or expressions."""
        friction = self.friction_fast + (self.friction_slow - self.friction_fast) / (1 + speed / self.friction_speed)
        return self.magnets * self.attraction * friction

    def largest(self) -> float:
        """Return the maximum force [N]."""
        return self.magnets * self.attraction * max(self.friction_slow, self.friction_fast)


Blending = Literal["valve", "train", "added"]


class _DynamicBrake(SourcedTable):
    """Keys of every dynamic brake, and what its kind states of itself."""

    is_dynamic: ClassVar[bool] = True

    force: Annotated[
        float,
        UnitRange("N", at_least=100, at_most=2e5, usual=(2e3, 6e4), because="axles brake with 5 to 40 kN electrically"),
    ] = Field(description="maximum force at the rim of an axle, or on the rail of all magnets of a bogie")
    speed_full: TravelSpeed = Field(description="speed at and above which the whole force is available")
    speed_end: Annotated[float, UnitRange("m/s", at_least=0, at_most=FASTEST)] = Field(
        description="speed at and below which no force is available; in between it fades out linearly"
    )
    time_constant: LagTime = Field(description="time constant of the force")

    @property
    @abstractmethod
    def speed_of_force(self) -> float:
        """Speed up to which, or at which, the force is at its maximum [m/s]."""

    def largest(self, units: float = 1.0, load: float = np.inf) -> float:  # pyright: ignore[reportUnusedParameter]
        """Return the maximum force of a number of brakes on axles with a static load [N]."""
        return units * self.force

    @model_validator(mode="after")
    def _fades_out(self) -> Self:
        if self.speed_end >= self.speed_full:
            raise table_error(
                f"has speed_end {3.6 * self.speed_end:g} km/h and speed_full {3.6 * self.speed_full:g} km/h; speed_end "
                "must be lower than speed_full"
            )
        return self

    def _fade(self, speed: Any) -> Any:
        # np.clip takes ten times as long for a number, and a stop by hand has ten thousands of them.
        return np.minimum(np.maximum((speed - self.speed_end) / (self.speed_full - self.speed_end), 0.0), 1.0)


class AxleBrake(_DynamicBrake):
    """Keys of dynamic brakes that need adhesion.

    A kind is a subclass in `DynamicBrake`, with a component in RailBraking.Components that has F_max, v_full, v_end, T
    and the parameters of its law.
    """

    component: ClassVar[str]

    blending: Blending = Field(
        description="valve: friction brakes of the same brake valve are relieved; train: those of the whole train, "
        "in equal parts; added: none"
    )
    slide_limit: Annotated[float, UnitRange("1", at_least=0.01, at_most=1, usual=(0.02, 0.3))] = Field(
        description="slip of an axle from which its dynamic brake is off for the rest of the stop"
    )

    @abstractmethod
    def law(self, units: float) -> str:
        """Return the parameters of the component's law for a number of brakes, in Modelica."""

    @abstractmethod
    def force_at(self, speed: Any, units: float = 1.0, load: float = np.inf) -> Any:
        """Return the force at a speed [m/s] of a number of brakes on axles with a static load [N]."""


class _EddyCurrent(_DynamicBrake):
    """Keys of eddy-current brakes."""

    speed_peak: TravelSpeed = Field(description="speed at which the force is at its maximum")

    @property
    def speed_of_force(self) -> float:
        """Speed at which the force is at its maximum [m/s]."""
        return self.speed_peak

    def force_at(self, speed: Any, units: float = 1.0, load: float = np.inf) -> Any:  # pyright: ignore[reportUnusedParameter]
        """Return the force at a speed [m/s] of a number of brakes together [N]; numbers or arrays."""
        return units * self.before_fade(speed) * self._fade(speed)

    def before_fade(self, speed: Any) -> Any:
        """Return the force of a brake without its fade-out at low speed [N]; numbers, arrays or expressions."""
        return self.force * (2 * self.speed_peak * speed / (self.speed_peak**2 + speed**2))


class Electrodynamic(AxleBrake):
    """Traction motors as generators: RailBraking.Components.ElectrodynamicBrake."""

    component: ClassVar[str] = "ElectrodynamicBrake"
    kind: Literal["electrodynamic"]
    power: Annotated[
        float,
        UnitRange("W", at_least=1e3, at_most=1e7, usual=(3e4, 2e6), because="axles brake with 50 kW to 1.6 MW"),
    ] = Field(description="maximum power at the rim of an axle: above power/force the force is power/speed")
    adhesion_limit: Annotated[float, UnitRange("1", at_least=0.02, at_most=0.5)] | None = Field(
        default=None, description="adhesion on the static load of its axles to which the force is limited"
    )

    @property
    def speed_of_force(self) -> float:
        """Speed above which the power limits the force [m/s]."""
        return self.power / self.force

    def law(self, units: float) -> str:
        """Return the parameters of the component's law for a number of brakes, in Modelica."""
        return f"P_max={units * self.power:.10g}"

    def largest(self, units: float = 1.0, load: float = np.inf) -> float:
        """Return the maximum force of a number of brakes on axles with a static load [N]."""
        return min(units * self.force, np.inf if self.adhesion_limit is None else self.adhesion_limit * load)

    def force_at(self, speed: Any, units: float = 1.0, load: float = np.inf) -> Any:
        """Return the force at a speed [m/s] of a number of brakes on axles with a static load [N]."""
        by_power = units * self.power / np.maximum(speed, 1e-3)
        return np.minimum(self.largest(units, load), by_power) * self._fade(speed)


class EddyCurrentAxle(_EddyCurrent, AxleBrake):
    """A rotating eddy-current brake on the discs of an axle: RailBraking.Components.EddyCurrentBrake."""

    component: ClassVar[str] = "EddyCurrentBrake"
    kind: Literal["eddy_current_axle"]

    def law(self, units: float) -> str:  # pyright: ignore[reportUnusedParameter]
        """Return the parameters of the component's law for a number of brakes, in Modelica."""
        return f"v_peak={self.speed_peak}"


class EddyCurrentRail(_EddyCurrent):
    """The linear eddy-current brake of a bogie, used in an emergency: RailBraking.Components.EddyCurrentBrake."""

    instance: ClassVar[str] = "eddy_current"
    delay: ClassVar[float] = 0.0
    speed_max: ClassVar[float] = np.inf
    kind: Literal["eddy_current_rail"]


DynamicBrake = Annotated[Electrodynamic | EddyCurrentAxle | EddyCurrentRail, Field(discriminator="kind")]
RailBrake = TrackBrake | EddyCurrentRail


class ParkingBrake(SourcedTable):
    """One unit of the parking brake of an axle: springs or a hand wheel, on pads or blocks."""

    force: PadForce = Field(description="force of both pads, or of all blocks, of the unit")
    friction: PadFriction = Field(description="static friction coefficient")
    friction_radius: PadRadius = Field(
        description="mean radius of the pads on the disc; the wheel radius for blocks on the tread"
    )
