"""Where along the track one stop loses distance against another.

Both stops pass the same speeds at different places. The distance between these places is the distance lost so far; it
begins with 0 and ends with the difference of the distances. What a section of the track adds to it is the length of the
section less the distance that the first stop needs for the same speeds.
"""

from dataclasses import dataclass
from math import inf, nan

import numpy as np
import xarray

from railgrip.base.arrays import Array
from railgrip.trace.measures import since_brake_demand

_WIDTHS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0)
_MAX_SECTIONS = 12
_REST = 0.1
"""Share of a section below which the last piece of the track is joined to the section before."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StopCourse:
    """Where a stop falls below each of its speeds, shape (n,); the first sample is the brake demand.

    Attributes:
        time: Since the brake demand [s].
        place: Distance since the brake demand [m].
        speed: Falling; a stretch along which the train keeps or gains speed has only its end [m/s].
    """

    time: Array
    place: Array
    speed: Array

    def place_at(self, speed: Array) -> Array:
        """Return where the stop falls below a speed [m]; 0 for one above that at the start."""
        return np.interp(-speed, -self.speed, self.place)


@dataclass(frozen=True, slots=True, kw_only=True)
class SectionLoss:
    """What one stop loses against another on a piece of the track.

    Attributes:
        begin: Place [m].
        end: Place [m].
        time: At which the stop enters it [s].
        speed: With which it enters [m/s].
        lost: Distance lost in it, negative where it is gained [m].
        so_far: Distance lost up to its end [m].
        deceleration: Mean of the stop in it [m/s2].
        deceleration_of_first: Mean of the other stop between the same speeds [m/s2]; NaN where it had none of them.
    """

    begin: float
    end: float
    time: float
    speed: float
    lost: float
    so_far: float
    deceleration: float
    deceleration_of_first: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loss:
    """The distance that a stop loses against another along its track.

    Attributes:
        first: The other stop.
        course: The stop, down to the lowest speed that both reached.
        lost: So far, at each of its samples [m].
        sections: Loss in each section of the track, preceded by the saving from a lower speed at the start.
    """

    first: StopCourse
    course: StopCourse
    lost: Array
    sections: tuple[SectionLoss, ...]

    @property
    def at_start(self) -> float:
        """Distance saved, negative, by a lower speed at the start [m]."""
        return float(self.lost[0])

    @property
    def total(self) -> float:
        """Distance lost at the end [m]."""
        return float(self.lost[-1])

    @property
    def speed_difference(self) -> Array:
        """Speed less that of the first stop at the same place, 0 beyond its end [m/s]; shape of `lost`."""
        return self.course.speed - np.interp(self.course.place, self.first.place, self.first.speed)


def course_of(trace: xarray.Dataset, *, is_standstill: bool) -> StopCourse:
    """Return the course of a stop.

    Args:
        trace: Trace of the stop.
        is_standstill: Whether it ended at a standstill; the last speed, which is nearly 0, then counts as 0.
    """
    braking = since_brake_demand(trace)
    time, distance = braking["time"].values, braking["distance"].values
    speed = np.minimum.accumulate(braking["speed"].values)
    if is_standstill:
        speed[-1] = 0.0
    ends = np.append(np.diff(speed) < 0, True)
    ends[0] = True
    return StopCourse(time=(time - time[0])[ends], place=(distance - distance[0])[ends], speed=speed[ends])


def loss(first: StopCourse, course: StopCourse) -> Loss:
    """Return where a stop loses distance against a first one, down to the lowest speed that both reached."""
    common = course.speed >= first.speed[-1]
    common[0] = True
    course = StopCourse(time=course.time[common], place=course.place[common], speed=course.speed[common])
    lost = course.place - first.place_at(course.speed)
    if course.speed[0] >= first.speed[0]:
        lost[0] = 0.0
    return Loss(first=first, course=course, lost=lost, sections=_sections(course, lost))


def _sections(course: StopCourse, lost: Array) -> tuple[SectionLoss, ...]:
    end = float(course.place[-1])
    if end <= 0.0:
        return ()
    width = next((width for width in _WIDTHS if end / width <= _MAX_SECTIONS), end / _MAX_SECTIONS)
    edges = [*np.arange(0.0, end - _REST * width, width).tolist(), end]
    time, speed, so_far = (np.interp(edges, course.place, values) for values in (course.time, course.speed, lost))
    needed = np.diff(edges) - np.diff(so_far)
    squares = -np.diff(speed**2) / 2
    return tuple(
        SectionLoss(
            begin=edges[i],
            end=edges[i + 1],
            time=float(time[i]),
            speed=float(speed[i]),
            lost=float(so_far[i + 1] - so_far[i]),
            so_far=float(so_far[i + 1]),
            deceleration=float(squares[i]) / (edges[i + 1] - edges[i]),
            deceleration_of_first=_quotient(float(squares[i]), float(needed[i])),
        )
        for i in range(len(edges) - 1)
    )


def _quotient(square: float, distance: float) -> float:
    mean = square / distance if distance > 0.0 else inf
    return mean if mean < inf else nan
