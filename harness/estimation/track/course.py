"""Curvature and slope of the track under a train, from positions and the distance at which they were taken.

Equations (6) and (8) of Schwarz, Lüdicke and Heckmann: κ = Δφ/Δs, tan β = Δz/Δs. The low-pass is one in the domain of
distance: north, east and height become smoothing splines over the distance, with weights in proportion to the way
between two samples, so that the same metres count the same at 5 and at 100 km/h. Away from its ends such a spline
keeps 1/(1 + (L/l)⁴) of a wave of length l, half of one of the cut-off length L.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_smoothing_spline

from railgrip.errors import EstimationError
from railgrip.estimation.spec import LowPass
from railgrip.estimators.belief import Array

GRID = 1.0
"""Of the result [m]; positions closer together count as one."""

FEWEST = 5
"""Points that a smoothing spline needs."""


@dataclass(frozen=True, slots=True)
class Course:
    """What was recovered, on an even grid of distance.

    Attributes:
        distance: Shape (k,) [m].
        horizontal: North and east, shape (k, 2) [m].
        height: Shape (k,) [m].
        heading: φ, continuous, clockwise from north [rad].
        curvature: κ [1/m], positive to the right in the direction of travel.
        slope: tan β, positive uphill in the direction of travel.
    """

    distance: Array
    horizontal: Array
    height: Array
    heading: Array
    curvature: Array
    slope: Array

    def curvature_at(self, distance: ArrayLike) -> Array:
        """Return κ [1/m] at distances [m]."""
        return np.interp(np.asarray(distance), self.distance, self.curvature)

    def slope_at(self, distance: ArrayLike) -> Array:
        """Return tan β at distances [m]."""
        return np.interp(np.asarray(distance), self.distance, self.slope)

    def length_to(self, distance: ArrayLike) -> Array:
        """Return how long the recovered path is up to given distances of whatever measured them [m]."""
        steps = np.linalg.norm(np.diff(self.horizontal, axis=0), axis=1)
        return np.interp(np.asarray(distance), self.distance, np.concatenate([[0.0], np.cumsum(steps)]))

    def ahead(self, distance: Array, horizontal: Array) -> Array:
        """Return how far ahead of their distance positions lie, along the path [m], shape (k,)."""
        heading = np.interp(distance, self.distance, self.heading)
        north, east = (np.interp(distance, self.distance, column) for column in self.horizontal.T)
        return (horizontal[:, 0] - north) * np.cos(heading) + (horizontal[:, 1] - east) * np.sin(heading)


def course_of(distance: Array, horizontal: Array, height: Array, low_pass: LowPass) -> Course:
    """Return the course of a track from positions along it.

    Args:
        distance: Travelled, never falling, shape (k,) [m].
        horizontal: North and east there, shape (k, 2) [m].
        height: There, shape (k,) [m].

    Raises:
        EstimationError: The positions span less than the base of the differences and five metres.
    """
    reach = float(distance[-1] - distance[0])
    if reach < max(low_pass.base, FEWEST * GRID):
        raise EstimationError(
            f"course: positions over {reach:.1f} m say nothing about curvature over {low_pass.base:g} m; "
            "take a longer recording."
        )
    at, positions = _means_by_metre(distance, np.column_stack([horizontal, height]))
    # The way for which each point stands: half of that to either neighbour.
    weight = np.gradient(at)
    plan, rise = ((wavelength / (2.0 * np.pi)) ** 4 for wavelength in (low_pass.plan, low_pass.height))
    north, east = (make_smoothing_spline(at, positions[:, c], w=weight, lam=plan) for c in (0, 1))
    up = make_smoothing_spline(at, positions[:, 2], w=weight, lam=rise)
    grid = np.arange(at[0], at[-1], GRID)
    half = 0.5 * low_pass.base
    # At the ends the base is cut, not moved.
    behind, before = np.maximum(grid - half, at[0]), np.minimum(grid + half, at[-1])

    def heading(s: Array) -> Array:
        return np.unwrap(np.arctan2(east(s, nu=1), north(s, nu=1)))

    turn = (heading(before) - heading(behind) + np.pi) % (2.0 * np.pi) - np.pi
    return Course(
        distance=grid,
        horizontal=np.column_stack([north(grid), east(grid)]),
        height=up(grid),
        heading=heading(grid),
        curvature=turn / (before - behind),
        slope=(up(before) - up(behind)) / (before - behind),
    )


def _means_by_metre(distance: Array, values: Array) -> tuple[Array, Array]:
    """Return means of distance and values over each metre in which there is a sample."""
    cell = np.floor((distance - distance[0]) / GRID).astype(int)
    _, which, count = np.unique(cell, return_inverse=True, return_counts=True)
    at = np.bincount(which, distance) / count
    return at, np.column_stack([np.bincount(which, column) / count for column in values.T])
