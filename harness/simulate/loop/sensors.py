"""Sensors: from the true signals to readings, in the order of `railgrip.vehicle.signals.Layout`."""

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from railgrip.fmus.native.c_library import Struct
from railgrip.simulate.loop.library import kernel, rate_of
from railgrip.vehicle.signals import Layout

Vector = NDArray[np.float64]

BLOCK = 1024
"""Number of readings whose noise is drawn at once."""


class IdealSensors:
    """Readings are the plant's outputs.

    Attributes:
        places: Output that each entry of a reading is taken from.
    """

    def __init__(self, layout: Layout) -> None:
        places = [layout.output[name] for name in layout.reading]
        self.places = np.concatenate([np.arange(place.start, place.stop) for place in places])


class WhiteSensors:
    """Readings are the plant's outputs times a gain, plus a bias and noise that is white from sample to sample.

    Attributes:
        places: Output that each entry of a reading is taken from.
        gain, bias: Gain and bias of each entry, constant over a stop.
        noise: Noise of `BLOCK` samples from a multiple of it on, shape (BLOCK, readings).
        deviation: Standard deviation of the noise, shape (readings,).
    """

    def __init__(
        self,
        places: NDArray[np.intp],
        gain: Vector,
        bias: Vector,
        deviation: Vector,
        random: np.random.Generator,
        draws: int = 1,
    ) -> None:
        """Set up the sensors; `random` draws the noise, of the standard deviation of each entry.

        See `draw_block` for `draws`.
        """
        self.places, self.gain, self.bias = places, gain, bias
        self.noise = np.empty((BLOCK, deviation.size))
        self.deviation, self._random, self._draws = deviation, random, draws

    def draw(self) -> None:
        """Draw the noise of the next block; due before every sample that is a multiple of `BLOCK`."""
        draw_block(self.noise, self._random, self._draws)
        self.noise *= self.deviation

    def read(self, sample: int, truth: Vector) -> Vector:
        """Return the reading of a sample; samples are read in order, from 0 on."""
        if sample % BLOCK == 0:
            self.draw()
        return truth.take(self.places) * self.gain + self.bias + self.noise[sample % BLOCK]


@dataclass(frozen=True, slots=True)
class MissingTeeth:
    """Adjacent teeth that a pole wheel lacks, from sample `begin` to before sample `end`."""

    count: int = 0
    begin: int = 0
    end: int = 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrackQuantity:
    """A quantity along the track, linear between equidistant places and constant beyond its ends.

    Attributes:
        begin, step: First place, and distance between places [m].
        values: Shape (n,).
    """

    begin: float
    step: float
    values: Vector


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RoughRail:
    """A rail whose short waves deflect the primary suspension.

    Attributes:
        height: Height under the wheels, over the distance that the leading wheelset has covered [m].
        position: Distance of each wheelset behind the leading one, shape (wheelsets,) [m].
        forward, back: Coefficients b0, b1, b2 and a1, a2 of the digital filter from height to deflection.
        state: State of that filter at the first sample, shape (wheelsets, 2) [m].
    """

    height: TrackQuantity
    position: Vector
    forward: Vector
    back: Vector
    state: Vector


@dataclass(frozen=True, slots=True, kw_only=True)
class ServiceInstruments:
    """Instruments of a train in service.

    Attributes:
        pulses: Pulses of the wheel encoder per revolution.
        pitch_error: 1σ of a tooth's pitch over the pitch; repeats each revolution [1].
        clock: Tick of the clock that times the pulses [s].
        cut_off: Peripheral speed below which a wheel encoder reads zero [m/s].
        wheel_radius: Radius that converts `cut_off` to a rotational speed [m].
        speed_noise: 1σ of each reading of the train speed [m/s].
        speed_factor: Ratio of each reading to the train speed, in sequence and repeating; NaN where a reading is lost,
            shape (n,) [1].
        speed_rate: Samples between two readings of the train speed, not necessarily a whole number: one is due at
            the first sample at or after each multiple.
        speed_latency: Age of a reading of the train speed, in samples, interpolated between two of them; compensated
            with the acceleration reading.
        acceleration_noise: 1σ [m/s²].
        acceleration_bias: Constant over a stop [m/s²].
        deflection_noise: 1σ [m].
        pressure_offset: Offset of each transducer, constant over a stop, shape (groups,) [Pa].
        pressure_step: Resolution of the converter [Pa].
        pressure_lag: First-order time constant [s].
        missing_teeth: Missing teeth of each pole wheel; empty if all are complete.
        gravity: Component of gravity along the track, positive uphill, that the accelerometer reads [m/s²]; None if
            not.
        rail: Rail that affects the deflection; None if it does not.
    """

    pulses: int
    pitch_error: float
    clock: float
    cut_off: float
    wheel_radius: float
    speed_noise: float
    speed_factor: Vector
    speed_rate: Fraction | int
    speed_latency: float
    acceleration_noise: float
    acceleration_bias: float
    deflection_noise: float
    pressure_offset: Vector
    pressure_step: float
    pressure_lag: float
    missing_teeth: tuple[MissingTeeth, ...] = ()
    gravity: TrackQuantity | None = None
    rail: RoughRail | None = None


class ServiceSensors:
    """Pulse-timing wheel encoders, a speed sensor with rate and latency, accelerometer, travel and pressure sensors.

    Wheel encoders: in each sample the shaft turns on, and every tooth that passes is stamped with its time in ticks of
    the clock. The reading is the nominal angle between the last pulse of this sample and the last pulse before it, over
    the time between the two. Without a new pulse no new reading is made until the elapsed time is so long that even
    a pulse now would mean a speed below the cut-off: then the reading is zero. A missing tooth gives no pulse, and the
    electronics does not compensate for it.

    The formulas are in `kernel/sensors.c`. Noise is drawn in blocks from one generator, so the same seed gives the same
    readings. Samples are read in order, from 0 on. If instruments take several samples per reading, speeds and
    pressures in between are interpolated, and the newest reading is returned.

    Attributes:
        struct: `Service` of sensors.h.
        deviation: Standard deviation of the noise of speed, acceleration and each deflection.
    """

    def __init__(
        self,
        layout: Layout,
        instruments: ServiceInstruments,
        period: float,
        random: np.random.Generator,
        samples: int = 1,
    ) -> None:
        """Set up the sensors of a vehicle, read every `period` [s], in which the instruments take `samples` samples.

        Noise is drawn from `random`.
        """
        groups, past_count = layout.formation.groups, math.ceil(instruments.speed_latency) + 1
        self._random, self._draws, sampling = random, samples, period / samples
        intact = (MissingTeeth(),) * groups
        encoders = [_encoder(layout, instruments, sampling, random, gap) for gap in instruments.missing_teeth or intact]
        self.deviation = np.array(
            [instruments.speed_noise, instruments.acceleration_noise]
            + [instruments.deflection_noise] * layout.formation.wheelsets
        )
        self._noise = np.empty((BLOCK, self.deviation.size))
        self.struct = kernel(layout).struct("Service", encoder=encoders, noise=self._noise,
            offset_steps=instruments.pressure_offset / instruments.pressure_step,
            past_speed=np.empty(past_count), past_count=past_count, period=period,
            acceleration_bias=instruments.acceleration_bias, pressure_step=instruments.pressure_step,
            pressure_share=sampling / (instruments.pressure_lag + sampling), samples=samples,
            block=BLOCK, speed_rate=rate_of(layout, instruments.speed_rate), speed_latency=instruments.speed_latency,
            speed_factor=instruments.speed_factor, speed_factors=instruments.speed_factor.size,
        )  # fmt: skip
        if instruments.gravity is not None:
            self.struct.set(gravity=_track_quantity(layout, instruments.gravity))
        if (rail := instruments.rail) is not None:
            self.struct.set(
                rail=_track_quantity(layout, rail.height), position=rail.position, filter_state=rail.state,
                forward=rail.forward, back=rail.back,
            )  # fmt: skip

    def draw(self) -> None:
        """Draw the noise of the next block; due before every sample that is a multiple of `BLOCK`."""
        draw_block(self._noise, self._random, self._draws)
        self._noise *= self.deviation


def draw_block(noise: NDArray[np.float64], random: np.random.Generator, draws: int) -> None:
    """Fill `noise`, whose rows are readings, with the first of every `draws` rows that `random` draws.

    Noise is drawn at the period of the instruments, so a loop that reads only some of their samples gets the same noise
    at the same instants.
    """
    noise[:] = random.standard_normal((len(noise) * draws, *noise.shape[1:]))[::draws]


def _encoder(
    layout: Layout, instruments: ServiceInstruments, period: float, random: np.random.Generator, missing: MissingTeeth
) -> Struct:
    pitch = 2.0 * np.pi / instruments.pulses
    # Errors of the tooth positions, not of the gaps: the positions close after one revolution by construction. A gap is
    # the difference of two positions, so its variance is twice theirs.
    teeth = instruments.pitch_error * pitch / np.sqrt(2.0) * random.standard_normal(instruments.pulses)
    return kernel(layout).struct(
        "Encoder", teeth=teeth, pulses=instruments.pulses, pitch=pitch, clock=instruments.clock,
        period=period, angle=float(random.uniform(0.0, pitch)), stamp=-1.0,
        timeout=pitch * instruments.wheel_radius / max(instruments.cut_off, 1e-3),  # finite without a cut-off
        missing=missing.count, begin=missing.begin, end=missing.end,
    )  # fmt: skip


def _track_quantity(layout: Layout, quantity: TrackQuantity) -> Struct:
    return kernel(layout).struct(
        "TrackQuantity", values=quantity.values, begin=quantity.begin, step=quantity.step, count=quantity.values.size
    )
