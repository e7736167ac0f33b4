"""The table [track] and the force it puts on the train: gradient and curves along the distance."""

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from harness.scenario.quantity import Unit
from harness.scenario.table import Length, Table, broken

GRAVITY = 9.81  # m/s2

# Curve resistance of the DLR test campaign: f = κ (0.158 a + 0.033 b), a wheelbase, b gauge (mean of the
# three bogies).
_WHEELBASE = (1.9 + 2.65 + 1.9) / 3  # m
_GAUGE = 1.435  # m


class Gradient(Table):
    """From here on the track climbs by `slope` (falls where negative)."""

    begin: Length
    slope: Annotated[float, Unit("1", above=-0.2, below=0.2)]


class Curve(Table):
    """From here on the track has this radius, either way; `radius = 0` is straight again."""

    begin: Length
    radius: Length


class Track(Table):
    """What acts on the train besides brakes and resistance."""

    force: Annotated[float, Unit("N")] = Field(default=0.0, description="constant force, forward positive")
    gradient: tuple[Gradient, ...] = ()
    curve: tuple[Curve, ...] = ()
    curve_law: Literal["bogie", "roeckl"] = Field(
        default="bogie", description="curve resistance: κ(0.158 a + 0.033 b), or Röckl 650/(R − 55) ‰"
    )
    train_mass: Annotated[float, Unit("kg", above=0)] | None = Field(
        default=None, description="mass that gradient and curves act on; wanted with either"
    )

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
    weight = (track.train_mass or 0.0) * GRAVITY

    def force(place: float) -> float:
        slopes = [section.slope for section in track.gradient if section.begin <= place]
        curves = [section for section in track.curve if section.begin <= place]
        # slope is tan(β), a gradient as railways give it; sin(β) = t/√(1 + t²).
        climb = slopes[-1] / (1 + slopes[-1] ** 2) ** 0.5 if slopes else 0.0
        bend = _curve_coefficient(curves[-1], track.curve_law) if curves else 0.0
        return track.force - weight * (climb + bend)

    return TrackForce(begins=begins, forces=tuple(force(place) for place in begins))


def _curve_coefficient(curve: Curve, law: str) -> float:
    """Return curve resistance over weight.

    Source: "bogie" Schwarz et al., estimation of adhesion conditions; "roeckl" Röckl, 650/(R − 55) ‰ for R ≥
    300 m.
    """
    if curve.radius == 0:
        return 0.0
    if law == "roeckl":
        return 0.650 / (curve.radius - 55)
    return (0.158 * _WHEELBASE + 0.033 * _GAUGE) / curve.radius
