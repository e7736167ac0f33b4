"""The alignment of a track: curvature and slope, piecewise linear over the distance.

Horizontally a straight has zero curvature, an arc a constant one, and a transition curve (clothoid) one that changes
linearly; vertically a grade has a constant slope and a rounding by a parabola one that changes linearly. Heading and
height are therefore piecewise parabolas, and exact here; only the plan (north, east) is an integral without closed
form.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railgrip.scenario.track.geodesy import Place, geodetic

Array = NDArray[np.float64]

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
