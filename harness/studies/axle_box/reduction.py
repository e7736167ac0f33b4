"""Recordings of axle-box accelerometers for a true acceleration, and their reduction to the data of estimators.

Effects of the sensors are offset, drift and noise, the resonance of the plate, and the vibration of rolling wheels,
which a rigid-body vehicle does not have. Values are estimates for a DC-coupled sensor of the class of the 7533A4; the
range of offsets is that of Abduraxman et al. (2024).

A run at the rate of the loggers has some hundred megabytes. A reduced run has the block means of the paper's chain and
lateral and yaw acceleration at 128 samples a second, some hundred kilobytes.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, lfilter, sosfilt

from railgrip.base.arrays import generator
from railgrip.campaign.work import Work
from railgrip.estimation.judge import rms
from railgrip.estimators.belief import Array
from railgrip.estimators.learned.preprocessing import (
    BLOCKS,
    AntiAlias,
    Chain,
    Motion,
    Spectral,
    lateral_and_yaw,
    motions,
)
from railgrip.studies.axle_box.instrumented_car import MPH, Pass, Ride, ride, slope
from railgrip.studies.axle_box.instrumented_car import RATE as CAR_RATE

RATE: Final = 5120
"""Sampling rate of the paper's loggers [Hz]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AxleBoxAccelerometer:
    """An accelerometer on its plate.

    Attributes:
        offset: Lowest and highest offset, m/s².
        drift: Standard deviation of the drift within a run, m/s² a second.
        walk: Random walk of the offset, m/s² a square root of a second.
        noise: Density of white noise, m/s²/√Hz.
        gain_error: Relative standard deviation of the gain.
        plate_frequency: Resonance of the plate, Hz; plate_damping: its damping ratio.
        rolling: Vibration of rolling wheels above 50 Hz, m/s² a m/s of speed.
    """

    offset: tuple[float, float] = (266.0, 272.0)
    drift: float = 5e-3
    walk: float = 2e-3
    noise: float = 5e-3
    gain_error: float = 0.01
    plate_frequency: float = 640.0
    plate_damping: float = 0.05
    rolling: float = 0.1


AXLE_BOX: Final = AxleBoxAccelerometer()


def measure(
    true: Array,
    true_rate: int,
    speed: float,
    sensor: AxleBoxAccelerometer,
    vehicle: np.random.Generator,
    run: np.random.Generator,
) -> Array:
    """Return the recording of the loggers at `RATE`, m/s².

    Args:
        true: Accelerations, m/s², shape (n, channels).
        true_rate: Of `true`, samples a second; `RATE` is a multiple of it.
        speed: m/s.
        vehicle: Draws the properties of the sensors: offsets and gains.
        run: Draws what varies from run to run: drift and noise.
    """
    fine = _fine(true, true_rate)
    channels = fine.shape[1]
    rolling = run.standard_normal(fine.shape) * sensor.rolling * speed
    gain = 1 + sensor.gain_error * vehicle.standard_normal(channels)
    time = np.arange(len(fine)) / RATE
    after = vehicle.uniform(*sensor.offset, channels) + time[:, None] * (sensor.drift * run.standard_normal(channels))
    after += np.cumsum(run.standard_normal(fine.shape), axis=0) * (sensor.walk / np.sqrt(RATE))
    after += run.standard_normal(fine.shape) * (sensor.noise * np.sqrt(RATE / 2))
    before = np.asarray(sosfilt(butter(2, 50, "highpass", fs=RATE, output="sos"), rolling, axis=0), dtype=np.float64)
    return _plate(fine + before, sensor) * gain + after


def _fine(true: Array, rate: int) -> Array:
    if RATE % rate:
        raise ValueError(f"accelerometers sample {RATE} times a second, which is not a multiple of {rate}.")
    fine = np.arange((len(true) - 1) * (RATE // rate) + 1) / (RATE // rate)
    return np.asarray(CubicSpline(np.arange(len(true)), true)(fine), dtype=np.float64)


def plate(sensor: AxleBoxAccelerometer) -> tuple[Array, Array]:
    """Return numerator and denominator of a plate with one resonance and a gain of 1 at rest (bilinear)."""
    w = np.tan(np.pi * sensor.plate_frequency / RATE)
    a = np.array([1 + 2 * sensor.plate_damping * w + w**2, 2 * (w**2 - 1), 1 - 2 * sensor.plate_damping * w + w**2])
    b = np.array([1.0, 2.0, 1.0]) * w**2
    return b / a[0], a / a[0]


def _plate(signal: Array, sensor: AxleBoxAccelerometer) -> Array:
    b, a = plate(sensor)
    # The plate starts settled at the first sample; its gain at rest is 1.
    last = b[2] - a[2]
    rest = np.array([b[1] - a[1] + last, last])[:, None] * signal[0]
    return np.asarray(lfilter(b, a, signal, axis=0, zi=rest)[0], dtype=np.float64)


SLOW: Final = AntiAlias(rate=RATE, keep=40)
SPECTRAL: Final = Spectral(rate=SLOW.slow_rate)
CHANNELS: Final[Mapping[Motion, slice]] = {
    "longitudinal": slice(0, 4), "lateral": slice(4, 8), "yaw": slice(8, 12), "left": slice(12, 16),
    "right": slice(16, 20),
}  # fmt: skip
"""Columns of `LabelledRun.blocks` by motion."""

OTHER_CHAINS: Final[Mapping[str, Callable[[Chain], Mapping[str, Any]]]] = {
    "first second is zero": lambda _: {"start": "first second"},
    "without the high-pass": lambda _: {"high_pass": 0.0},
    "offset kept": lambda _: {"high_pass": 0.0, "start": "offset"},
    "blocks a fifth as long": lambda chain: {"block": chain.block // 5},
    "blocks five times as long": lambda chain: {"block": 5 * chain.block},
}
"""Variants of the paper's chain by name → their values of `Chain`."""


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
        other_blocks: The same by each of `OTHER_CHAINS`.
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
    other_blocks: Mapping[str, Array]
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
        other_blocks={name: replace(chain, **changes(chain)).process(raw) for name, changes in OTHER_CHAINS.items()},
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
