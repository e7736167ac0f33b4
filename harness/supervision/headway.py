"""Headway of equal trains under ETCS: blocking times of fixed blocks (level 2), or of a moving block (level 3).

A block is blocked from the moment at which its movement authority is requested, so that the train does not get the
indication of the block's end of authority, until its rear end has left the block and this is reported. The
longest blocking time of the line is the shortest headway of equal trains that run alike.

Source: Pachl, Railway Operation and Control (2002), section 4.2; Hansen and Pachl, Railway Timetabling and Operations
(2014); UIC Code 406 (2013). A moving block is the limit of fixed blocks without length.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from railgrip.base.arrays import Vector
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.table import Delay, Length, Speed, Table, table_error
from railgrip.scenario.track import Gradient
from railgrip.supervision.limits import BrakingCase, limits_of
from railgrip.supervision.line import Line, Target
from railgrip.supervision.model import BrakingModel
from railgrip.supervision.national import Deceleration, NationalValues

_GRID = 5.0  # m, between points of a run
_EVERY = 10.0  # m, between ends of authority of a moving block
_SPEEDS = 400  # points of an indication curve

_Seconds = Annotated[float, UnitRange("s", between=(0, 600), because="signalling acts within seconds")]


class SpeedSection(Table):
    """From here on the line has this permitted speed."""

    begin: Length = Field(description="location at which it begins")
    speed: Speed = Field(description="permitted speed; that of the train where it is lower")


class Stopping(Table):
    """A stop of all trains at a station."""

    at: Length = Field(description="location of the front end of the train")
    dwell: Delay = Field(description="time at rest")


class SignallingTimes(Table):
    """Times and margins of the signalling."""

    setup: _Seconds = Field(description="from the request of a movement authority until it is on board")
    release: _Seconds = Field(description="from the rear end leaving a fixed block until it can be given again")
    report: _Seconds = Field(
        description="moving block: from the rear end leaving a place until its position report is processed"
    )
    margin: Length = Field(description="moving block: distance of the end of authority to the reported rear end")
    source: str = Field(min_length=3, description="publication of the numbers, or that they are estimates")


class SignallingLayout(Table):
    """The signalling and the run of equal trains on a line."""

    speed: tuple[SpeedSection, ...] = Field(
        min_length=1, description="permitted speeds in order; the first one also holds before its begin"
    )
    gradient: tuple[Gradient, ...] = Field(default=(), description="gradients; level before the first")
    block: tuple[Length, ...] = Field(
        min_length=2, max_length=500, description="locations of the block markers; a block is between two of them"
    )
    overlap: Length = Field(default=0.0, description="distance from a marker (EoA) to the supervised location (SvL)")
    stop: tuple[Stopping, ...] = Field(default=(), description="stops at stations")
    acceleration: Deceleration = Field(description="acceleration of the trains after restrictions and stops")
    deceleration: Deceleration = Field(description="deceleration of the trains before restrictions and stops")
    times: SignallingTimes = Field(description="times and margins of the signalling")

    def _check(self) -> None:
        places = {
            "speed": [section.begin for section in self.speed],
            "gradient": [section.begin for section in self.gradient],
            "block": list(self.block),
            "stop": [stop.at for stop in self.stop],
        }
        for key, locations in places.items():
            if locations != sorted(set(locations)):
                raise table_error(f"{key} must be at rising locations, got {locations}")
        if any(np.diff(places["stop"]) < 2 * _GRID):
            raise table_error(f"stop: stations must be at least {2 * _GRID:g} m apart, got {places['stop']}")

    def limit(self, rear: Vector, front: Vector) -> Vector:
        """Return the lowest permitted speed under trains, from their rear ends to their front ends [m/s]."""
        begins = np.array([-np.inf, *(section.begin for section in self.speed[1:])])
        ends = np.append(begins[1:], np.inf)
        under = (begins <= front[:, None]) & (ends >= rear[:, None])
        return np.where(under, [section.speed for section in self.speed], np.inf).min(axis=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Headway:
    """The shortest headway of equal trains.

    Attributes:
        seconds: Headway [s].
        place: Location of the end of authority that decides it [m].
        limit: Curve of that end of authority that is indicated first: "SBD" of the EoA, or "EBD" of the SvL.
        parts: Parts of the headway [s], which add up to it: `signalling`, `approach` (from the indication to the
            marker), `block`, `clearing` (overlap or margin, and train), and `dwell` at stations in these parts.
    """

    seconds: float
    place: float
    limit: str
    parts: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """The run of a train: at the permitted speed, with constant acceleration and deceleration between speeds.

    Attributes:
        location: Of points of the front end, rising, shape (n,) [m].
        speed: There [m/s].
        moving: Time in motion up to there [s].
        dwell: Time at stations up to there, without that of a stop at this very place [s].
    """

    location: Vector
    speed: Vector
    moving: Vector
    dwell: Vector


def run_of(layout: SignallingLayout, length: float, fastest: float, places: Sequence[float]) -> Run:
    """Return the run of a train from the first to the last of some places, which are points of it.

    Args:
        layout: The line.
        length: Length of the train [m]; its rear end must have left a restriction before it accelerates.
        fastest: Maximum speed of the train [m/s].
        places: Locations at which times are needed [m].
    """
    stops = np.array([stop.at for stop in layout.stop])
    # Speeds also depend on restrictions and stops ahead of and behind these places.
    known = np.concatenate([places, stops, [section.begin for section in layout.speed[1:]]])
    # At whole steps, so that the same line has the same points for every train.
    x = np.unique(np.concatenate([_GRID * np.arange(known.min() // _GRID, known.max() // _GRID + 2), known]))
    highest = np.minimum(layout.limit(x - length, x), fastest) ** 2
    highest[np.isin(x, stops)] = 0.0
    # v² rises by 2 a x at most: the lower envelope of lines from all places behind, and from all places ahead.
    up, down = 2 * layout.acceleration * x, 2 * layout.deceleration * x
    forward = np.minimum.accumulate(highest - up) + up
    backward = np.minimum.accumulate((highest + down)[::-1])[::-1] - down
    v = np.sqrt(np.maximum(np.minimum(forward, backward), 0.0))
    moving = np.concatenate([[0.0], np.cumsum(2 * np.diff(x) / (v[1:] + v[:-1]))])
    dwell = ((stops < x[:, None]) * np.array([stop.dwell for stop in layout.stop])).sum(axis=1)
    return Run(x, v, moving, dwell)


def headways(layout: SignallingLayout, model: BrakingModel, national: NationalValues) -> tuple[Headway, Headway]:
    """Return the headway with fixed blocks and with a moving block.

    Args:
        layout: Signalling and run.
        model: Braking model of the train.
        national: National values.

    Raises:
        InputError: The brake does not slow the train down on a gradient.
    """
    first, last = layout.block[0], layout.block[-1]
    ends = [*np.arange(first, last, _EVERY).tolist(), last]
    ahead = model.length + layout.times.margin
    ends += [stop.at - ahead + 0.01 for stop in layout.stop if first < stop.at - ahead < last]
    fixed = _headway(layout, model, national, list(zip(layout.block, layout.block[1:], strict=False)), layout.overlap,
                     layout.overlap, layout.times.release)  # fmt: skip
    moving = _headway(layout, model, national, [(end, end) for end in ends], 0.0, layout.times.margin,
                      layout.times.report)  # fmt: skip
    return fixed, moving


def _headway(
    layout: SignallingLayout,
    model: BrakingModel,
    national: NationalValues,
    blocks: Sequence[tuple[float, float]],
    overlap: float,
    beyond: float,
    release: float,
) -> Headway:
    """Return the longest blocking time of blocks from an end of authority to an end that the train has to clear.

    Args:
        overlap: Distance from the EoA to the SvL [m].
        beyond: Distance behind a block that the rear end has to clear, too [m].
        release: Time after that [s].
    """
    line = Line(gradient=layout.gradient, target=(Target(kind="EoA", at=0.0),))
    case = BrakingCase(model, national, line)
    fastest = min(max(section.speed for section in layout.speed), model.maximum_speed)
    speeds = np.linspace(0.0, fastest, _SPEEDS)
    curves = []
    for begin, _ in blocks:
        targets = {"SBD": Target(kind="EoA", at=begin), "EBD": Target(kind="SvL", at=begin + overlap)}
        curves.append({name: limits_of(case, target, speeds)["I"] for name, target in targets.items()})
    start = _GRID * (min(float(each[-1]) for of_block in curves for each in of_block.values()) // _GRID - 1)
    cleared = [end + beyond + model.length for _, end in blocks]
    run = run_of(layout, model.length, fastest, [start, *(place for block in blocks for place in block), *cleared])
    found = [
        _blocking(layout, run, block, end, speeds, of_block, release)
        for block, end, of_block in zip(blocks, cleared, curves, strict=True)
    ]
    return max(found, key=lambda headway: round(headway.seconds, 6))  # the first of those that differ by rounding


def _blocking(
    layout: SignallingLayout,
    run: Run,
    block: tuple[float, float],
    cleared: float,
    speeds: Vector,
    indication: Mapping[str, Vector],
    release: float,
) -> Headway:
    """Return the blocking time of one block."""
    places: dict[str, float] = {}
    for name, locations in indication.items():
        # Between the indications at the highest speed and at standstill.
        first, last = np.searchsorted(run.location, [locations[-1], locations[0]])
        near = slice(first - 1, last + 1)
        at, excess = run.location[near], run.location[near] - np.interp(run.speed[near], speeds, locations)
        number = max(int(np.argmax(excess >= 0)), 1)
        share = excess[number] / (excess[number] - excess[number - 1])
        places[name] = float(at[number] - share * (at[number] - at[number - 1]))
    limit = min(places, key=lambda name: places[name])
    moving = [float(np.interp(place, run.location, run.moving)) for place in (places[limit], *block, cleared)]
    dwell = float(np.diff(np.interp([places[limit], cleared], run.location, run.dwell))[0])
    # A train that stands between indication and marker needs its authority when it departs.
    if stands := [stop for stop in layout.stop if places[limit] <= stop.at <= block[0]]:
        moving[0] = float(np.interp(stands[-1].at, run.location, run.moving))
        dwell -= sum(stop.dwell for stop in stands)
    parts = dict(zip(("approach", "block", "clearing"), np.diff(moving).tolist(), strict=True))
    parts |= {"dwell": dwell, "signalling": layout.times.setup + release}
    return Headway(seconds=sum(parts.values()), place=block[0], limit=limit, parts=parts)
