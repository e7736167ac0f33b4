"""Reduction of the recordings of loggers to the data that estimators are trained on.

A run at the rate of the loggers has some hundred megabytes. A reduced run has the block means of the paper's chain and
lateral and yaw acceleration at 128 samples a second, some hundred kilobytes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from railgrip.base.arrays import generator
from railgrip.campaign.work import Work
from railgrip.estimation.judge import rms
from railgrip.estimators.belief import Array
from railgrip.estimators.learned.preprocessing import BLOCKS, AntiAlias, Chain, Motion, lateral_and_yaw, motions
from railgrip.estimators.learned.spectral import Spectral
from railgrip.studies.axle_box.accelerometer import AXLE_BOX, RATE, measure
from railgrip.studies.axle_box.instrumented_car import MPH, Pass, Ride, ride, slope
from railgrip.studies.axle_box.instrumented_car import RATE as CAR_RATE

SLOW: Final = AntiAlias(rate=RATE, keep=40)
SPECTRAL: Final = Spectral(rate=SLOW.slow_rate)
CHANNELS: Final[Mapping[Motion, slice]] = {
    "longitudinal": slice(0, 4), "lateral": slice(4, 8), "yaw": slice(8, 12), "left": slice(12, 16),
    "right": slice(16, 20),
}  # fmt: skip
"""Columns of `LabelledRun.blocks` by motion."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """Recording of the loggers in one run, at `RATE`.

    Attributes:
        boxes: Accelerations in the order of `BOXES`, m/s², shape (n, 12), in axes of the car.
        speed: m/s, shape (n,).
        backwards: Whether the fourth wheelset leads.
    """

    boxes: Array
    speed: Array
    backwards: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class LabelledRun:
    """One labelled run, reduced.

    Attributes:
        name: Unique.
        group: Speed class, mph.
        speed: Mean, m/s.
        friction: The label.
        blocks: Of the paper's chain, columns as in `CHANNELS`, m/s², shape (n, 20).
        settled: The same with the high-pass started at the mean of the first second.
        slow: Lateral and yaw acceleration at the rate of `SLOW`, the leading wheelset first, m/s², and the speed, m/s,
            shape (m, 9).
        slope: Slope of the creep curve relative to that of a clean contact; known for simulated runs only.
        slip_acceleration: Rms of ẍ − ω̇r of the wheelsets [m/s²]; known for simulated runs only.
        slip_rate: Rms rate of change of the total creepage of the left wheels [1/s]; known for simulated runs only.
    """

    name: str
    group: int
    speed: float
    friction: float
    blocks: Array
    settled: Array
    slow: Array
    slope: float | None = None
    slip_rate: float | None = None
    slip_acceleration: float | None = None


def reduce(name: str, friction: float, readings: Readings) -> LabelledRun:
    """Return a run as estimators are trained on it."""
    speed = float(np.mean(np.abs(readings.speed)))
    group = speed_class(speed)
    combinations = ("longitudinal, lateral, yaw", "left, right")
    raw = np.stack(
        [channel for combination in combinations for channel in motions(readings.boxes.T, combination)], axis=-1
    )
    chain = Chain(rate=RATE, block=BLOCKS[group])
    lateral, yaw = lateral_and_yaw(SLOW, readings.boxes, backwards=readings.backwards)
    return LabelledRun(
        name=name,
        group=group,
        speed=speed,
        friction=friction,
        blocks=chain.process(raw),
        settled=replace(chain, start="first second").process(raw),
        slow=np.column_stack([lateral, yaw, SLOW.every(readings.speed)]),
    )


def speed_class(speed: float) -> int:
    """Return the nearest of the paper's speeds, mph, for a speed in m/s."""
    return min(BLOCKS, key=lambda mph: abs(mph * MPH - speed))


VEHICLE: Final = 7
"""Seed of the properties of the sensors: the car has the same accelerometers in every run."""


def measure_run(run: Pass, motion: Ride, rate: int, speed: float) -> Readings:
    """Measure the motion of a run, sampled at `rate` a second; rolling wheels vibrate the boxes as at `speed`, m/s."""
    true = np.hstack([motion.longitudinal[:, :, 0], motion.longitudinal[:, :, 1], motion.lateral])
    sensors, noise = generator(VEHICLE, "sensors"), generator(run.seed, f"{run.name}.sensors")
    boxes = measure(true, rate, speed, AXLE_BOX, vehicle=sensors, run=noise)
    samples = np.arange(len(boxes)) * (rate / RATE)
    travelled = np.interp(samples, np.arange(len(motion.speed)), motion.speed)
    return Readings(boxes=boxes, speed=travelled, backwards=run.backwards)


EVERY: Final = 20.0
"""Distance between the spectral features that are kept, m."""
SETTLED: Final = 60.0
"""Distance before the first of them, m."""


def spectral_features(run: LabelledRun) -> Array:
    """Return features every `EVERY` metres after the first `SETTLED` metres, shape (m, features)."""
    speed = run.slow[:, 8]
    every = SPECTRAL.features(run.slow[:, :4], run.slow[:, 4:8], speed)
    metres = np.cumsum(np.abs(speed)) / SPECTRAL.rate
    first, last = max(SETTLED, 2 * SPECTRAL.settling * run.speed), metres[-1]
    return every[np.searchsorted(metres, np.arange(min(first, last), last, EVERY))]


def gather(passes: Sequence[Pass], work: Work) -> list[LabelledRun]:
    """Return the reduced runs of passes."""
    # Longest first, so that no worker begins a long one at the end.
    order = sorted(passes, key=lambda passage: passage.speed / passage.length)
    run_of_pass = dict(zip(order, work.map(run_of, order), strict=True))
    return [replace(run_of_pass[passage], slope=slope(passage)) for passage in passes]


def run_of(run: Pass) -> LabelledRun:
    """Simulate, measure and reduce a pass."""
    motion = ride(run)
    reduced = reduce(run.name, run.friction, measure_run(run, motion, CAR_RATE, float(motion.speed.mean())))
    return replace(
        reduced,
        slip_rate=rms(np.diff(motion.creep, axis=0) * CAR_RATE),
        slip_acceleration=rms(motion.slip_acceleration),
    )
