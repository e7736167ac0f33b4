"""The brakes of a train file: tables of their data, and their forces by published laws.

Karwatzki's form of the laws of blocks on the tread is k1 (F + k2)/(F + k3) (v + k4)/(v + k5), with the force F of one
block. The law of eddy-current brakes is that of Wouterse (IEE Proceedings B 138, 1991), 2 F/(v/v1 + v1/v).
"""

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Final, Literal, Self

import numpy as np
from pydantic import Field, StrictBool, StrictInt

from railgrip.base import registry
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.table import FASTEST, Name, Table, by_kind, table_error


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
Ratio = Annotated[float, UnitRange("1", between=(0.1, 100), usual=(1, 15), because="riggings multiply by 2 to 10")]
Efficiency = Annotated[
    float, UnitRange("1", between=(0.1, 1), because="EN 14531-1 has efficiencies of 0.83 to 0.98 for riggings")
]
Share = Annotated[float, UnitRange("1", above=0, at_most=1)]
PadFriction = Annotated[
    float,
    UnitRange(
        "1",
        between=(0.02, 0.7),
        usual=(0.08, 0.5),
        because="blocks of cast iron have 0.08 to 0.2, organic and sintered pads 0.25 to 0.45 (EN 14531-1)",
    ),
]
Effect = Annotated[float, UnitRange("1", between=(-1, 1))]
PadRadius = Annotated[
    float,
    UnitRange("m", between=(0.02, 0.7), usual=(0.08, 0.65), because="pads and blocks act within the wheel"),
]
PistonArea = Annotated[
    float,
    UnitRange(
        "m2",
        between=(1e-4, 0.3),
        usual=(5e-4, 0.15),
        because="pistons have diameters of 30 mm (hydraulic) to 406 mm (16 in)",
    ),
]
Spring = Annotated[
    float,
    UnitRange(
        "N",
        between=(10, 3e4),
        or_zero=True,
        usual=(50, 8e3),
        because="springs of cylinders have 0.2 to 3 kN; 0 is none",
    ),
]
PadForce = Annotated[
    float,
    UnitRange("N", between=(100, 1e6), usual=(2e3, 2e5), because="pads are pressed by 5 kN to 100 kN"),
]
Attraction = Annotated[
    float,
    UnitRange(
        "N",
        between=(1e3, 1e6),
        usual=(2e4, 1.5e5),
        because="magnets of track brakes have attractive forces of about 40 kN to 100 kN",
    ),
]
Pressure = Annotated[
    float,
    UnitRange("Pa", between=(1e4, 3e7), because="brake cylinders have 2 to 6 bar of air, or up to 200 bar of oil"),
]
WireDelay = Annotated[
    float,
    UnitRange(
        "s",
        between=(1e-3, 1),
        or_zero=True,
        because="commands by wire take tenths of a second, and RailBraking.Pneumatics.DelayLine holds 1 s",
    ),
]
TravelSpeed = Annotated[
    float,
    UnitRange(
        "m/s", between=(0.1, FASTEST), usual=(0.1, 95.0), because="no train on wheels has been faster than 159.7 m/s"
    ),
]
Temperature = Annotated[
    float,
    UnitRange(
        "K",
        between=(200, 1300),
        usual=(250, 700),
        because="brakes work between 230 K and 1300 K; write '60 degC' for 60 °C",
    ),
]
TemperatureRange = Annotated[
    float, UnitRange("K", between=(1, 2e3), usual=(20, 800), difference=True, because="discs get 500 K hotter")
]
LagTime = Annotated[float, UnitRange("s", between=(1e-3, 60), usual=(0.02, 12), because="cylinders fill in 1 to 30 s")]


class SourcedTable(Table):
    """A table of numbers with their origin."""

    source: str = Field(default="", description="publication of these numbers")
    estimated: StrictBool | tuple[str, ...] = Field(
        default=False, description="true if all numbers are estimates, or the keys of those that are estimates"
    )

    def _check(self) -> None:
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


class Blocks(SourcedTable):
    """Friction of blocks on the tread by a published law of speed and block force: RailBraking.Friction.BlockFriction.

    The laws, with their sources, are in `LAWS`.
    """

    law: Literal["cast_iron_p6", "cast_iron_p10", "composite_k"] = Field(
        description="law by Karwatzki: cast iron P6 or P10, or composite K"
    )
    speed_nominal: TravelSpeed = Field(description="speed at which friction is nominal, with full force")
    settle_energy: Annotated[
        float, UnitRange("J", between=(10, 1e9), because="blocks and pads of trains settle over 50 to 200 kJ")
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
        float, UnitRange("J", between=(10, 1e9), because="pads of trains settle over 50 to 200 kJ")
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

    def _check(self) -> None:
        if (self.pads is None) == (self.blocks is None):
            raise table_error("has pads and blocks, or neither: give pads = '…' (disc) or blocks = '…' (tread)")
        if (self.blocks is None) != (self.block_count is None):
            raise table_error("needs blocks and block_count together: the laws of blocks are over the force of one")
        if self.pads is not None and self.pad_friction is None:
            raise table_error("lacks pad_friction, the nominal friction of its pads")

    @property
    def full_force(self) -> float:
        """Force of both pads, or of all blocks, at the highest pressure [N]."""
        at_piston = max(self.pressure_max * self.piston_area - self.spring_force, 0.0)
        return self.efficiency * self.rigging * at_piston


Within = Callable[[Any, Any, Any], Any]
"""Function that returns a value limited to its bounds: of numbers and arrays, or of expressions."""


def limit(value: Any, low: Any, high: Any) -> Any:
    """Return numbers or arrays limited to their bounds."""
    # np.clip takes ten times as long for a number, and a stop by hand has ten thousands of them.
    return np.minimum(np.maximum(value, low), high)


class DynamicBrake(SourcedTable):
    """A brake in [dynamic_brakes] of a train file.

    A kind is a subclass that is also an `AxleBrake` or a `RailBrake`, in a module with its name in
    `railgrip.rolling_stock.dynamic_brakes`, with a component in RailBraking.Components.
    """

    kind: Any  # each class has its name as a literal
    time_constant: LagTime = Field(description="time constant of the force")

    @property
    @abstractmethod
    def performance(self) -> str:
        """Its force over speed in words, for `railgrip train check`."""

    def doubts(self) -> Iterator[tuple[str, str]]:
        """Yield keys whose values contradict each other, with a sentence."""
        yield from ()


class FadingBrake(DynamicBrake):
    """Keys of dynamic brakes that fade out at low speed."""

    force: Annotated[
        float,
        UnitRange("N", between=(100, 2e5), usual=(2e3, 6e4), because="axles brake with 5 to 40 kN electrically"),
    ] = Field(description="maximum force at the rim of an axle, or on the rail of all magnets of a bogie")
    speed_full: TravelSpeed = Field(description="speed at and above which the whole force is available")
    speed_end: Annotated[float, UnitRange("m/s", between=(0, FASTEST))] = Field(
        description="speed at and below which no force is available; in between it fades out linearly"
    )

    @property
    @abstractmethod
    def speed_of_force(self) -> float:
        """Speed up to which, or at which, the force is at its maximum [m/s]."""

    @property
    def performance(self) -> str:
        """Its force over speed in words, for `railgrip train check`."""
        return (
            f"{self.force / 1e3:g} kN up to or at {3.6 * self.speed_of_force:.0f} km/h, off at "
            f"{3.6 * self.speed_end:g} km/h"
        )

    def doubts(self) -> Iterator[tuple[str, str]]:
        """Yield keys whose values contradict each other, with a sentence."""
        if self.speed_of_force < self.speed_full:
            words = f"is {3.6 * self.speed_full:g} km/h, but the force is {self.force / 1e3:g} kN up to or at "
            words += f"{3.6 * self.speed_of_force:.3g} km/h: the maximum force is never available"
            yield "speed_full", words

    def largest(self, units: float = 1.0, load: float = np.inf) -> float:  # pyright: ignore[reportUnusedParameter]
        """Return the maximum force of a number of brakes on axles with a static load [N]."""
        return units * self.force

    def _check(self) -> None:
        if self.speed_end >= self.speed_full:
            raise table_error(
                f"has speed_end {3.6 * self.speed_end:g} km/h and speed_full {3.6 * self.speed_full:g} km/h; speed_end "
                "must be lower than speed_full"
            )

    def fade(self, speed: Any, within: Within = limit) -> Any:
        """Return the share of the force that is available at a speed [m/s]."""
        return within((speed - self.speed_end) / (self.speed_full - self.speed_end), 0.0, 1.0)


Blending = Literal["valve", "train", "added"]


class AxleBrake(FadingBrake):
    """Keys of dynamic brakes that need adhesion.

    The component of a kind has F_max, v_full, v_end, T and the parameters of its law.
    """

    component: ClassVar[str]

    blending: Blending = Field(
        description="valve: friction brakes of the same brake valve are relieved; train: those of the whole train, "
        "in equal parts; added: none"
    )
    slide_limit: Annotated[float, UnitRange("1", between=(0.01, 1), usual=(0.02, 0.3))] = Field(
        description="slip of an axle from which its dynamic brake is off for the rest of the stop"
    )

    @abstractmethod
    def law(self, units: float) -> str:
        """Return the parameters of the component's law for a number of brakes, in Modelica."""

    @abstractmethod
    def force_at(self, speed: Any, units: float = 1.0, load: float = np.inf) -> Any:
        """Return the force at a speed [m/s] of a number of brakes on axles with a static load [N]."""


class RailBrake(SourcedTable):
    """A brake of a bogie that acts on the rail or in the air, in an emergency; it needs no adhesion.

    Unless a kind overrides `demand`, its component has inputs demand [N] and speed, and outputs available and force.
    """

    component: ClassVar[str]
    instance: ClassVar[str]
    """Name of its instances in a plant, before their number."""
    condition: ClassVar[Literal["emergency", "magnets"]] = "emergency"
    """Whether it acts in an emergency brake, or when a law lowers the magnets, too."""
    speed_max: ClassVar[float] = np.inf
    """Speed above which it is not switched on [m/s]."""

    time_constant: LagTime = Field(description="time constant of the force")

    @property
    def is_dynamic(self) -> bool:
        """Whether it is a dynamic brake, whose work is that of dynamic brakes."""
        return isinstance(self, DynamicBrake)

    @property
    def dead_time(self) -> float:
        """Time from the demand until the force begins to develop [s]."""
        return 0.0

    @property
    @abstractmethod
    def parameters(self) -> str:
        """Parameters of its component, in Modelica."""

    def demand(self, name: str, condition: str) -> str:
        """Return the equation of the input of an instance, which acts under a condition, in Modelica."""
        return f"{name}.demand = noEvent(if {condition} then {name}.available else 0)"

    @abstractmethod
    def force_at(self, speed: Any, *, within: Within = limit) -> Any:
        """Return the developed force at a speed [m/s] [N]; `within` limits values, for speeds that are expressions."""

    @abstractmethod
    def largest(self) -> float:
        """Return the maximum force [N]."""

    def force_after(self, time: Any, speed: Any) -> Any:
        """Return the force [N] a time after the demand [s] at a speed [m/s]; numbers or arrays."""
        developed = -np.expm1(-np.maximum(time - self.dead_time, 0.0) / self.time_constant)
        return developed * (speed <= self.speed_max) * self.force_at(speed)

    # A filter has the dynamics of the component; the lag of most of them is that of the force.
    def lag_input(self, command: Any, full: Any) -> Any:
        """Return the input of the component's lag, for a command, 0 or 1, and the developed force [N]."""
        return command * full

    def force_of_lag(self, lagged: Any, full: Any, *, within: Within = limit) -> Any:
        """Return the force [N] for the output of the component's lag and the developed force [N]."""
        return within(lagged, 0.0, full)


class TrackBrake(RailBrake):
    """The magnetic track brakes of a bogie: RailBraking.Components.MagneticTrackBrake."""

    component: ClassVar[str] = "MagneticTrackBrake"
    instance: ClassVar[str] = "track_brake"
    condition: ClassVar[Literal["emergency", "magnets"]] = "magnets"
    speed_max: ClassVar[float] = 56.0
    """Speed above which the plant does not lower it [m/s], its v_max."""

    magnets: Annotated[StrictInt, Field(ge=1, le=8)] = Field(description="number of magnets on the bogie")
    attraction: Attraction = Field(description="force that attracts one magnet to the rail")
    friction_slow: Share = Field(description="friction coefficient at standstill")
    friction_fast: Share = Field(description="friction coefficient at high speed")
    friction_speed: TravelSpeed = Field(description="speed at which friction is halfway between the two")
    delay: WireDelay = Field(description="time from the demand until the magnets are on the rail")
    time_constant: LagTime = Field(description="time constant of the magnetic field")

    @property
    def dead_time(self) -> float:
        """Time from the demand until the force begins to develop [s]."""
        return self.delay

    @property
    def parameters(self) -> str:
        """Parameters of its component, in Modelica."""
        return (
            f"n_magnets={self.magnets}, F_attraction={self.attraction}, mu_stand={self.friction_slow},\n"
            f"    mu_fast={self.friction_fast}, v_friction={self.friction_speed}, final delay={self.delay},\n"
            f"    T={self.time_constant}"
        )

    def demand(self, name: str, condition: str) -> str:
        """Return the equation of the input of an instance, which acts under a condition, in Modelica."""
        return f"{name}.command = noEvent(if {condition} then 1 else 0)"

    def force_at(self, speed: Any, *, within: Within = limit) -> Any:  # pyright: ignore[reportUnusedParameter]
        """Return the developed force at a speed [m/s] [N]; numbers, arrays or expressions."""
        friction = self.friction_fast + (self.friction_slow - self.friction_fast) / (1 + speed / self.friction_speed)
        return self.magnets * self.attraction * friction

    def largest(self) -> float:
        """Return the maximum force [N]."""
        return self.magnets * self.attraction * max(self.friction_slow, self.friction_fast)

    # Its lag is that of the magnetic field, a share of the full one.
    def lag_input(self, command: Any, full: Any) -> Any:  # pyright: ignore[reportUnusedParameter]
        """Return the input of the component's lag, for a command, 0 or 1, and the developed force [N]."""
        return command

    def force_of_lag(self, lagged: Any, full: Any, *, within: Within = limit) -> Any:  # pyright: ignore[reportUnusedParameter]
        """Return the force [N] for the output of the component's lag and the developed force [N]."""
        return lagged * full


class EddyCurrent(FadingBrake):
    """Keys of eddy-current brakes."""

    component: ClassVar[str] = "EddyCurrentBrake"

    speed_peak: TravelSpeed = Field(description="speed at which the force is at its maximum")

    @property
    def speed_of_force(self) -> float:
        """Speed at which the force is at its maximum [m/s]."""
        return self.speed_peak

    def force_of(self, units: float, speed: Any, within: Within = limit) -> Any:
        """Return the force of a number of brakes at a speed [m/s] [N]; numbers, arrays or expressions."""
        of_one = self.force * (2 * self.speed_peak * speed / (self.speed_peak**2 + speed**2))
        return units * of_one * self.fade(speed, within)


def kinds_of_dynamic_brakes() -> dict[str, type[Table]]:
    """Return kind → table of all dynamic brakes."""
    brakes = (kind for base in (AxleBrake, RailBrake) for kind in registry.parts(registry.DYNAMIC_BRAKES, base))
    return by_kind(*brakes)


class ParkingBrake(SourcedTable):
    """One unit of the parking brake of an axle: springs or a hand wheel, on pads or blocks."""

    force: PadForce = Field(description="force of both pads, or of all blocks, of the unit")
    friction: PadFriction = Field(description="static friction coefficient")
    friction_radius: PadRadius = Field(
        description="mean radius of the pads on the disc; the wheel radius for blocks on the tread"
    )
