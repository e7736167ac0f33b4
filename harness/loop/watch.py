"""What a train knows of itself from sample to sample: its newest readings and, with an estimator, its belief."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from railgrip import signals
from railgrip.controllers.observation import Observation
from railgrip.errors import EstimatorFailed
from railgrip.loop.ports import Calculation, DirectEstimator, Filter
from railgrip.signals import Layout
from railgrip.trace.recorder import Recorder

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Indices = NDArray[np.intp]

_SMALL_SPEED = 0.05
"""Speed [m/s] below which slip is not formed: over the last millimetres it is a ratio of two noises."""

_UNKNOWN_SPEED = 1.0
"""Deviation of a wheel speed at the rim [m/s] above which its estimate is no knowledge: the sensor is silent."""

NEGATIVE = "The estimator diverged: a variance is negative or not a number."


@dataclass(frozen=True, slots=True, kw_only=True)
class StateEstimator:
    """An estimator that holds its first belief, and where its states and readings stand.

    Attributes:
        filter: Its inputs are the pressures first; the rest (track force) is not known to the train and stays zero.
        reading_places: Entries of a reading that the filter takes, in its order.
        speed: Index of the train speed among the states.
        wheelset_speed: Indices of the wheelset speeds.
        adhesion: Indices of the adhesions.
        pad_friction: Indices of the pad frictions.
        wheel_radius: As the estimator believes it, one for each group [m].
        free_wheel: Given the reading of the speed, those of the wheelset speeds and of the pressures, returns the
            speed that the filter takes, and 1 for each group that is to be released; None where nobody stands in for
            the radar.
        load_deviation: Standard deviation of a wheelset's load over the one that the filter knows.
    """

    filter: Filter
    reading_places: Indices
    speed: int
    wheelset_speed: Indices
    adhesion: Indices
    pad_friction: Indices
    wheel_radius: tuple[float, ...]
    free_wheel: Calculation | None = None
    load_deviation: float = 0.0


class Readings:
    """A train without an estimator.

    Attributes:
        driver_demand: Pressures that the driver asks for now, shape (groups,) [Pa]; written by the loop.
    """

    def __init__(self, layout: Layout, wheel_radius: tuple[float, ...], driver_demand: Vector) -> None:
        """See nothing yet."""
        self.driver_demand = driver_demand
        at = layout.reading
        self._speed, self._acceleration = at["speed"].start, at["acceleration"].start
        self._wheels, self._pressure = at["wheelset_speed"], at["cylinder_pressure"]
        self._every, self._radius = np.ones(layout.readings), np.array(wheel_radius)
        self._latest: Vector | None = None

    def see(self, reading: Vector) -> None:
        """Take a reading; where it is NaN the last one goes on."""
        # The sum is NaN exactly when an entry is: readings are far too small to overflow.
        if self._latest is None or not math.isnan(self._every.dot(reading)):
            self._latest = reading
        else:
            self._latest = np.where(np.isnan(reading), self._latest, reading)

    def believe(self, time: float) -> str | None:
        """Estimate anew at a time [s]; return what is wrong with that, if anything is."""

    def release(self, demands: Sequence[float]) -> Sequence[float]:
        """Return demanded pressures [Pa], none of groups that are to be released."""
        return demands

    def record(self, row: Vector) -> None:
        """Write nothing."""

    def complete(self, rows: Matrix) -> None:
        """Add nothing."""

    def observation(self, time: float) -> Observation:
        """Return what the controller is shown now."""
        latest = self._latest
        assert latest is not None
        speed, wheels = float(latest[self._speed]), latest[self._wheels]
        slip = _slips(speed, wheels, self._radius)
        acceleration = float(latest[self._acceleration])
        pressure, demand = latest[self._pressure], self.driver_demand
        return Observation(time, speed, acceleration, wheels, slip, False, None, None, pressure, demand)


class DirectEstimates(Readings):
    """A train with an estimator that gives quantities themselves; the rest is as it is read."""

    def __init__(
        self,
        layout: Layout,
        estimator: DirectEstimator,
        wheel_radius: tuple[float, ...],
        recorder: Recorder,
        driver_demand: Vector,
    ) -> None:
        """See nothing yet."""
        super().__init__(layout, wheel_radius, driver_demand)
        self._estimator = estimator
        self._columns = {name: recorder.columns[f"estimate_{name}"] for name in estimator.provides}
        self._values: Mapping[str, Vector] = {}
        self._replacements: dict[str, Any] = {}

    def believe(self, time: float) -> str | None:
        """Estimate anew at a time [s]; return what is wrong with that, if anything is."""
        try:
            self._values = values = self._estimator.step(super().observation(time))
        except EstimatorFailed as failed:
            return str(failed)
        self._replacements = {name: value for name, value in values.items() if name in Observation._fields}
        if "speed" in values:
            self._replacements["speed"] = float(values["speed"][0])
        if "slip" in values:
            self._replacements["slip_is_estimated"] = True
        return None

    def record(self, row: Vector) -> None:
        """Write the estimates into a row."""
        for name, columns in self._columns.items():
            row[columns] = self._values[name]

    def observation(self, time: float) -> Observation:
        """Return what the controller is shown now."""
        return super().observation(time)._replace(**self._replacements)


class Beliefs:
    """A train with an estimator.

    The believed speeds, adhesions and pad frictions go into a row as they stand in the belief, with variances; what
    follows from them is computed for all rows at once in `complete`.

    Attributes:
        driver_demand: As of `Readings`.
    """

    def __init__(
        self, layout: Layout, state_estimator: StateEstimator, recorder: Recorder, driver_demand: Vector
    ) -> None:
        """See nothing yet, and believe what the filter does."""
        self.driver_demand, self._state_estimator = driver_demand, state_estimator
        self._groups, self._every = layout.formation.groups, np.ones(layout.readings)
        self._acceleration, self._pressure = layout.reading["acceleration"].start, layout.reading["cylinder_pressure"]
        self._filter = filter_ = state_estimator.filter
        self._radius, self._reading_places = np.array(state_estimator.wheel_radius), state_estimator.reading_places
        uncertain = [state_estimator.adhesion, state_estimator.pad_friction]
        self._states = np.concatenate([[state_estimator.speed], state_estimator.wheelset_speed, *uncertain])
        self._uncertain = np.concatenate(uncertain)
        self._variances = filter_.covariance.diagonal()  # a view: the filter writes its belief where it stood
        self._means = filter_.mean.take(self._states)
        self._spread = self._variances.take(self._uncertain)
        self._wheels, self._unknown = state_estimator.wheelset_speed, (_UNKNOWN_SPEED / self._radius) ** 2
        self._free_wheel, at = state_estimator.free_wheel, layout.reading
        self._reading_speed, self._reading_wheels = at["speed"].start, at["wheelset_speed"]
        self._reference: Sequence[float] = (math.nan,) + (0.0,) * self._groups
        if self._free_wheel is not None:
            self._reference_columns = recorder.block(signals.REFERENCE)
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
            self._filter.inputs[: self._groups] = reading[self._pressure]
        elif not math.isnan(self._every.dot(reading)):  # as above
            self._latest = self._fresh = reading
        else:
            new = ~np.isnan(reading)
            self._latest = np.where(new, reading, self._latest)
            self._fresh = reading if self._fresh is None else np.where(new, reading, self._fresh)

    def believe(self, time: float) -> str | None:
        """Move the belief on over what was seen since it last moved; return what is wrong with it, if anything is."""
        if self._fresh is None:  # the first sample: the belief is the one that the filter begins with
            return None
        assert self._latest is not None
        filter_, fresh = self._filter, self._fresh
        if self._free_wheel is not None:
            wheels, pressures = self._latest[self._reading_wheels], self._latest[self._pressure]
            self._reference = self._free_wheel.call(
                [float(fresh[self._reading_speed]), *wheels.tolist(), *pressures.tolist()]
            )
            fresh = fresh.copy()
            fresh[self._reading_speed] = self._reference[0]
        filter_.readings[:] = fresh.take(self._reading_places)
        try:
            filter_.advance()
        except ArithmeticError as diverged:
            return str(diverged)
        self._fresh = None
        filter_.inputs[: self._groups] = self._latest[self._pressure]
        self._innovation = (filter_.squared_innovation, np.add.reduce(filter_.selection))
        self._means = filter_.mean.take(self._states)
        self._spread = spread = self._variances.take(self._uncertain)
        if not np.minimum.reduce(spread) >= 0.0:
            return NEGATIVE
        return None

    def release(self, demands: Sequence[float]) -> Sequence[float]:
        """Return demanded pressures [Pa], none of groups that are to be released."""
        releases = self._reference[1:]
        return [0.0 if off else demand for demand, off in zip(demands, releases, strict=True)]

    def record(self, row: Vector) -> None:
        """Write the belief into a row."""
        row[self._mean_columns] = self._means
        row[self._spread_columns] = self._spread
        row[self._innovation_columns] = self._innovation
        if self._free_wheel is not None:
            row[self._reference_columns] = self._reference

    def complete(self, rows: Matrix) -> None:
        """Add to the rows of a stop what follows from the beliefs in them."""
        complete(rows, self._recorder, self._state_estimator)

    def observation(self, time: float) -> Observation:
        """Return what the controller is shown now; a sensor without a new reading shows its last one."""
        latest, means, last = self._latest, self._means, 1 + self._groups
        assert latest is not None
        speed, wheels = float(means[0]), means[1:last]
        adhesion, pad_friction = means[last : last + self._groups], means[last + self._groups :]
        slip, acceleration = _slips(speed, wheels, self._radius), float(latest[self._acceleration])
        pressure = latest[self._pressure]
        demand = self.driver_demand
        wheels = np.where(self._variances.take(self._wheels) > self._unknown, np.nan, wheels)
        return Observation(time, speed, acceleration, wheels, slip, True, adhesion, pad_friction, pressure, demand)


def watch_of(
    layout: Layout,
    state_estimator: StateEstimator | DirectEstimator | None,
    wheel_radius: tuple[float, ...],
    recorder: Recorder,
    driver_demand: Vector,
) -> Readings | Beliefs:
    """Return what a train with this estimator, or with none, knows of itself; radii [m] are for slip from readings."""
    if state_estimator is None:
        return Readings(layout, wheel_radius, driver_demand)
    if isinstance(state_estimator, StateEstimator):
        return Beliefs(layout, state_estimator, recorder, driver_demand)
    return DirectEstimates(layout, state_estimator, wheel_radius, recorder, driver_demand)


def complete(rows: Matrix, recorder: Recorder, state_estimator: StateEstimator) -> None:
    """Add to the rows of a stop what follows from the beliefs in them: slips, and deviations for variances.

    Adhesion is a force that the readings tell over a load that they do not: its relative error is the load's as well.
    """
    spread, columns = rows[:, recorder.block(signals.SPREAD)], recorder.columns
    load_error = state_estimator.load_deviation * rows[:, columns["estimate_adhesion"]]
    rows[:, columns["estimate_adhesion_sd"]] += load_error**2
    np.sqrt(spread, out=spread)
    speed = rows[:, columns["estimate_speed"]]
    rolling = np.asarray(state_estimator.wheel_radius) * rows[:, columns["estimate_wheelset_speed"]]
    ratio = np.divide(rolling, speed, out=np.ones_like(rolling), where=speed >= _SMALL_SPEED)
    rows[:, columns["estimate_slip"]] = 1.0 - ratio


def _slips(speed: float, wheels: Vector, radius: Vector) -> Vector:
    if speed < _SMALL_SPEED:
        return np.zeros(len(wheels))
    return 1.0 - radius * wheels / speed
