"""The geometry of the track: its alignment, positions on the Earth, and irregularities.

Horizontally a straight has zero curvature, an arc a constant one, and a transition curve (clothoid) one that changes
linearly; vertically a grade has a constant slope and a rounding by a parabola one that changes linearly. Heading and
height are therefore piecewise parabolas, and exact here; only the plan (north, east) is an integral without closed
form. Positions are latitude, longitude and height on WGS84, and a local north-east-down frame (NED). Heights are above
the ellipsoid, as in GNSS, not above sea level; the formulas are pymap3d's.

Spectra of irregularities are one-sided over the wavenumber Ω [rad/m]. A realisation is a sum of cosines with random
phases, r(s) = Σ √(2 S_f(f) Δf) cos(2π f s + θ) with S_f(f) = 2π S_Ω(2π f).

Sources: ERRI B176 RP1 (German spectra of low and high disturbance); Federal Railroad Administration, FRA/ORD-77/22
and Garg and Dukkipati, Dynamics of Railway Vehicle Systems (1984), for the classes 4 to 6.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import pymap3d
from numpy.typing import ArrayLike

from railgrip.base.arrays import Array, Vector


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """A point, or the origin of a local frame.

    Attributes:
        latitude: Degrees north.
        longitude: Degrees east.
        height: Metres above the WGS84 ellipsoid.
    """

    latitude: float
    longitude: float
    height: float


def local(latitude: ArrayLike, longitude: ArrayLike, height: ArrayLike, origin: Place) -> Array:
    """Return north, east, down [m] from `origin`, shape (…, 3), in the tangent plane of the ellipsoid there.

    The ellipsoid curves away from that plane: 1 km from the origin, "down" of a level track is 8 cm and its apparent
    slope 0.16 ‰; north and east have an error of less than 0.1 mm. Use heights, not "down", for slopes.
    """
    offsets = pymap3d.geodetic2ned(latitude, longitude, height, origin.latitude, origin.longitude, origin.height)
    return np.stack([np.asarray(c, dtype=np.float64) for c in offsets], axis=-1)


def geodetic(north: ArrayLike, east: ArrayLike, down: ArrayLike, origin: Place) -> Array:
    """Return latitude, longitude [°] and height [m], shape (…, 3), of points in the local frame of `origin`."""
    position = pymap3d.ned2geodetic(north, east, down, origin.latitude, origin.longitude, origin.height)
    return np.stack([np.asarray(c, dtype=np.float64) for c in position], axis=-1)


_PLAN_STEP = 0.5
"""Step of the table of the plan [m]: by Simpson's rule it has an error of 1e-9 m over a kilometre of 300 m radius."""


@dataclass(frozen=True, slots=True)
class Linear:
    """A continuous function of distance, linear between its points and constant beyond them.

    Attributes:
        at: Distances [m], rising, shape (k,).
        values: There, shape (k,).
    """

    at: Array
    values: Array

    def __call__(self, distance: ArrayLike) -> Array:
        """Return the value at distances [m]."""
        return np.interp(np.asarray(distance), self.at, self.values)

    def integral(self, distance: ArrayLike) -> Array:
        """Return the integral from distance 0, exact."""
        return self._from_first(np.asarray(distance, dtype=np.float64)) - self._from_first(np.zeros(()))

    def _from_first(self, distance: Array) -> Array:
        integral = np.concatenate([[0.0], np.cumsum(np.diff(self.at) * 0.5 * (self.values[1:] + self.values[:-1]))])
        piece = np.clip(np.searchsorted(self.at, distance, side="right") - 1, 0, self.at.size - 1)
        into = distance - self.at[piece]
        here = self(distance)
        # Before the first point `into` is negative and the function constant: the same trapezium is exact.
        return integral[piece] + 0.5 * into * (here + np.where(into < 0, here, self.values[piece]))


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackAlignment:
    """A track as designed by the surveyor.

    Attributes:
        origin: Position of the point `middle`, and origin of the local frame.
        middle: Distance [m] of that point.
        length: Length of the track [m].
        heading: Heading at `middle` [rad], clockwise from north.
        curvature: κ = dφ/ds [1/m], positive to the right.
        slope: tan β, positive uphill in the direction of distance.
    """

    origin: Place
    middle: float
    length: float
    heading: float
    curvature: Linear
    slope: Linear

    def heading_at(self, distance: ArrayLike) -> Array:
        """Return the heading φ [rad], clockwise from north."""
        return self.heading + self.curvature.integral(distance) - self.curvature.integral(self.middle)

    def height_at(self, distance: ArrayLike) -> Array:
        """Return the height above the ellipsoid [m]."""
        return self.origin.height + self.slope.integral(distance) - self.slope.integral(self.middle)

    def plan(self) -> "HorizontalAlignment":
        """Return north and east of the whole track, by Simpson's rule over each step."""
        count = int(np.ceil(self.length / _PLAN_STEP))
        distance = np.linspace(0.0, self.length, count + 1)
        between = 0.5 * (distance[1:] + distance[:-1])
        ends, middles = (
            np.stack([np.cos(phi), np.sin(phi)], axis=1)
            for phi in (self.heading_at(distance), self.heading_at(between))
        )
        steps = np.diff(distance)[:, None] / 6.0 * (ends[:-1] + 4.0 * middles + ends[1:])
        horizontal = np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
        start = [float(np.interp(self.middle, distance, column)) for column in horizontal.T]
        return HorizontalAlignment(self, distance, horizontal - start)


@dataclass(frozen=True, slots=True)
class HorizontalAlignment:
    """North and east along a track, as a table with small steps.

    Attributes:
        track: The tabulated track.
        distance: Distances, shape (k,) [m].
        horizontal: North and east of the origin, shape (k, 2) [m].
    """

    track: TrackAlignment
    distance: Array
    horizontal: Array

    def horizontal_at(self, distance: ArrayLike) -> Array:
        """Return north and east [m], shape (…, 2)."""
        return np.stack(
            [np.interp(np.asarray(distance), self.distance, column) for column in self.horizontal.T], axis=-1
        )

    def positions(self, distance: ArrayLike) -> Array:
        """Return latitude, longitude [°] and height above the ellipsoid [m], shape (…, 3)."""
        horizontal = self.horizontal_at(distance)
        positions = geodetic(horizontal[..., 0], horizontal[..., 1], np.zeros(horizontal.shape[:-1]), self.track.origin)
        # The plan is in the tangent plane, heights are above the ellipsoid.
        positions[..., 2] = self.track.height_at(distance)
        return positions


def course_of(pieces: Sequence[tuple[float, float]]) -> Linear:
    """Return the curvature of consecutive pieces, given their lengths [m] and the curvatures at their ends [1/m].

    A straight or arc repeats the curvature before it, and a transition curve changes it without a jump.
    """
    lengths, curvatures = np.array([(0.0, 0.0), *pieces]).T
    return Linear(np.cumsum(lengths), curvatures)


def grades_of(first: float, changes: tuple[tuple[float, float, float], ...]) -> Linear:
    """Return the slope of grades joined by parabolas.

    Args:
        first: Slope at the start.
        changes: Distance of the intersection of the tangents [m], slope after it, radius of the parabola [m].

    Raises:
        ValueError: Two parabolas overlap.
    """
    at, values, slope = [0.0], [first], first
    for place, after, radius in changes:
        half = 0.5 * radius * abs(after - slope)
        if place - half < at[-1]:
            raise ValueError(f"the rounding at {place:g} m begins at {place - half:g} m, before {at[-1]:g} m")
        at += [place - half, place + half]
        values += [slope, after]
        slope = after
    return Linear(np.array(at), np.array(values))


Kind = Literal["alignment", "vertical", "cross_level", "gauge"]
KINDS: Final[tuple[Kind, ...]] = ("alignment", "vertical", "cross_level", "gauge")

HALF_GAUGE: Final = 0.75
"""Half the distance of the contacts [m], ERRI's b."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Band:
    """Spatial frequencies of a realisation, 1/m: wavelengths from 1/highest to 1/lowest."""

    lowest: float
    highest: float
    lines: int

    @property
    def spacing(self) -> float:
        """Distance of the spectral lines, 1/m; a realisation repeats after 1/spacing."""
        return (self.highest - self.lowest) / self.lines

    @property
    def frequencies(self) -> Vector:
        """Centres of the spectral lines, 1/m, shape (lines,)."""
        return np.asarray(self.lowest + (np.arange(self.lines) + 0.5) * self.spacing, dtype=np.float64)


RIDE: Final = Band(lowest=0.008, highest=0.8, lines=1600)
"""Wavelengths from 1.25 to 125 m: 0.06 to 21 Hz at 60 mph, and no repetition within 2 km."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Fra:
    """American track class after FRA/AAR.

    Attributes:
        a_vertical, a_lateral: Roughness, m²·rad/m.
        omega_s: Corner of cross level and gauge, rad/m.
    """

    a_vertical: float
    a_lateral: float
    omega_s: float

    def density(self, kind: Kind, omega: Vector) -> Vector:
        """Return S_Ω, m²/(rad/m), at wavenumbers in rad/m."""
        k, corner = 0.25, 0.8245
        fall = corner**2 / (omega**2 + corner**2)
        if kind == "alignment":
            return k * self.a_lateral * fall / omega**2
        if kind == "vertical":
            return k * self.a_vertical * fall / omega**2
        return 4 * k * self.a_vertical * fall / (omega**2 + self.omega_s**2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Erri:
    """German track after ERRI B176.

    Attributes:
        a_lateral, a_vertical, a_gauge: Roughness, m²·rad/m.
    """

    a_lateral: float
    a_vertical: float
    a_gauge: float

    def density(self, kind: Kind, omega: Vector) -> Vector:
        """Return S_Ω, m²/(rad/m), at wavenumbers in rad/m; cross level as a height over both rails."""
        corner, long, short = 0.8246, 0.0206, 0.4380
        common = corner**2 / ((omega**2 + long**2) * (omega**2 + corner**2))
        if kind == "alignment":
            return self.a_lateral * common
        if kind == "vertical":
            return self.a_vertical * common
        high_pass = omega**2 / (omega**2 + short**2)
        if kind == "gauge":
            return self.a_gauge * common * high_pass
        angle = self.a_vertical / HALF_GAUGE**2 * common * high_pass
        return angle * (2 * HALF_GAUGE) ** 2


CM2: Final = 1e-4
TRACKS: Final[Mapping[str, Fra | Erri]] = {
    "fra-4": Fra(a_vertical=0.5376 * CM2, a_lateral=0.3027 * CM2, omega_s=1.1312),
    "fra-5": Fra(a_vertical=0.2095 * CM2, a_lateral=0.0762 * CM2, omega_s=0.8209),
    "fra-6": Fra(a_vertical=0.0339 * CM2, a_lateral=0.0339 * CM2, omega_s=0.4380),
    "erri-low": Erri(a_lateral=2.119e-7, a_vertical=4.032e-7, a_gauge=5.32e-8),
    "erri-high": Erri(a_lateral=6.125e-7, a_vertical=1.080e-6, a_gauge=1.032e-7),
}


def spectrum(track: str, kind: Kind, frequencies: Vector) -> Vector:
    """Return S_f, m²/(1/m), at spatial frequencies in 1/m."""
    return 2 * np.pi * TRACKS[track].density(kind, 2 * np.pi * frequencies)


def rms(track: str, kind: Kind, band: Band) -> float:
    """Return the root mean square, m, within a band."""
    return float(np.sqrt(np.sum(spectrum(track, kind, band.frequencies)) * band.spacing))


@dataclass(frozen=True, slots=True)
class Irregularity:
    """One realisation of a track, by kind: irregularity [m] over the position [m], within its grid."""

    curves: Mapping[Kind, Callable[[Vector], Vector]]

    def at(self, kind: Kind, position: Vector) -> Vector:
        """Return the irregularity, m, at positions along the track, m."""
        return np.asarray(self.curves[kind](position), dtype=np.float64)


def realise(
    track: str, length: float, generator: np.random.Generator, band: Band = RIDE, kinds: Collection[Kind] = KINDS
) -> Irregularity:
    """Draw the irregularities of a stretch of track from position 0 to `length`, m."""
    # Eight points on the shortest wave: the error of the cubic interpolation is then below 0.2 %.
    grid = np.arange(0.0, length + 1.0, 1 / (8 * band.highest))
    frequencies = band.frequencies
    from scipy.interpolate import CubicSpline  # takes half a second, and few tracks are uneven

    curves: dict[Kind, Callable[[Vector], Vector]] = {}
    for kind in kinds:
        amplitude = np.sqrt(2 * spectrum(track, kind, frequencies) * band.spacing)
        phase = generator.uniform(0, 2 * np.pi, band.lines)
        curves[kind] = CubicSpline(grid, _sum_of_cosines(grid, frequencies, amplitude, phase))
    return Irregularity(curves)


def _sum_of_cosines(position: Vector, frequencies: Vector, amplitude: Vector, phase: Vector) -> Vector:
    out = np.zeros(position.size)
    for part in np.array_split(np.arange(position.size), max(1, position.size // 500)):
        turns = np.outer(position[part], frequencies)
        out[part] = np.cos(2 * np.pi * turns + phase) @ amplitude
    return out
