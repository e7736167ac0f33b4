"""The table [track] and the force it puts on the train: gradient and curves along the distance."""

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, field_validator, model_validator

from railgrip.scenario.quantity import Unit
from railgrip.scenario.table import Length, Table, broken

GRAVITY = 9.81  # m/s2

_WHEELBASE = (1.9 + 2.65 + 1.9) / 3  # m, mean of the three bogies of the VT 642
_GAUGE = 1.435  # m

LARGEST_FORCE = 1e6
"""N. The draw gear between vehicles breaks at 0.85 to 1 MN (UIC 520): no track holds or pushes a train by more."""
TIGHTEST_RADIUS = 10.0
"""m. The tightest curves that trams run through have 11 m, those of railways 70 m and more."""
STEEPEST = 0.2
"""The steepest gradient; adhesion railways end below 14 %."""

CurveLaw = Literal["bogie", "roeckl", "protopapadakis"]


class Gradient(Table):
    """From here on the track climbs by `slope` (falls where negative)."""

    begin: Length
    slope: Annotated[float, Unit("1", above=-STEEPEST, below=STEEPEST)]


class Curve(Table):
    """From here on the track has this radius, either way; `radius = 0` is straight again."""

    begin: Length
    radius: Length

    @field_validator("radius")
    @classmethod
    def _straight_or_a_curve(cls, radius: float) -> float:
        if 0 < radius < TIGHTEST_RADIUS:
            raise broken(f"must be 0, for straight track, or at least {TIGHTEST_RADIUS:g} m, got {radius:g} m")
        return radius


class Track(Table):
    """What acts on the train besides brakes and resistance."""

    force: Annotated[float, Unit("N", at_least=-LARGEST_FORCE, at_most=LARGEST_FORCE)] = Field(
        default=0.0, description="constant force, forward positive"
    )
    gradient: tuple[Gradient, ...] = ()
    curve: tuple[Curve, ...] = ()
    curve_law: CurveLaw = Field(
        default="bogie",
        description="curve resistance: κ(0.158 a + 0.033 b), Röckl 650/(R − 55) ‰, or Protopapadakis "
        "κ(0.158 b + 0.103 a)",
    )
    train_mass: (
        Annotated[float, Unit("kg", above=0, at_most=1e8, because="the heaviest train weighed 1e8 kg")] | None
    ) = Field(default=None, description="mass that gradient and curves act on; wanted with either")

    @model_validator(mode="after")
    def _mass_and_order(self) -> Self:
        if (self.gradient or self.curve) and self.train_mass is None:
            raise broken("has gradient or curve but no train_mass, which turns them into a force")
        for name, sections in (("gradient", self.gradient), ("curve", self.curve)):
            begins = [section.begin for section in sections]
            if begins != sorted(set(begins)):
                raise broken(f"{name} must begin at rising distances, got {begins}")
        tightest = min((section.radius for section in self.curve if section.radius), default=math.inf)
        if self.curve_law == "roeckl" and tightest < 300:
            raise broken(f"curve_law 'roeckl' holds for a radius of 300 m and more, got {tightest:g} m")
        return self


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackForce:
    """A force that is constant between places.

    Attributes:
        begins: Where each section begins, rising, the first at −∞ [m].
        forces: On the train in each section, forward positive [N].
    """

    begins: tuple[float, ...]
    forces: tuple[float, ...]

    def at(self, distance: float) -> float:
        """Return the force [N] with the train at `distance` [m] since the brake demand."""
        return self.forces[bisect_right(self.begins, distance) - 1]


def track_force_of(track: Track) -> TrackForce:
    """Return the force of a track: the constant one, −m g sin(β) and the curve resistance."""
    places = sorted({section.begin for section in (*track.gradient, *track.curve)})
    begins = (float("-inf"), *places)

    def force(place: float) -> float:
        slopes = [section.slope for section in track.gradient if section.begin <= place]
        curves = [section.radius for section in track.curve if section.begin <= place]
        bend = 1.0 / curves[-1] if curves and curves[-1] else 0.0
        return track.force + float(
            force_along(slopes[-1] if slopes else 0.0, bend, track.train_mass or 0.0, track.curve_law)
        )

    return TrackForce(begins=begins, forces=tuple(force(place) for place in begins))


def force_along(slope: ArrayLike, curvature: ArrayLike, mass: float, law: CurveLaw = "bogie") -> NDArray[np.float64]:
    """Return the force of gradient and curve on a train [N], forward positive, like the shape of slope and curvature.

    −m g (sin β + f): equations (7) and (9) of Schwarz, Lüdicke and Heckmann.

    Args:
        slope: tan β, a gradient as railways give it, positive uphill.
        curvature: 1/R [1/m], of either sign.
        mass: Of the train [kg].
        law: Of the curve resistance, see `curve_coefficient`.
    """
    climb = np.asarray(slope, dtype=np.float64)
    return -mass * GRAVITY * (climb / np.sqrt(1.0 + climb**2) + curve_coefficient(curvature, law))


def curve_coefficient(curvature: ArrayLike, law: CurveLaw) -> NDArray[np.float64]:
    """Return curve resistance over weight, f ≥ 0, at a curvature κ = 1/R [1/m] of either sign.

    `bogie`: κ(0.158 a + 0.033 b), a wheelbase, b gauge, as Schwarz, Lüdicke and Heckmann print it in their equation
    (7). `protopapadakis`: κ(0.158 b + 0.103 a), the formula that theirs resembles, for a friction of 0.22.
    `roeckl`: 650/(R − 55) ‰, held beyond its range of R ≥ 300 m at its value there.
    """
    bend = np.abs(np.asarray(curvature, dtype=np.float64))
    if law == "roeckl":
        within = np.minimum(bend, 1.0 / 300.0)
        return 0.650 * within / (1.0 - 55.0 * within)
    if law == "protopapadakis":
        return (0.158 * _GAUGE + 0.103 * _WHEELBASE) * bend
    return (0.158 * _WHEELBASE + 0.033 * _GAUGE) * bend
