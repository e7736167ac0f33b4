"""The Python engine: any mix of parties, sample by sample. It is the reference for faster ones."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from controllers.sight import Sight
from estimators.belief import Estimate
from harness.loop.edge import COMMAND, FORCE, FRICTION, INPUTS, OUTPUT, OUTPUTS
from harness.loop.ports import Actuation, Controller, Estimator, Plant, Rail, Sensors
from harness.loop.sensors import READING
from harness.record.outcome import Outcome
from harness.record.recorder import Recorder
from harness.record.signals import GROUPS

Vector = NDArray[np.float64]
Array = NDArray[np.intp]


@dataclass(frozen=True, slots=True, kw_only=True)
class Clock:
    """Integer time: everything happens at whole multiples of the communication period.

    Attributes:
        period: Communication period [s].
        estimator: Communication periods between two steps of the estimator.
        controller: The same for the controller.
        samples: Communication periods until the horizon.
    """

    period: float
    estimator: int
    controller: int
    samples: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Believer:
    """An estimator, its first belief, and where its states and readings stand.

    Attributes:
        filter: Steps the belief.
        first: Before any brake was applied.
        seen: Entries of a reading that the filter takes, in its order.
        speed: Index of the train speed among the states.
        wheelset_speed: Indices of the wheelset speeds.
        pad_friction: Indices of the pad frictions.
        adhesion: Indices of the adhesions.
        inputs: Number of the filter's inputs: pressures first, the rest (track force) is not known to the train.
        wheel_radius: As the estimator believes it, one for each group [m].
    """

    filter: Estimator
    first: Estimate
    seen: Array
    inputs: int
    speed: int
    wheelset_speed: Array
    pad_friction: Array
    adhesion: Array
    wheel_radius: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How a run of the loop ended.

    Attributes:
        outcome: The kind of end.
        reason: In one sentence.
        samples: Rows written.
    """

    outcome: Outcome
    reason: str
    samples: int


_SMALL_SPEED = 0.05
"""Speed [m/s] below which slip is not formed: over the last millimetres it is a ratio of two noises."""


def run(
    *,
    plant: Plant,
    rail: Rail,
    sensors: Sensors,
    believer: Believer | None,
    controller: Controller,
    actuation: Actuation,
    wheel_radius: tuple[float, ...],
    clock: Clock,
    stop_speed: float,
    recorder: Recorder,
    progress: Callable[[float], None] | None = None,
) -> Ended:
    """Brake until the train stands, the horizon is reached, or a party fails in a way that is a result.

    Each sample: the plant moves on under the commands held since the last one; sensors read; the estimator, when due,
    predicts under the pressures read a sample before and conditions on the new reading; the controller, when due,
    decides. The row of a sample holds the truth at its end, the reading and belief then, and what was sent for it.

    Args:
        plant: Not yet started.
        rail: Friction and force along the track.
        sensors: Instruments.
        believer: None if the controller sees readings only.
        controller: The law.
        actuation: From demanded pressure to the plant's command.
        wheel_radius: Nominal radii for a slip from readings [m].
        clock: Periods and horizon.
        stop_speed: The train stands below this speed [m/s].
        recorder: Written from row 0 on; holds clock.samples + 1 rows.
        progress: Called with the train speed [m/s] every 0.25 s of simulated time.

    Raises:
        PlantFailed: The plant refused a step; `recorder` holds the rows before.
    """
    rows, columns = recorder.rows, recorder.columns
    truth_columns = slice(0, OUTPUTS)
    sent = _Columns(columns, "mu0", "track_force", "command")
    read = slice(columns["reading_speed"].start, columns["reading_cylinder_pressure"].stop)
    period = clock.period
    report_every = max(round(0.25 / period), 1)
    at_speed, at_distance = OUTPUT["speed"].start, OUTPUT["distance"].start

    inputs = np.zeros(INPUTS)
    inputs[FRICTION] = rail.mu0(0.0, 0.0)
    inputs[FORCE] = rail.force(0.0)
    truth = plant.start(inputs)
    watch = _Watch(believer, wheel_radius, columns)
    reading = sensors.read(0, truth)
    time, distance, speed = 0.0, float(truth[at_distance]), float(truth[at_speed])
    for k in range(clock.samples + 1):
        if k > 0:
            truth = plant.step(inputs)
            reading = sensors.read(k, truth)
        watch.see(reading)
        time, distance, speed = k * period, float(truth[at_distance]), float(truth[at_speed])
        if believer is not None and k > 0 and k % clock.estimator == 0:
            problem = watch.believe()
            if problem:
                return Ended(outcome=Outcome.DIVERGED, reason=f"{problem} At {time:.3f} s.", samples=k)
        row = rows[k]
        row[truth_columns] = truth
        row[sent.mu0] = inputs[FRICTION]
        row[sent.track_force] = inputs[FORCE]
        row[sent.command] = inputs[COMMAND]
        row[read] = reading
        watch.record(row)
        if k % clock.controller == 0:
            sight = watch.sight(time)
            demands = controller.decide(sight)
            command = actuation.command(demands, sight.pressure)
            if not all(map(math.isfinite, command)):
                return Ended(
                    outcome=Outcome.CONTROLLER_FAILED,
                    reason=f"The controller's command at {time:.3f} s is {command}, not four numbers.",
                    samples=k + 1,
                )
            inputs[COMMAND] = command
        if speed <= stop_speed:
            return Ended(
                outcome=Outcome.STANDSTILL, reason=f"Stopped after {distance:.2f} m and {time:.3f} s.", samples=k + 1
            )
        if progress is not None and k % report_every == 0:
            progress(speed)
        inputs[FRICTION] = rail.mu0(time, distance)
        inputs[FORCE] = rail.force(distance)
    return Ended(
        outcome=Outcome.HORIZON,
        reason=f"Still moving at {speed:.2f} m/s after {clock.samples * period:g} s and {distance:.1f} m.",
        samples=clock.samples + 1,
    )


class _Columns:
    """Columns of a row that the loop writes each sample."""

    __slots__ = ("command", "mu0", "track_force")

    def __init__(self, columns: Mapping[str, slice], mu0: str, track_force: str, command: str) -> None:
        self.mu0 = columns[mu0]
        self.track_force = columns[track_force].start
        self.command = columns[command]


class _Watch:
    """What is seen and believed, from sample to sample: the last readings and the belief."""

    def __init__(
        self, believer: Believer | None, wheel_radius: tuple[float, ...], columns: Mapping[str, slice]
    ) -> None:
        self._believer = believer
        self._estimate = believer.first if believer is not None else None
        self._radius = believer.wheel_radius if believer is not None else wheel_radius
        self._columns = columns
        self._slip = (0.0,) * GROUPS
        self._latest: Vector | None = None  # newest reading of every sensor
        self._fresh: Vector | None = None  # the same, NaN where nothing came since the last step of the belief
        self._held = np.zeros(GROUPS)
        if believer is not None:
            n = len(believer.first.mean)
            self._diagonal = np.concatenate([believer.adhesion, believer.pad_friction]) * (n + 1)
            self._held = np.zeros(believer.inputs)

    def see(self, reading: Vector) -> None:
        """Take a reading; an entry that is NaN brings nothing new."""
        if self._latest is None:
            self._latest = reading
            # What the pressures were before anything was read is not known: the first reading stands for it.
            self._held[:GROUPS] = reading[READING["cylinder_pressure"]]
            return
        new = ~np.isnan(reading)
        whole = bool(new.all())
        self._latest = reading if whole else np.where(new, reading, self._latest)
        self._fresh = reading if whole or self._fresh is None else np.where(new, reading, self._fresh)

    def believe(self) -> str | None:
        """Step the belief over what was seen since its last step; return what is wrong with it, if anything is."""
        believer, estimate, fresh, latest = self._believer, self._estimate, self._fresh, self._latest
        assert believer is not None
        assert estimate is not None
        assert fresh is not None
        assert latest is not None
        try:
            self._estimate = estimate = believer.filter.step(estimate, self._held, fresh[believer.seen])
        except ArithmeticError as diverged:
            return str(diverged)
        self._fresh = None
        self._held[:GROUPS] = latest[READING["cylinder_pressure"]]
        variances = estimate.covariance.ravel()[self._diagonal]
        if not variances.min() >= 0.0:
            return "The estimator diverged: a variance is negative or not a number."
        return None

    def record(self, row: Vector) -> None:
        """Write the belief into a row."""
        believer, estimate = self._believer, self._estimate
        if believer is None or estimate is None:
            return
        mean, columns = estimate.mean, self._columns
        speed = float(mean[believer.speed])
        wheels = mean[believer.wheelset_speed].tolist()
        self._slip = _slips(speed, wheels, self._radius)
        deviations = np.sqrt(estimate.covariance.ravel()[self._diagonal])
        row[columns["estimate_speed"]] = speed
        row[columns["estimate_slip"]] = self._slip
        row[columns["estimate_adhesion"]] = mean[believer.adhesion]
        row[columns["estimate_pad_friction"]] = mean[believer.pad_friction]
        row[columns["estimate_adhesion_sd"]] = deviations[:GROUPS]
        row[columns["estimate_pad_friction_sd"]] = deviations[GROUPS:]

    def sight(self, time: float) -> Sight:
        """Return what the controller sees now; a sensor without a new reading shows its last one."""
        assert self._latest is not None
        values = self._latest.tolist()
        pressure = tuple(values[READING["cylinder_pressure"]])
        acceleration = values[READING["acceleration"].start]
        believer, estimate = self._believer, self._estimate
        if believer is None or estimate is None:
            slip = _slips(values[0], values[READING["wheelset_speed"]], self._radius)
            return Sight(time, values[0], acceleration, slip, None, None, pressure)
        mean = estimate.mean
        return Sight(
            time,
            float(mean[believer.speed]),
            acceleration,
            self._slip,
            tuple(mean[believer.adhesion].tolist()),
            tuple(mean[believer.pad_friction].tolist()),
            pressure,
        )


def _slips(speed: float, wheels: list[float], radius: tuple[float, ...]) -> tuple[float, ...]:
    if speed < _SMALL_SPEED:
        return (0.0,) * len(wheels)
    return tuple(1.0 - r * w / speed for r, w in zip(radius, wheels, strict=True))
