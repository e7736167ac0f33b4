"""Axle-box accelerometers: recordings of the loggers for a true acceleration.

Effects are offset, drift and noise of the sensor, the resonance of its plate, and the vibration of rolling wheels,
which a rigid-body vehicle does not have. Values are estimates for a DC-coupled sensor of the class of the 7533A4; the
range of offsets is that of Abduraxman et al. (2024).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, lfilter, sosfilt

from railgrip.estimators.belief import Array

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
