"""The table [track] and its force on the train: gradient and curves along the distance."""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, field_validator

from railgrip.base.units import GRAVITY
from railgrip.scenario.curve import Direction, LineProfile, read_line
from railgrip.scenario.file import NamedFile
from railgrip.scenario.quantity import Number, UnitRange
from railgrip.scenario.table import Chainage, Length, Table, optional, table_error

if TYPE_CHECKING:
    from railgrip.scenario.track_geometry import TrackAlignment

_WHEELBASE = (1.9 + 2.65 + 1.9) / 3  # m, mean of the three bogies of the VT 642
_GAUGE = 1.435  # m

LARGEST_FORCE = 1e6
"""N. The draw gear between vehicles breaks at 0.85 to 1 MN (UIC 520), which bounds the force of a track on a train."""
TIGHTEST_RADIUS = 10.0
"""m. The tightest curves of trams have 11 m, those of railways 70 m and more."""
STEEPEST = 0.2
"""The steepest gradient; adhesion railways stay below 14 %."""

CurveLaw = Literal["bogie", "roeckl", "protopapadakis"]

Slope = Annotated[
    float,
    UnitRange(
        "1",
        above=-STEEPEST,
        below=STEEPEST,
        usual=(-0.04, 0.04),
        because="main lines stay below 35 permille (INF TSI, 4.2.3.3)",
    ),
]


class Gradient(Table):
    """From here on the track climbs by `slope` (falls where negative)."""

    begin: Length = Field(description="distance of the train at which it begins")
    slope: Slope = Field(description="tangent of the gradient, positive uphill")


Bend = Annotated[float, UnitRange("m", between=(-1e5, 1e5), because="no track is surveyed to less than 1e-5 1/m")]


class Curve(Table):
    """From here on the track has this radius, in either direction; `radius = 0` is straight again."""

    begin: Length = Field(description="distance of the train at which it begins")
    radius: Bend = Field(description="of the curve, either way and of either sign; 0 is straight")

    @field_validator("radius")
    @classmethod
    def _straight_or_a_curve(cls, radius: float) -> float:
        if 0 < abs(radius) < TIGHTEST_RADIUS:
            raise table_error(f"must be 0, for straight track, or at least {TIGHTEST_RADIUS:g} m, got {radius:g} m")
        return abs(radius)

    @property
    def curvature(self) -> float:
        """1 over the radius [1/m], 0 where it is straight."""
        return 1.0 / self.radius if self.radius else 0.0


class Plan(Table):
    """[track.plan]: a track as built, in the direction of its distance, and the position of the run on it."""

    latitude: Annotated[Number, Field(ge=-89.0, le=89.0)] = Field(description="of the point `middle` [deg]")
    longitude: Annotated[Number, Field(ge=-180.0, le=180.0)] = Field(description="of the point `middle` [deg]")
    height: Annotated[float, UnitRange("m", between=(-500, 6000), because="no railway is higher")] = Field(
        description="of the point `middle` above the ellipsoid"
    )
    middle: Length = Field(description="distance of the point whose position is given")
    heading: Annotated[float, UnitRange("rad", between=(-7, 7))] = Field(description="there, clockwise from north")
    course: tuple[tuple[Length, Bend], ...] = Field(
        min_length=1,
        description="length of each piece and the radius at its end: 0 is straight, positive to the right; the "
        "curvature changes evenly from that of the piece before",
    )
    slope: Slope = Field(description="at the beginning, positive uphill")
    grades: tuple[tuple[Length, Slope, Length], ...] = Field(
        default=(), description="intersection of two tangents, slope behind it, radius of the rounding"
    )
    start: Length = Field(description="distance at which the train is when the run begins")
    direction: Literal["forward", "backward"] = Field(description="of travel along the distance of the plan")

    def _check(self) -> None:
        if any(0 < abs(radius) < TIGHTEST_RADIUS for _, radius in self.course):
            raise table_error(
                f"course: a radius is 0, for straight track, or at least {TIGHTEST_RADIUS:g} m either way"
            )
        try:
            course = self.alignment()
        except ValueError as problem:
            raise table_error(f"grades: {problem}") from problem
        if self.start > course.length:
            raise table_error(f"start {self.start:g} m is beyond the end of the track, {course.length:g} m")

    def alignment(self) -> "TrackAlignment":
        """Return the alignment of the track."""
        # Imported here, because most scenarios have no plan.
        from railgrip.scenario.track_geometry import Place, TrackAlignment, course_of, grades_of

        return TrackAlignment(
            origin=Place(latitude=self.latitude, longitude=self.longitude, height=self.height),
            middle=self.middle,
            length=math.fsum(long for long, _ in self.course),
            heading=self.heading,
            curvature=course_of([(long, 1.0 / end if end else 0.0) for long, end in self.course]),
            slope=grades_of(self.slope, self.grades),
        )

    def place(self, distance: ArrayLike) -> NDArray[np.float64]:
        """Return the position on the plan [m] of a train that has covered some distances [m]."""
        return self.start + self.way * np.asarray(distance, dtype=np.float64)

    @property
    def way(self) -> float:
        """1 in the direction of the plan, -1 against it."""
        return 1.0 if self.direction == "forward" else -1.0


class TrackLine(Table):
    """[track.line]: the gradients of a line from a file, and the place of the run on it."""

    file: NamedFile = Field(
        description="CSV with columns distance (chainage) and slope or height, in m and 1, or in stated units; or a "
        "GPX track, whose chainage counts from its first point"
    )
    origin: Chainage = Field(description="chainage of the leading wheelset at the start of the run")
    direction: Direction = Field(description="of the chainages in the direction of travel")

    def _check(self) -> None:
        first, last = self.ends
        if not first <= 0.0 < last:
            low, high = sorted(self.origin + self.way * end for end in (first, last))
            raise table_error(
                f"origin {self.origin:g} m in direction '{self.direction}' does not lie on {self.file.entry}, or at "
                f"its end: the line is from {low:g} m to {high:g} m"
            )

    @property
    def is_gpx(self) -> bool:
        """Whether chainages count from the first point of a GPX track, and not as on the line."""
        return self.file.path.suffix.casefold() == ".gpx"

    @property
    def way(self) -> float:
        """1 if the train runs to higher chainages, -1 otherwise."""
        return 1.0 if self.direction == "rising" else -1.0

    @cached_property
    def sections(self) -> tuple[tuple[float, float], ...]:
        """Begin of each section as the distance of the train [m], and its slope in the direction of travel."""
        order = slice(None, None, round(self.way))
        begins = (self.way * (self._profile.chainages - self.origin))[order][:-1]
        return tuple(zip(begins.tolist(), (self.way * self._profile.slopes)[order].tolist(), strict=True))

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the line as distances of the train [m]."""
        first, last = sorted((self._profile.chainages[[0, -1]] - self.origin) * self.way)
        return float(first), float(last)

    @cached_property
    def _profile(self) -> LineProfile:
        return self.file.read(lambda path: read_line(path, STEEPEST))


class Track(Table):
    """External influences on the train besides brakes and resistance."""

    force: Annotated[float, UnitRange("N", between=(-LARGEST_FORCE, LARGEST_FORCE))] = Field(
        default=0.0, description="constant force, forward positive"
    )
    gradient: tuple[Gradient, ...] = Field(default=(), description="slopes along the distance; level without them")
    curve: tuple[Curve, ...] = Field(default=(), description="curves along the distance; straight without them")
    plan: Plan | None = optional("in place of both")
    line: TrackLine | None = optional("in place of gradient")
    curve_law: CurveLaw = Field(
        default="bogie",
        description="curve resistance: κ(0.158 a + 0.033 b), Röckl 650/(R − 55) ‰, or Protopapadakis "
        "κ(0.158 b + 0.103 a)",
    )
    train_mass: (
        Annotated[
            float,
            UnitRange(
                "kg",
                above=0,
                at_most=1e8,
                usual=(2e3, 2e7),
                because="the heaviest train weighed 1e8 kg, a wagon 1e4 kg",
            ),
        ]
        | None
    ) = Field(
        default=None,
        description="mass that gradient and curves act on; required only for a plant that does not give its mass",
    )

    def _check(self) -> None:
        if self.plan is not None and (self.gradient or self.curve):
            raise table_error("has a plan, which has all gradients and curves, as well as gradient or curve; keep one")
        if self.line is not None and (self.gradient or self.plan is not None):
            raise table_error("has a line, which has all gradients, as well as gradient or plan; keep one")
        for name, sections in (("gradient", self.gradient), ("curve", self.curve)):
            begins = [section.begin for section in sections]
            if begins != sorted(set(begins)):
                raise table_error(f"{name} must begin at rising distances, got {begins}")
        tightest = min((section.radius for section in self.curve if section.radius), default=math.inf)
        if self.curve_law == "roeckl" and tightest < 300:
            raise table_error(f"curve_law 'roeckl' holds for a radius of 300 m and more, got {tightest:g} m")

    @property
    def is_inclined_or_curved(self) -> bool:
        """Whether a force is proportional to the mass of the train."""
        return bool(self.gradient or self.curve or self.plan or self.line)

    @property
    def slopes(self) -> tuple[tuple[float, float], ...]:
        """Distance [m] at which each gradient begins, and its slope, without those of a plan."""
        if self.line is not None:
            return self.line.sections
        return tuple((section.begin, section.slope) for section in self.gradient)


def slope_of(track: Track) -> Callable[[float], float]:
    """Return the gradient tan β in the direction of travel as a function of the distance travelled [m]."""
    if (plan := track.plan) is not None:
        course = plan.alignment()
        return lambda distance: plan.way * float(course.slope(plan.place(distance)))
    begins, slopes = _steps(track.slopes)
    return lambda distance: slopes[bisect_right(begins, distance)]


def _steps(sections: Sequence[tuple[float, float]]) -> tuple[list[float], list[float]]:
    """Return where sections begin, and the value before the first one and of each.

    The track before the start of the stop continues as at the start, unless a section is known to begin later.
    """
    begins, values = [begin for begin, _ in sections], [value for _, value in sections]
    return begins, [values[0] if sections and begins[0] <= 0.0 else 0.0, *values]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrackForce:
    """The force of gradients and curves on a train, which act on each wheelset at its place.

    The centre of gravity of a car rises as the mean of its wheelsets, weighted with the masses that they carry. By
    virtual work, gravity is therefore the sum of these masses times g sin β at the places of the wheelsets; the height
    of the centre of gravity above the rail is neglected against the radius of roundings. Curve resistance acts at the
    wheelsets, too.

    Attributes:
        begins: Start of each section, rising, the first at −∞ [m].
        forces: Force at the start of each section if the whole train were there, forward positive [N].
        rates: Change of that force over each section, 0 for the first [N/m].
        behind: Distance of each wheelset behind the leading one [m]; (0,) if it is not known.
        shares: Share of the mass that each wheelset carries; their sum is 1.
    """

    begins: NDArray[np.float64]
    forces: NDArray[np.float64]
    rates: NDArray[np.float64]
    behind: Sequence[float] | NDArray[np.float64] = (0.0,)
    shares: Sequence[float] | NDArray[np.float64] = (1.0,)

    @property
    def is_even(self) -> bool:
        """Whether the force is the same everywhere."""
        return not np.any(self.forces != self.forces[0]) and not np.any(self.rates)

    def at(self, distance: ArrayLike) -> NDArray[np.float64]:
        """Return the force [N] with the leading wheelset at a `distance` [m] since the brake demand, in its shape."""
        place = np.asarray(distance, dtype=np.float64)
        leading, others = self._at_place(place), zip(self.behind, self.shares, strict=True)
        # Differences to the leading wheelset, as in rail.c: they are zero where the track is even.
        more = (share * (self._at_place(place - behind) - leading) for behind, share in others)
        return leading if self.is_even else leading + sum(more)

    def _at_place(self, place: NDArray[np.float64]) -> NDArray[np.float64]:
        section = np.searchsorted(self.begins, place, side="right") - 1
        rate = self.rates[section]
        return self.forces[section] + rate * np.where(rate, place - self.begins[section], 0.0)


def track_force_of(track: Track, mass: float) -> TrackForce:
    """Return the force of a track on a train at one place: the constant one, −m g sin(β) and the curve resistance.

    Along a plan it is linear between the places where curvature or slope change their slope, and every metre: 1e-4 N
    from the exact force. Beyond the ends of the plan it is constant.

    Args:
        track: Gradient, curves and constant force.
        mass: Mass of the train [kg].
    """
    if track.plan is not None:
        return _along(track, track.plan, mass)
    steps = _steps(track.slopes), _steps([(part.begin, part.curvature) for part in track.curve])
    begins = np.unique([-math.inf, *(begin for of_kind, _ in steps for begin in of_kind)])
    slope, bend = (np.array(values)[np.searchsorted(of_kind, begins, side="right")] for of_kind, values in steps)
    forces = track.force + force_along(slope, bend, mass, track.curve_law)
    return TrackForce(begins=begins, forces=forces, rates=np.zeros(begins.size))


def _along(track: Track, plan: Plan, mass: float) -> TrackForce:
    course = plan.alignment()
    ends = sorted((plan.way * (0.0 - plan.start), plan.way * (course.length - plan.start)))
    kinks = plan.way * (np.concatenate([course.curvature.at, course.slope.at]) - plan.start)
    begins = np.unique(np.concatenate([np.arange(*ends), kinks, ends]))
    at = np.clip(plan.place(begins), 0.0, course.length)
    forces = track.force + force_along(plan.way * course.slope(at), course.curvature(at), mass, track.curve_law)
    rates = np.append(np.diff(forces) / np.diff(begins), 0.0)
    return TrackForce(
        begins=np.append(-math.inf, begins), forces=np.append(forces[0], forces), rates=np.append(0.0, rates)
    )


def force_along(slope: ArrayLike, curvature: ArrayLike, mass: float, law: CurveLaw = "bogie") -> NDArray[np.float64]:
    """Return the force of gradient and curve on a train [N], forward positive, in the shape of slope and curvature.

    −m g (sin β + f): equations (7) and (9) of Schwarz, Lüdicke and Heckmann.

    Args:
        slope: Gradient tan β, positive uphill.
        curvature: 1/R [1/m], of either sign.
        law: Law of the curve resistance, see `curve_coefficient`.
    """
    climb = np.asarray(slope, dtype=np.float64)
    return -mass * GRAVITY * (climb / np.sqrt(1.0 + climb**2) + curve_coefficient(curvature, law))


def steepest_fall(track: Track) -> float:
    """Return the tangent of the steepest gradient downhill in the direction of travel, 0 or negative."""
    slopes = [slope for _, slope in track.slopes]
    if (plan := track.plan) is not None:
        slopes = [plan.way * slope for slope in (plan.slope, *(slope for _, slope, _ in plan.grades))]
    return min([0.0, *slopes])


def gravity_along(slope: ArrayLike) -> NDArray[np.float64]:
    """Return g sin β [m/s2] of a gradient tan β."""
    climb = np.asarray(slope, dtype=np.float64)
    return GRAVITY * (climb / np.sqrt(1.0 + climb**2))


def curve_coefficient(curvature: ArrayLike, law: CurveLaw) -> NDArray[np.float64]:
    """Return curve resistance over weight, f ≥ 0, at a curvature κ = 1/R [1/m] of either sign.

    `bogie`: κ(0.158 a + 0.033 b), with wheelbase a and gauge b, equation (7) of Schwarz, Lüdicke and Heckmann.
        `protopapadakis`: κ(0.158 b + 0.103 a), the formula that resembles theirs, for a friction of 0.22. `roeckl`:
        650/(R − 55) ‰, constant outside its range of R ≥ 300 m.
    """
    bend = np.abs(np.asarray(curvature, dtype=np.float64))
    if law == "roeckl":
        within = np.minimum(bend, 1.0 / 300.0)
        return 0.650 * within / (1.0 - 55.0 * within)
    if law == "protopapadakis":
        return (0.158 * _GAUGE + 0.103 * _WHEELBASE) * bend
    return (0.158 * _WHEELBASE + 0.033 * _GAUGE) * bend
