"""From what loggers wrote during a run to what estimators are trained on.

A run at the loggers' rate is some hundred megabytes; kept are only the block means of the paper's chain and the
lateral and yaw acceleration at 128 samples a second, some hundred kilobytes.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from railgrip.estimators.belief import Array
from railgrip.estimators.learned.channels import Motion, forwards, motions
from railgrip.estimators.learned.preprocessing import BLOCKS, AntiAlias, Chain
from railgrip.estimators.learned.spectral import Spectral
from railgrip.studies.axle_box.accelerometer import RATE
from railgrip.studies.axle_box.instrumented_car import MPH

SLOW: Final = AntiAlias(rate=RATE, keep=40)
SPECTRAL: Final = Spectral(rate=SLOW.slow_rate)
CHANNELS: Final[Mapping[Motion, slice]] = {
    "longitudinal": slice(0, 4), "lateral": slice(4, 8), "yaw": slice(8, 12), "left": slice(12, 16),
    "right": slice(16, 20),
}  # fmt: skip
"""Columns of `Run.blocks` by motion."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """What the loggers wrote during one run.

    Attributes:
        left, right, lateral: m/s², shape (n, 4), in axes of the car.
        speed: m/s, shape (n,).
        backwards: Whether the fourth wheelset led.
        rate: Samples a second.
    """

    left: Array
    right: Array
    lateral: Array
    speed: Array
    backwards: bool
    rate: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """One labelled run, reduced.

    Attributes:
        name: Unique.
        group: Speed class, mph.
        speed: Mean, m/s.
        friction: The label.
        blocks: Of the paper's chain, columns as in `CHANNELS`, m/s², shape (n, 20).
        settled: The same with the high-pass started at the mean of the first second.
        slow: Lateral and yaw acceleration at the rate of `SLOW`, in axes that point forwards, m/s², and the speed,
            m/s, shape (m, 9).
        slope: Of the creep curve over that of a clean contact, which only a simulated run knows.
    """

    name: str
    group: int
    speed: float
    friction: float
    blocks: Array
    settled: Array
    slow: Array
    slope: float | None = None


def reduce(name: str, friction: float, readings: Readings) -> Run:
    """Return a run as estimators are trained on it."""
    speed = float(np.mean(np.abs(readings.speed)))
    group = speed_class(speed)
    boxes = readings.left, readings.right, readings.lateral
    raw = np.hstack([motions(*boxes, "longitudinal, lateral, yaw"), motions(*boxes, "left, right")])
    chain = Chain(rate=readings.rate, block=BLOCKS[group])
    steady = Chain(rate=readings.rate, block=BLOCKS[group], start="first second")
    return Run(
        name=name, group=group, speed=speed, friction=friction,
        blocks=chain.process(raw), settled=steady.process(raw), slow=slow_signals(readings),
    )  # fmt: skip


def speed_class(speed: float) -> int:
    """Return the nearest of the paper's speeds, mph, for a speed in m/s."""
    return min(BLOCKS, key=lambda mph: abs(mph * MPH - speed))


def slow_signals(readings: Readings) -> Array:
    """Return lateral and yaw acceleration at the slow rate in axes that point forwards, and speed, shape (m, 9)."""
    slow = SLOW(np.hstack([readings.lateral, readings.right - readings.left]))
    lateral, yaw = forwards(slow[:, :4], slow[:, 4:], backwards=readings.backwards)
    return np.column_stack([lateral, yaw, SLOW.every(readings.speed)])
