"""What a train knows of itself from sample to sample: its newest readings and, with an estimator, its belief."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from railgrip import signals
from railgrip.controllers.sight import Sight
from railgrip.loop.ports import Filter
from railgrip.record.recorder import Recorder
from railgrip.signals import Layout

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Indices = NDArray[np.intp]

_SMALL_SPEED = 0.05
"""Speed [m/s] below which slip is not formed: over the last millimetres it is a ratio of two noises."""

NEGATIVE = "The estimator diverged: a variance is negative or not a number."


@dataclass(frozen=True, slots=True, kw_only=True)
class Believer:
    """An estimator that holds its first belief, and where its states and readings stand.

    Attributes:
        filter: Its inputs are the pressures first; the rest (track force) is not known to the train and stays zero.
        seen: Entries of a reading that the filter takes, in its order.
        speed: Index of the train speed among the states.
        wheelset_speed: Indices of the wheelset speeds.
        adhesion: Indices of the adhesions.
        pad_friction: Indices of the pad frictions.
        wheel_radius: As the estimator believes it, one for each group [m].
    """

    filter: Filter
    seen: Indices
    speed: int
    wheelset_speed: Indices
    adhesion: Indices
    pad_friction: Indices
    wheel_radius: tuple[float, ...]


class Readings:
    """A train without an estimator."""

    def __init__(self, layout: Layout, wheel_radius: tuple[float, ...]) -> None:
        """See nothing yet."""
        self._at, self._every, self._radius = layout.reading, np.ones(layout.readings), wheel_radius
        self._latest: Vector | None = None

    def see(self, reading: Vector) -> None:
        """Take a reading; where it is NaN the last one goes on."""
        # The sum is NaN exactly when an entry is: readings are far too small to overflow.
        if self._latest is None or not math.isnan(self._every.dot(reading)):
            self._latest = reading
        else:
            self._latest = np.where(np.isnan(reading), self._latest, reading)

    def believe(self) -> None:
        """Believe nothing."""

    def record(self, row: Vector) -> None:
        """Write nothing."""

    def complete(self, rows: Matrix) -> None:
        """Add nothing."""

    def sight(self, time: float) -> Sight:
        """Return what the controller sees now."""
        assert self._latest is not None
        values = self._latest.tolist()
        speed, acceleration = values[self._at["speed"].start], values[self._at["acceleration"].start]
        slip = _slips(speed, values[self._at["wheelset_speed"]], self._radius)
        return Sight(time, speed, acceleration, slip, None, None, tuple(values[self._at["cylinder_pressure"]]))


class Beliefs:
    """A train with an estimator.

    The believed speeds, adhesions and pad frictions go into a row as they stand in the belief, with variances; what
    follows from them is computed for all rows at once in `complete`.
    """

    def __init__(self, layout: Layout, believer: Believer, recorder: Recorder) -> None:
        """See nothing yet, and believe what the filter does."""
        self._groups, self._every = layout.formation.groups, np.ones(layout.readings)
        self._acceleration, self._pressure = layout.reading["acceleration"].start, layout.reading["cylinder_pressure"]
        self._filter = its = believer.filter
        self._radius, self._seen = believer.wheel_radius, believer.seen
        uncertain = [believer.adhesion, believer.pad_friction]
        self._states = np.concatenate([[believer.speed], believer.wheelset_speed, *uncertain])
        self._uncertain = np.concatenate(uncertain)
        self._variances = its.covariance.diagonal()  # a view: the filter writes its belief where it stood
        self._believed = its.mean.take(self._states)
        self._spread = self._variances.take(self._uncertain)
        self._innovation = (0.0, 0.0)
        self._mean_columns, self._spread_columns = recorder.block(signals.BELIEVED), recorder.block(signals.SPREAD)
        self._innovation_columns = recorder.block(signals.INNOVATION)
        self._recorder = recorder
        self._latest: Vector | None = None  # newest reading of every sensor
        self._fresh: Vector | None = None  # the same, NaN where nothing came since the last step of the belief

    def see(self, reading: Vector) -> None:
        """Take a reading; an entry that is NaN brings nothing new."""
        if self._latest is None:
            self._latest = reading
            # What the pressures were before anything was read is not known: the first reading stands for it.
            self._filter.held[: self._groups] = reading[self._pressure]
        elif not math.isnan(self._every.dot(reading)):  # as above
            self._latest = self._fresh = reading
        else:
            new = ~np.isnan(reading)
            self._latest = np.where(new, reading, self._latest)
            self._fresh = reading if self._fresh is None else np.where(new, reading, self._fresh)

    def believe(self) -> str | None:
        """Move the belief on over what was seen since it last moved; return what is wrong with it, if anything is."""
        assert self._fresh is not None
        assert self._latest is not None
        its = self._filter
        its.seen[:] = self._fresh.take(self._seen)
        try:
            its.advance()
        except ArithmeticError as diverged:
            return str(diverged)
        self._fresh = None
        its.held[: self._groups] = self._latest[self._pressure]
        self._innovation = (its.squared_innovation, np.add.reduce(its.used))
        self._believed = its.mean.take(self._states)
        self._spread = spread = self._variances.take(self._uncertain)
        if not np.minimum.reduce(spread) >= 0.0:
            return NEGATIVE
        return None

    def record(self, row: Vector) -> None:
        """Write the belief into a row."""
        row[self._mean_columns] = self._believed
        row[self._spread_columns] = self._spread
        row[self._innovation_columns] = self._innovation

    def complete(self, rows: Matrix) -> None:
        """Add to the rows of a stop what follows from the beliefs in them."""
        complete(rows, self._recorder, self._radius)

    def sight(self, time: float) -> Sight:
        """Return what the controller sees now; a sensor without a new reading shows its last one."""
        assert self._latest is not None
        speed, *believed = self._believed.tolist()
        groups = self._groups
        return Sight(
            time,
            speed,
            float(self._latest[self._acceleration]),
            _slips(speed, believed[:groups], self._radius),
            tuple(believed[groups : 2 * groups]),
            tuple(believed[2 * groups :]),
            tuple(self._latest[self._pressure].tolist()),
        )


def complete(rows: Matrix, recorder: Recorder, radius: tuple[float, ...]) -> None:
    """Add to the rows of a stop what follows from the beliefs in them: slips, and deviations for variances."""
    spread, columns = rows[:, recorder.block(signals.SPREAD)], recorder.columns
    np.sqrt(spread, out=spread)
    speed = rows[:, columns["estimate_speed"]]
    rolling = np.array(radius) * rows[:, columns["estimate_wheelset_speed"]]
    ratio = np.divide(rolling, speed, out=np.ones_like(rolling), where=speed >= _SMALL_SPEED)
    rows[:, columns["estimate_slip"]] = 1.0 - ratio


def _slips(speed: float, wheels: list[float], radius: tuple[float, ...]) -> tuple[float, ...]:
    if speed < _SMALL_SPEED:
        return (0.0,) * len(wheels)
    return tuple([1.0 - r * w / speed for r, w in zip(radius, wheels, strict=True)])
