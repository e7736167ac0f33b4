"""Step functions, and braking curves that follow from them exactly, in arcs of constant deceleration."""

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import inf
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from railgrip.base.arrays import Vector
from railgrip.base.errors import InputError

TOP = 250.0
"""Speed up to which curves are computed [m/s]: beyond that of any train (160 m/s) with all margins of supervision."""


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """A step function; its last step has no end.

    Attributes:
        starts: Where each step begins, rising, shape (n,); the step includes its end and not its start.
        values: Value of each step, shape (n,).
    """

    starts: Vector
    values: Vector

    @classmethod
    def of(cls, rows: Sequence[tuple[float, float]]) -> Self:
        """Return the step function of rows of start and value."""
        starts, values = np.array(rows, dtype=np.float64).T
        return cls(starts, values)

    @classmethod
    def constant(cls, value: float, start: float = 0.0) -> Self:
        """Return a step function of one value."""
        return cls.of([(start, value)])

    def at(self, place: ArrayLike) -> Vector:
        """Return the values at some places; before the first step, the first value."""
        return self.values[np.maximum(np.searchsorted(self.starts, place) - 1, 0)]

    def after(self, place: ArrayLike) -> Vector:
        """Return the values just after some places."""
        return self.values[np.maximum(np.searchsorted(self.starts, place, side="right") - 1, 0)]


def combine(function: Callable[..., Vector], *parts: Steps) -> Steps:
    """Return the step function of values that depend on those of several step functions."""
    starts = np.unique(np.concatenate([part.starts for part in parts]))
    return Steps(starts, function(*(part.after(starts) for part in parts)))


@dataclass(frozen=True, slots=True, eq=False)
class BrakingCurve:
    """A braking curve: squared speed is linear in location between its points.

    Attributes:
        locations: Of the points, rising, shape (n,) [m].
        squares: Squared speed at the points, falling, shape (n,) [m2/s2].
    """

    locations: Vector
    squares: Vector

    def location(self, speed: ArrayLike) -> Vector:
        """Return the locations at which the curve has some speeds [m]; for a lower speed, the foot of the curve."""
        return np.interp(np.square(speed), self.squares[::-1], self.locations[::-1])

    def speed(self, location: ArrayLike) -> Vector:
        """Return the speeds of the curve at some locations [m/s]; beyond its foot, the speed there."""
        return np.sqrt(np.interp(np.asarray(location, dtype=np.float64), self.locations, self.squares))


@dataclass(frozen=True, slots=True, eq=False)
class Deceleration:
    """A(V, d): the deceleration of a train, in steps of speed and location.

    Attributes:
        speeds: Where each step of speed starts, rising from 0, shape (n,) [m/s].
        locations: Where each step of location starts, rising from −∞, shape (m,) [m].
        values: Shape (m, n), negative where the train gets faster [m/s2].
    """

    speeds: Vector
    locations: Vector
    values: Vector

    @classmethod
    def of(cls, function: Callable[..., Vector], over_speed: Sequence[Steps], over_location: Sequence[Steps]) -> Self:
        """Return the deceleration as a function of values over speed and of values over location, in this order."""
        speeds, locations = (
            np.unique(np.concatenate([part.starts for part in parts])) for parts in (over_speed, over_location)
        )
        of_speed = [part.after(speeds) for part in over_speed]
        of_location = [part.after(locations)[:, None] for part in over_location]
        return cls(speeds, locations, function(*of_speed, *of_location))


def braking_curve(deceleration: Deceleration, *, location: float, speed: float, foot: float) -> BrakingCurve:
    """Return the curve through a point, up to `TOP` against the direction of travel and down to a speed (§3.13.8.1.3).

    Each arc ends where the speed or the location reaches the next step, so that there is no step error.

    Args:
        deceleration: Of the train on the line.
        location: Location of the point [m].
        speed: Speed at the point [m/s].
        foot: Lowest speed of the curve [m/s].

    Raises:
        InputError: The brake does not slow the train down on the gradient.
    """
    before, behind = (list(_arcs(deceleration, location, speed**2, until**2)) for until in (TOP, foot))
    locations, squares = np.array([*reversed(before), (location, speed**2), *behind]).T
    return BrakingCurve(locations, squares)


def _arcs(deceleration: Deceleration, location: float, square: float, until: float) -> Iterator[tuple[float, float]]:
    """Yield the ends of the arcs from a point to a squared speed, upstream where it rises."""
    upstream = until > square
    squares, places = [*(deceleration.speeds**2).tolist(), inf], [*deceleration.locations.tolist(), inf]
    while square != until:
        step = (bisect_right if upstream else bisect_left)(squares, square) - 1
        place = (bisect_left if upstream else bisect_right)(places, location) - 1
        value = float(deceleration.values[place, step])
        if value <= 0:
            raise InputError(
                f"the brake does not slow the train down on the gradient at {location:.0f} m: its deceleration at "
                f"{3.6 * square**0.5:.1f} km/h is {value:.3f} m/s2"
            )
        end = min(until, squares[step + 1]) if upstream else max(until, squares[step])
        border = places[place] if upstream else places[place + 1]
        reached = location - (end - square) / (2 * value)
        if (reached < border) if upstream else (reached > border):
            square, location = square + 2 * value * (location - border), border
        else:
            square, location = end, reached
        yield location, square
