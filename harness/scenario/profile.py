"""The table [adhesion]: the kinds of friction profile that a scenario may have."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from railgrip.base import registry
from railgrip.base.arrays import Array
from railgrip.scenario.curve import Direction, TabulatedQuantity, along, direction_of, read_curve
from railgrip.scenario.file import NamedFile
from railgrip.scenario.quantity import Magnitude, UnitRange
from railgrip.scenario.surface import Polach, Recovery, Sand
from railgrip.scenario.table import ONE_OR_EACH, Chainage, Friction, Length, Table, not_in, optional, table_error


class Conditioning(Table):
    """Each wheelset or group cleans the rail for the next by rolling: closes `fraction` of the gap to `recovered`.

    With a recovery, slip cleans what is left: it starts from the friction that a wheelset meets.
    """

    fraction: Annotated[
        float,
        UnitRange(
            "1",
            at_least=0,
            below=1,
            or_zero=True,
            usual=(0.01, 0.9),
            because="a wheel neither leaves the rail as it is nor cleans it at once",
        ),
    ] = Field(description="of the gap that each one closes")
    recovered: Friction = Field(description="maximum friction of the clean rail; where friction is higher it stays")
    by: Literal["group", "wheelset"] = Field(description="who cleans for the next")


Over = Literal["time", "distance"]

_FARTHEST = 1e5  # s or m

LONGEST_RAIL = 20e3
"""Reach of tabulated friction over distance [m]: full braking from 500 km/h takes half of it, the table 200 MB."""


class Extent(Magnitude):
    """A length or a duration, depending on `over`."""


Frictions = Annotated[tuple[Friction, ...], ONE_OR_EACH]


class Patch(Table):
    """A section of the rail with other friction, such as leaves, oil or sand."""

    begin: Length = Field(description="distance of the first wheelset at which it gets there")
    length: Length = Field(description="of the place along the rail")
    mu0: Frictions = Field(
        description="one number for the whole train, or one for each wheelset: the first ones may clean the rail"
    )
    edge: Length = Field(default=0.0, description="over which friction changes at either end, inside the patch")
    polach: Polach | None = optional("creep curve of the place from the middle of its edges on; as around it without")


class _Profile(Table):
    """Keys of all profiles."""

    polach: Polach = Field(description="shape of the creep curve: the name of a set, such as dry, or its numbers")
    polach_of_wheelset: tuple[Polach, ...] = optional(
        "creep curve that each wheelset meets outside of patches, in place of polach: the first may clean the rail",
        default=(),
    )
    level: Annotated[
        float, UnitRange("1", above=0, at_most=100, usual=(0.2, 5.0), because="it scales a friction of at most 1")
    ] = Field(default=1.0, description="factor on the first wheelset's friction")
    calibrated: dict[str, Annotated[float, UnitRange("1", above=0, at_most=100)]] = Field(
        default={},
        description="a further factor for named Polach sets, written by the calibration; 1 for a set that is not named",
    )
    conditioning: Conditioning | None = Field(
        default=None, description="how wheels that pass clean the rail for those behind"
    )
    recovery: Recovery | None = optional("how slip cleans the rail; that of polach without it")
    sand: Sand | None = optional("effect of sand on friction; required with [[sanders]]")
    patch: tuple[Patch, ...] = optional("places of other friction, of a profile over distance", default=())

    def _check(self) -> None:
        known = {*registry.files(registry.CREEP_CURVES), *(curve.name for curve in self.curves)}
        if unknown := sorted(self.calibrated.keys() - known):
            raise table_error(f"calibrated has a factor for {not_in(sorted(known), unknown[0])}")
        if self.conditioning is not None and len(set(getattr(self, "mu0", ()))) > 1:
            raise table_error("gives mu0 for each wheelset and conditioning, which makes it from the first's; keep one")
        if len({(curve.temperature_loss, curve.recovery) for curve in self.curves}) > 1:
            raise table_error(
                "has creep curves of different temperature_loss or recovery, which are one for the whole rail; "
                "give all curves the same"
            )

    @property
    def cleaning(self) -> Recovery | None:
        """The law by which slip cleans the rail: its own, else that of the creep curve; None if slip does not."""
        return self.recovery or self.polach.recovery

    @property
    def curves(self) -> tuple[Polach, ...]:
        """All creep curves of the rail, without repetition, starting with that of `polach`."""
        of_places = (patch.polach for patch in self.patch if patch.polach is not None)
        return tuple(dict.fromkeys((self.polach, *self.polach_of_wheelset, *of_places)))

    @property
    def lowest(self) -> float:
        """Lower bound of the maximum friction anywhere on the rail, patches included."""
        return min([self.factor * self._lowest_around, *(mu0 for patch in self.patch for mu0 in patch.mu0)])

    @property
    def _lowest_around(self) -> float:
        raise NotImplementedError

    @property
    def factor(self) -> float:
        """Factor on the first wheelset's friction: the level, times what the calibration found for this shape."""
        return self.level * self.calibrated.get(self.polach.name, 1.0)


class Constant(_Profile):
    """The same friction everywhere, for the train or for each wheelset, except for patches of the rail."""

    kind: Literal["constant"]
    mu0: Frictions = Field(description="one number for the whole train, or one for each wheelset")

    @property
    def over(self) -> Over:
        """The axis of the friction: the distance if there are patches."""
        return "distance" if self.patch else "time"

    @property
    def _lowest_around(self) -> float:
        return min(self.mu0)


class Leaves(_Profile):
    """A rail with patches of leaves at random places; drawn from the seed.

    Patches begin independently of each other: their number in a stretch of rail has a Poisson distribution. Length and
    friction of each are uniform within their limits. Where patches overlap, the one that begins later covers the other.
    """

    kind: Literal["leaves"]
    mu0: Frictions = Field(description="maximum friction between patches, for the train or for each wheelset")
    count: Annotated[float, UnitRange("1/m", above=0, at_most=1, because="patches are metres long")] = Field(
        description="mean number of patches that begin in a length of rail, as 8 1/km"
    )
    shortest: Length = Field(description="minimum length of a patch")
    longest: Length = Field(description="maximum length of a patch")
    minimum: Friction = Field(description="minimum of the maximum friction in a patch")
    maximum: Friction = Field(description="maximum of the maximum friction in a patch")
    edge: Length = Field(default=0.0, description="over which friction changes at either end, inside a patch")
    polach_of_patches: Polach | None = optional("creep curve in patches, as in patch; polach without it")

    @property
    def over(self) -> Over:
        """The axis of the friction; patches have places."""
        return "distance"

    @property
    def _lowest_around(self) -> float:
        return min(*self.mu0, self.minimum)

    @property
    def curves(self) -> tuple[Polach, ...]:
        """All creep curves of the rail, without repetition, starting with that of `polach`."""
        of_patches = () if self.polach_of_patches is None else (self.polach_of_patches,)
        first, *others = super().curves
        return tuple(dict.fromkeys((first, *of_patches, *others)))

    def _check(self) -> None:
        for low, high in (("shortest", "longest"), ("minimum", "maximum")):
            if getattr(self, low) > getattr(self, high):
                raise table_error(f"{low} {getattr(self, low):g} is above {high} {getattr(self, high):g}")
        if self.longest <= 0:
            raise table_error("longest must be above 0 m, got 0")


class _Varying(_Profile):
    """A profile along time (every wheelset at once) or along the track (each wheelset when it gets there)."""

    over: Over = Field(description="time since the brake demand, or position on the track")

    @property
    def unit(self) -> str:
        """Unit of the axis of the profile."""
        return "s" if self.over == "time" else "m"

    def extent(self, name: str) -> float:
        """Return a length or duration of this table in the unit of its axis."""
        return self._si(name, getattr(self, name), self.unit)

    def _si(self, name: str, magnitude: Magnitude, unit: str) -> float:
        try:
            return magnitude.si(unit)
        except ValueError as problem:
            raise table_error(f"{name} {problem} (the profile runs over {self.over})") from problem

    def _check_extents(self, *names: str, zero: tuple[str, ...] = ()) -> None:
        for name in names:
            value = self.extent(name)
            if value < 0 or (value == 0 and name not in zero):
                raise table_error(
                    f"{name} must be {'at least' if name in zero else 'above'} 0 {self.unit}, got {value:g}"
                )
            if value > _FARTHEST:
                raise table_error(
                    f"{name} must be at most {_FARTHEST:g} {self.unit}, got {value:g}; no braking is longer"
                )


class Trapezoid(_Varying):
    """Repeated trapezoids: high, ramp down, low, ramp up; starting high."""

    kind: Literal["trapezoid"]
    minimum: Friction = Field(description="maximum friction of the low stretches")
    maximum: Friction = Field(description="maximum friction of the high stretches")
    first_fall: Extent = Field(description="where the first ramp down begins")
    period: Extent = Field(description="from one ramp down to the next")
    low: Extent = Field(description="length of the low stretch between the ramps")
    ramp: Extent = Field(description="length of each ramp")

    @property
    def _lowest_around(self) -> float:
        return self.minimum

    def _check(self) -> None:
        self._check_extents("first_fall", "period", "low", "ramp", zero=("first_fall", "low"))
        if self.minimum > self.maximum:
            raise table_error(f"minimum {self.minimum:g} is above maximum {self.maximum:g}")
        width = self.extent("low") + 2 * self.extent("ramp")
        if width > self.extent("period"):
            raise table_error(
                f"low and two ramps take {width:g} {self.unit}, longer than period {self.extent('period'):g}"
            )


class SineSweep(_Varying):
    """A sine whose frequency changes from start to end evenly on a logarithmic scale, then is constant.

    Frequencies are in 1/s over time, in 1/m over distance.
    """

    kind: Literal["sine_sweep"]
    mean: Friction = Field(description="of the maximum friction")
    amplitude: Friction = Field(description="of the maximum friction about its mean; it begins with a fall")
    start_frequency: Extent = Field(description="at the begin [1/s or 1/m]")
    end_frequency: Extent = Field(description="from the end of the sweep on [1/s or 1/m]")
    sweep: Extent = Field(description="over which the frequency goes from start to end")

    @property
    def _lowest_around(self) -> float:
        return self.mean - self.amplitude

    @property
    def frequencies(self) -> tuple[float, float]:
        """Start and end frequency in 1/s or 1/m."""
        unit = "Hz" if self.over == "time" else "1/m"
        return self._si("frequency", self.start_frequency, unit), self._si("frequency", self.end_frequency, unit)

    def _check(self) -> None:
        self._check_extents("sweep")
        if min(self.frequencies) <= 0:
            raise table_error(f"frequencies must be above 0, got {self.frequencies}")
        if self.amplitude >= self.mean:
            raise table_error(f"amplitude {self.amplitude:g} reaches mean {self.mean:g}: friction must stay above 0")


class Random(_Varying):
    """Noise of autocorrelation e^(−|d|/correlation) (Ornstein–Uhlenbeck), clipped; drawn from the seed."""

    kind: Literal["random"]
    mean: Friction = Field(description="of the maximum friction")
    deviation: Annotated[float, UnitRange("1", at_least=0, below=1)] = Field(description="1σ of the maximum friction")
    correlation: Extent = Field(description="over which the autocorrelation falls to 1/e")
    minimum: Friction = Field(description="lower friction is cut off here")
    maximum: Friction = Field(description="higher friction is cut off here")

    @property
    def _lowest_around(self) -> float:
        return self.minimum

    def _check(self) -> None:
        self._check_extents("correlation")
        if not self.minimum <= self.mean <= self.maximum:
            raise table_error(
                f"mean {self.mean:g} is not between minimum {self.minimum:g} and maximum {self.maximum:g}"
            )


_ORIGIN = (
    "chainage of the leading wheelset at the brake demand, of a profile over distance whose places are chainages; they "
    "rise or fall in the direction of travel"
)


class Points(_Varying):
    """Linear between points, constant beyond them; optionally with scatter of a relative standard deviation.

    The scatter is a Gauss–Markov process of autocorrelation e^(−|d|/correlation), cut off at three deviations; drawn
    from the seed.
    """

    kind: Literal["points"]
    points: tuple[tuple[Extent, Friction], ...] = Field(min_length=1, description="time or distance, and mu0 there")
    origin: Chainage | None = optional(_ORIGIN)
    scatter: Annotated[float, UnitRange("1", at_least=0, below=0.3)] = Field(default=0.0, description="1σ over mu0")
    correlation: Extent | None = Field(default=None, description="correlation length of the scatter; required with it")

    @property
    def _lowest_around(self) -> float:
        return min(mu0 for _, mu0 in self.points) * (1.0 - 3.0 * self.scatter)

    @property
    def direction(self) -> Direction | None:
        """Direction of the chainages in the direction of travel; None if there is one point."""
        return direction_of(self._axis) if len(self.points) > 1 else None

    @property
    def places(self) -> tuple[float, ...]:
        """Times or distances of the points since the brake demand, in the unit of the axis."""
        return tuple((self._axis if self.origin is None else along(self._axis, self.origin)).tolist())

    @property
    def _axis(self) -> Array:
        return np.array([self._si("points", place, self.unit) for place, _ in self.points])

    def _check(self) -> None:
        places = self.places
        if self.origin is not None and self.over == "time":
            raise table_error("has an origin, which is a place on the rail, and runs over time; leave origin out")
        if list(places) != sorted(set(places)) or (self.origin is None and places[0] < 0):
            raise table_error(
                f"points must begin with rising values from 0 on, got {list(places)}; for chainages give origin"
            )
        if self.correlation is not None:
            self._check_extents("correlation")
        elif self.scatter:
            raise table_error("has scatter and no correlation, over which that changes")


class FromTable(_Profile):
    """A user's curve: a CSV with columns time or distance, and mu0 or mu0_1 … mu0_n."""

    kind: Literal["table"]
    file: NamedFile = Field(
        description="CSV with columns time or distance, and mu0 or mu0_1 … mu0_n; in s and m, or in stated units"
    )

    origin: Chainage | None = optional(_ORIGIN)

    def _check(self) -> None:
        curve = self.curve
        if curve.values.shape[1] > 1 and self.conditioning is not None:
            raise table_error(
                f"{self.file.entry} gives mu0 for each wheelset, and conditioning makes it from the first's"
            )

    @property
    def _lowest_around(self) -> float:
        return float(self.curve.values.min())

    @property
    def curve(self) -> TabulatedQuantity:
        """The content of the file."""
        return self.file.read(lambda path: read_curve(path, self.origin))

    @property
    def direction(self) -> Direction:
        """Direction of the chainages in the direction of travel."""
        return self.curve.direction

    @property
    def over(self) -> Over:
        """The axis by the file's first column."""
        return "time" if self.curve.axis == "time" else "distance"


Adhesion = Annotated[
    Constant | Points | Trapezoid | SineSweep | Random | Leaves | FromTable, Field(discriminator="kind")
]
