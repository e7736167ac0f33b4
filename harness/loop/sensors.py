"""Sensors: the truth as the train sees it.

A reading is a vector in the order of `READING`: the outputs of the larger prediction model and, behind them, the
brake cylinder pressures. An entry is NaN where the sensor has nothing new at that sample.
"""

from collections import deque
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from harness.loop.edge import OUTPUT
from harness.record.signals import GROUPS, WHEELSETS

Vector = NDArray[np.float64]

READING = MappingProxyType(
    {
        "speed": slice(0, 1),
        "wheelset_speed": slice(1, 1 + GROUPS),
        "deflection": slice(1 + GROUPS, 1 + GROUPS + WHEELSETS),
        "acceleration": slice(1 + GROUPS + WHEELSETS, 2 + GROUPS + WHEELSETS),
        "cylinder_pressure": slice(2 + GROUPS + WHEELSETS, 2 + 2 * GROUPS + WHEELSETS),
    }
)
READINGS = 2 + 2 * GROUPS + WHEELSETS

_SPEED, _ACCELERATION = OUTPUT["speed"].start, OUTPUT["acceleration"].start
_WHEELSET_SPEED, _DEFLECTION, _PRESSURE = (OUTPUT[n] for n in ("wheelset_speed", "deflection", "cylinder_pressure"))
_FROM = np.concatenate([np.arange(OUTPUT[name].start, OUTPUT[name].stop) for name in READING])


class IdealSensors:
    """Readings are the plant's outputs."""

    def read(self, sample: int, truth: Vector) -> Vector:
        """Return the truth, in the order of a reading."""
        return truth.take(_FROM)


@dataclass(frozen=True, slots=True, kw_only=True)
class ServiceInstruments:
    """Instruments as a train in service may have them.

    Attributes:
        pulses: Of the wheel encoder, per revolution.
        pitch_error: 1σ of a tooth's pitch over the pitch; repeats each revolution [1].
        clock: Tick of the clock that times the pulses [s].
        cut_off: Peripheral speed below which a wheel encoder reads zero [m/s].
        wheel_radius: To turn `cut_off` into a rotational speed [m].
        speed_noise: 1σ of each reading of the train speed [m/s].
        speed_scale: Relative error of the train speed, constant over a stop [1].
        speed_every: Samples between two readings of the train speed.
        speed_latency: Age of a reading of the train speed, in samples; made up for by the acceleration read.
        acceleration_noise: 1σ [m/s²].
        acceleration_bias: Constant over a stop [m/s²].
        deflection_noise: 1σ [m].
        pressure_offset: Of each transducer, constant over a stop, shape (groups,) [Pa].
        pressure_step: Of the converter [Pa].
        pressure_lag: First-order time constant [s].
    """

    pulses: int
    pitch_error: float
    clock: float
    cut_off: float
    wheel_radius: float
    speed_noise: float
    speed_scale: float
    speed_every: int
    speed_latency: int
    acceleration_noise: float
    acceleration_bias: float
    deflection_noise: float
    pressure_offset: Vector
    pressure_step: float
    pressure_lag: float


class ServiceSensors:
    """Pulse-timing wheel encoders, a speed sensor with its rate and latency, accelerometer, travel and pressure.

    Noise is drawn in blocks from one generator, so that the same seed gives the same readings.
    """

    _BLOCK = 1024
    _NOISES = 2 + WHEELSETS  # train speed, acceleration, one per deflection

    def __init__(self, instruments: ServiceInstruments, period: float, random: np.random.Generator) -> None:
        """Read every `period` [s], with noise from `random`."""
        self._instruments = instruments
        self._period = period
        self._random = random
        self._noise = np.empty((0, self._NOISES))
        self._encoders = [Encoder(instruments, period, random) for _ in range(GROUPS)]
        self._past: deque[float] = deque(maxlen=instruments.speed_latency + 1)
        self._pressure: Vector | None = None
        its = instruments
        self._deviation = np.array([its.speed_noise, its.acceleration_noise] + [its.deflection_noise] * WHEELSETS)
        self._share = period / (its.pressure_lag + period)
        self._offset_steps = its.pressure_offset / its.pressure_step

    def read(self, sample: int, truth: Vector) -> Vector:
        """Return the reading of a sample."""
        its = self._instruments
        row = sample % self._BLOCK
        if row == 0:
            self._noise = self._random.standard_normal((self._BLOCK, self._NOISES)) * self._deviation
        noise = self._noise[row]
        speed_noise, acceleration_noise = noise[:2].tolist()
        reading = np.empty(READINGS)

        acceleration = float(truth[_ACCELERATION]) + its.acceleration_bias + acceleration_noise
        self._past.append(float(truth[_SPEED]))
        if sample % its.speed_every == 0 and len(self._past) > its.speed_latency:
            late = self._past[0] * (1.0 + its.speed_scale) + speed_noise
            # The latency is known from the data sheet: the sensor's own electronics carries its reading forward.
            reading[0] = late + acceleration * its.speed_latency * self._period
        else:
            reading[0] = np.nan

        turning = zip(self._encoders, truth[_WHEELSET_SPEED].tolist(), strict=True)
        reading[READING["wheelset_speed"]] = [encoder.read(sample, speed) for encoder, speed in turning]
        reading[READING["deflection"]] = truth[_DEFLECTION] + noise[2:]
        reading[READING["acceleration"]] = acceleration
        reading[READING["cylinder_pressure"]] = self._transduce(truth[_PRESSURE])
        return reading

    def _transduce(self, pressure: Vector) -> Vector:
        its = self._instruments
        if self._pressure is None:
            self._pressure = pressure.copy()
        else:
            self._pressure += (pressure - self._pressure) * self._share
        return np.rint(self._pressure / its.pressure_step + self._offset_steps) * its.pressure_step


class Encoder:
    """A pole wheel whose pulses are timed.

    Each sample the shaft has turned on; every tooth that passed is stamped with its time, on the ticks of the clock.
    The reading is the nominal angle between the last pulse of this sample and the last pulse before it over the time
    between the two. Without a new pulse there is no new reading, until so much time has passed that even one pulse
    now would mean less than the cut-off: then the reading is zero.
    """

    def __init__(self, instruments: ServiceInstruments, period: float, random: np.random.Generator) -> None:
        """Mount a pole wheel at a random angle."""
        its = instruments
        self._pitch = 2.0 * np.pi / its.pulses
        # Errors of the tooth positions, not of the gaps: they close after one revolution by construction.
        self._teeth = (its.pitch_error * self._pitch / np.sqrt(2.0) * random.standard_normal(its.pulses)).tolist()
        self._pulses = its.pulses
        self._clock = its.clock
        self._period = period
        self._angle = float(random.uniform(0.0, self._pitch))
        self._count = 0  # of the last tooth seen
        self._stamp = -1.0  # its time; negative before the first pulse
        self._silence = self._pitch * its.wheel_radius / max(its.cut_off, 1e-3)
        self._speed = 0.0

    def read(self, sample: int, speed: float) -> float:
        """Return the reading at a sample [rad/s], from the true speed then; NaN without a new pulse."""
        time = sample * self._period
        if sample == 0:
            self._speed = speed
            return speed  # the encoder has been running before the stop began
        before, turned = self._angle, 0.5 * (self._speed + speed) * self._period
        self._speed = speed
        self._angle = before + turned
        last = int(self._angle / self._pitch)
        # A tooth stands at count·pitch + error; the error is a small share of the pitch, so only neighbours can be due.
        while last > self._count and last * self._pitch + self._teeth[last % self._pulses] > self._angle:
            last -= 1
        if last <= self._count:
            silent = self._stamp < 0.0 or time - self._stamp > self._silence
            return 0.0 if silent and self._stamp >= 0.0 else float("nan")
        passed = last * self._pitch + self._teeth[last % self._pulses]
        moment = time - self._period * (1.0 - (passed - before) / turned)
        stamp = round(moment / self._clock) * self._clock
        previous, teeth = self._stamp, last - self._count
        self._stamp, self._count = stamp, last
        if previous < 0.0 or stamp <= previous:
            return float("nan")
        return teeth * self._pitch / (stamp - previous)
