"""The instruments of a train in service."""

import math
from collections.abc import Mapping
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, StrictBool, StrictInt

from railgrip.base.arrays import generator, markov
from railgrip.base.errors import ScenarioError
from railgrip.fmus.native.toolchain import Struct
from railgrip.kernel import kernel, rate_of
from railgrip.scenario.onboard import SampledSensors, steps_between
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Deviation, Duration, Lag, Period, Table, optional, table_error
from railgrip.scenario.track import Track, gravity_along, slope_of
from railgrip.simulate.faults.sensor import missing_teeth
from railgrip.simulate.loop.interfaces import BLOCK, draw_block
from railgrip.vehicle.signals import Layout

_PERIOD = 1e-3
"""Sampling period of the instruments of a train in service [s]."""

_OFF = "an error of this size is a failure"
SpeedError = Annotated[float, UnitRange("m/s", between=(0, 100), usual=(0.0, 3.0), because=_OFF)]
AccelerationError = Annotated[float, UnitRange("m/s2", between=(0, 1000), usual=(0.0, 3.0), because=_OFF)]
TravelError = Annotated[float, UnitRange("m", between=(0, 1), usual=(0.0, 0.01), because=_OFF)]

Tick = Annotated[
    float, UnitRange("s", above=0, at_most=1, usual=(1e-9, 1e-3), because="a clock that ticks so rarely times no pulse")
]


class WheelEncoder(Table):
    """Pulse-timing encoder of each independent wheelset."""

    pulses: Annotated[StrictInt, Field(ge=1, le=10000)] = Field(description="pulses per revolution")
    pitch_error: Deviation = Field(description="1σ error of a tooth's pitch over the pitch; repeats each revolution")
    clock: Tick = Field(description="tick of the clock that times the pulses")
    cut_off: SpeedError = Field(description="speed below which it reads zero")


class SpeedSensor(Table):
    """Speed over ground: Doppler radar or GNSS, which differ by the numbers below."""

    noise: SpeedError = Field(description="1σ, white, each reading")
    scale_error: Deviation = Field(description="1σ of the relative error, drawn once a stop")
    scale_offset: Annotated[float, UnitRange("1", between=(-0.5, 0.5), usual=(-0.1, 0.1), because=_OFF)] = Field(
        default=0.0, description="relative error of every stop, which adds to the drawn one"
    )
    period: Period = Field(description="between two readings")
    latency: Lag = Field(description="from the moment that is read to the reading")
    drift: Deviation = optional("1σ of a relative error that wanders, a Gauss-Markov process", default=0.0)
    drift_time: Duration | None = optional("over which the autocorrelation of the drift falls to 1/e")
    dropouts: Annotated[float, UnitRange("1", at_least=0, below=1)] = optional(
        "share of the time without readings", default=0.0
    )
    dropout_time: Duration | None = optional("mean length of a drop-out")

    def _check(self) -> None:
        for name, time in (("drift", self.drift_time), ("dropouts", self.dropout_time)):
            if bool(getattr(self, name)) != (time is not None):
                raise table_error(f"{name} and {name.removesuffix('s')}_time belong together; give both or neither")


class Accelerometer(Table):
    """Longitudinal acceleration of the car body."""

    noise: AccelerationError = Field(description="1σ, white, each reading")
    bias: AccelerationError = Field(description="1σ, drawn once a stop")
    feels_gradient: StrictBool = optional(
        "whether it reads the gravity along the track at the leading wheelset, too", default=False
    )


class RailUnderWheels(Table):
    """Irregularities of the track under the wheels, as the frames of the bogies answer to them."""

    track: Literal["erri-low", "erri-high", "fra-4", "fra-5", "fra-6"] = Field(
        description="published spectrum of the height: ERRI B176, or classes of the FRA"
    )
    frequency: Annotated[float, UnitRange("Hz", above=0, at_most=100)] = Field(
        description="natural frequency of a frame on its primary suspension"
    )
    damping: Annotated[float, UnitRange("1", above=0, at_most=2)] = Field(description="damping ratio of that")


class DeflectionSensor(Table):
    """Travel of the primary suspension at each wheelset."""

    noise: TravelError = Field(description="1σ, white, each reading")
    irregularity: RailUnderWheels | None = optional("what the sensor shows of an uneven track")


class PressureTransducer(Table):
    """Cylinder pressure of each group."""

    full_scale: Annotated[
        float, UnitRange("Pa", between=(1e3, 1e8), usual=(3e5, 5e7), because="brake cylinders hold some bar")
    ] = Field(description="highest pressure that it can show")
    error: Deviation = Field(description="1σ of the offset over full scale, drawn once a stop")
    bits: Annotated[StrictInt, Field(ge=4, le=24)] = Field(description="of the converter, over full scale")
    lag: Lag = Field(description="first-order time constant")

    @property
    def step(self) -> float:
        """Resolution of the converter [Pa]."""
        return self.full_scale / float(np.exp2(self.bits))


class Service(SampledSensors):
    """Sensors as a train in service may have them."""

    kind: Literal["service"]
    wheel: WheelEncoder
    speed: SpeedSensor
    acceleration: Accelerometer
    deflection: DeflectionSensor
    pressure: PressureTransducer

    @property
    def pulses(self) -> int:
        """Teeth of each pole wheel."""
        return self.wheel.pulses

    @property
    def pressure_lag(self) -> float:
        """Time constant of the readings of the cylinder pressure [s]."""
        return self.pressure.lag

    def sampled_every(self, communication: float) -> int:
        """Return the communication steps [s] between two readings."""
        return max(round((self.period or _PERIOD) / communication), 1)

    def samples_in(self, communication: float) -> int:
        """Return the number of samples that the instruments take per communication step [s], of which the loop reads
        one.
        """
        return max(round(communication / (self.period or _PERIOD)), 1)

    def open(self, scenario: Scenario, layout: Layout, wheel_radius: float) -> "ServiceSensors":
        """Return the sensors of a stop; errors that are constant over a stop are drawn here."""
        communication, groups, seed = scenario.periods.communication, layout.formation.groups, scenario.seed
        period, samples = communication * self.sampled_every(communication), self.samples_in(communication)
        sampling, random, lot = period / samples, self.random(seed, "noise"), self.random(seed, "lot")
        speed, pressure, latency = self.speed, self.pressure, _in_samples(self.speed.latency, period)
        scale = speed.scale_error * float(lot.standard_normal())
        factor = _speed_factor(speed, scale, period, scenario.horizon, self.random(seed, "speed"))
        bias = self.acceleration.bias * float(lot.standard_normal())
        offset, step = pressure.error * pressure.full_scale * lot.standard_normal(groups), pressure.step
        missing = missing_teeth(scenario.faults, self.wheel.pulses, groups, sampling, scenario.horizon)
        past, noise = np.empty(math.ceil(latency) + 1), np.empty((BLOCK, 2 + layout.formation.wheelsets))
        struct = kernel(layout).struct("Service", noise=noise, block=BLOCK, period=period, samples=samples,
            encoder=[encoder(layout, self.wheel, wheel_radius, sampling, random, **gap) for gap in missing],
            speed_rate=rate_of(layout, steps_between(speed.period, period)),
            speed_factor=factor, speed_factors=factor.size, speed_latency=latency, acceleration_bias=bias,
            past_speed=past, past_count=past.size,
            offset_steps=offset / step, pressure_step=step, pressure_share=sampling / (pressure.lag + sampling),
        )  # fmt: skip
        if self.acceleration.feels_gradient:
            reach = scenario.start.speed * scenario.horizon
            struct.set(gravity=_gravity(layout, scenario.track, scenario.truth.gradient, reach))
        if self.deflection.irregularity is not None:
            struct.set(**_rough_rail(scenario, self.deflection.irregularity, layout, period))
        deviation = [speed.noise, self.acceleration.noise] + [self.deflection.noise] * layout.formation.wheelsets
        return ServiceSensors(struct, noise, np.array(deviation), random, samples)


class ServiceSensors:
    """Pulse-timing wheel encoders, a speed sensor with rate and latency, accelerometer, travel and pressure sensors.

    Wheel encoders: in each sample the shaft turns on, and every tooth that passes is stamped with its time in ticks of
    the clock. The reading is the nominal angle between the last pulse of this sample and the last pulse before it, over
    the time between the two. Without a new pulse no new reading is made until the elapsed time is so long that even
    a pulse now would mean a speed below the cut-off: then the reading is zero. A missing tooth gives no pulse, and the
    electronics does not compensate for it.

    The formulas are in `kernel/sensors.c`. Noise is drawn in blocks from one generator, so the same seed gives
    the same readings. Samples are read in order, from 0 on. If instruments take several samples per reading, speeds and
    pressures in between are interpolated, and the newest reading is returned.

    Attributes:
        struct: `Service` of sensors.h.
        deviation: Standard deviation of the noise of speed, acceleration and each deflection.
        fields: Fields of `Instruments` in cycle.h.
    """

    def __init__(
        self, struct: Struct, noise: NDArray[np.float64], deviation: NDArray[np.float64],
        random: np.random.Generator, draws: int,
    ) -> None:  # fmt: skip
        """Draw the noise of `struct` from `random`; see `draw_block` for `draws`."""
        self.struct, self.deviation = struct, deviation
        self.fields: Mapping[str, object] = {"service": struct}
        self._noise, self._random, self._draws = noise, random, draws

    def draw(self) -> None:
        """Draw the noise of the next block; due before every sample that is a multiple of `BLOCK`."""
        draw_block(self._noise, self._random, self._draws)
        self._noise *= self.deviation


def encoder(
    layout: Layout, wheel: WheelEncoder, wheel_radius: float, period: float, random: np.random.Generator, **gap: int
) -> Struct:
    """Return the encoder of one pole wheel, `Encoder` of sensors.h.

    Args:
        layout: Layout of the vehicle.
        wheel: Table of the encoder.
        wheel_radius: Radius that converts its cut-off to a rotational speed [m].
        period: Sampling period [s].
        random: Generator of the errors of its teeth and of its first angle.
        gap: Missing teeth, see `missing_teeth`.
    """
    pitch = 2.0 * np.pi / wheel.pulses
    # Errors of the tooth positions, not of the gaps: the positions close after one revolution by construction. A gap is
    # the difference of two positions, so its variance is twice theirs.
    teeth = wheel.pitch_error * pitch / np.sqrt(2.0) * random.standard_normal(wheel.pulses)
    return kernel(layout).struct(
        "Encoder", teeth=teeth, pulses=wheel.pulses, pitch=pitch, clock=wheel.clock,
        period=period, angle=float(random.uniform(0.0, pitch)), stamp=-1.0,
        timeout=pitch * wheel_radius / max(wheel.cut_off, 1e-3), **gap,  # finite without a cut-off
    )  # fmt: skip


def _in_samples(time: float, period: float) -> float:
    """Return a time in periods [s], rounded if it differs from a whole number by rounding errors only."""
    samples = time / period
    return float(round(samples)) if math.isclose(samples, round(samples), rel_tol=1e-9) else samples


def _speed_factor(
    table: SpeedSensor, scale: float, period: float, horizon: float, random: np.random.Generator
) -> NDArray[np.float64]:
    fixed = 1.0 + (table.scale_offset + scale)
    if not table.drift and not table.dropouts:
        return np.array([fixed])
    every = max(table.period, period)
    count = int(horizon / every) + 2
    factor = np.full(count, fixed)
    if table.drift_time is not None:
        factor += table.drift * markov(random.standard_normal(count), math.exp(-every / table.drift_time))
    if table.dropout_time is not None:
        # A Markov chain of two states, whose stay in the second lasts dropout_time on average, in its steady state.
        returns = min(every / table.dropout_time, 1.0)
        fails = min(returns * table.dropouts / (1.0 - table.dropouts), 1.0)
        silent = random.uniform() < table.dropouts
        for i, chance in enumerate(random.uniform(size=count)):
            if silent:
                factor[i] = np.nan
            silent = chance >= returns if silent else chance < fails
    return factor


def _track_quantity(layout: Layout, begin: float, step: float, values: NDArray[np.float64]) -> Struct:
    return kernel(layout).struct("TrackQuantity", values=values, begin=begin, step=step, count=values.size)


def _gravity(layout: Layout, track: Track, gradient: float, reach: float) -> Struct:
    """Return the component of gravity along the track that an accelerometer reads, positive uphill.

    A change of slope is spread over 0.1 m.

    Args:
        layout: Layout of the vehicle.
        track: Track of the scenario.
        gradient: Slope in addition to those of the track.
        reach: Distance that the train may cover [m].
    """
    step, begin = 0.1, 0.0
    end = min(max((begin for begin, _ in track.slopes), default=0.0), reach)  # a line from a file may go on for long
    if (plan := track.plan) is not None:
        begin, end = sorted(plan.way * (edge - plan.start) for edge in (0.0, plan.alignment().length))
        step = 1.0
    places = np.arange(begin, end + 2.0 * step, step)
    slope = slope_of(track)
    slopes = np.array([slope(min(place, end)) for place in places.tolist()]) + gradient
    return _track_quantity(layout, begin, step, gravity_along(slopes))


_LONGEST_RAIL = 5000.0
"""Length of the irregularities [m]; beyond it the rail is even."""
_FINE = 0.02
"""Distance between two points of a rail [m]: a sixtieth of its shortest wave."""
_LEAD_IN = 2.0
"""Time for which a frame has been rolling before the stop begins [s]."""


def _rough_rail(scenario: Scenario, table: RailUnderWheels, layout: Layout, period: float) -> dict[str, object]:
    """Return the rail whose irregularities affect the deflections, as fields of `Service` in sensors.h.

    A frame on its primary suspension moves as z̈ = ω² (r - z) + 2 ζ ω (ṙ - ż) over the height r under a wheelset; the
    reading is r - z.

    Raises:
        ScenarioError: The positions of the wheelsets are not given.
    """
    if not layout.formation.wheelset_position:
        raise ScenarioError(
            "[sensors.deflection.irregularity] needs the positions of the wheelsets: give "
            "[vehicle.formation] wheelset_position"
        )
    from scipy.signal import bilinear, lfilter

    from railgrip.scenario.track_geometry import realise

    position = np.array(layout.formation.wheelset_position)
    lead_in = scenario.start.speed * _LEAD_IN
    begin = -float(position.max()) - lead_in
    length = min(scenario.start.speed * scenario.horizon, _LONGEST_RAIL) - begin
    rail = realise(table.track, length, generator(scenario.seed, f"track.{table.track}"), kinds=("vertical",))
    height = rail.at("vertical", np.arange(0.0, length, _FINE))
    omega = 2.0 * math.pi * table.frequency
    filter_ = bilinear([1.0, 0.0, 0.0], [1.0, 2.0 * table.damping * omega, omega**2], fs=1.0 / period)
    forward, back = (np.asarray(part, dtype=np.float64) for part in filter_)
    travel = np.arange(-lead_in, 0.0, scenario.start.speed * period)
    before = np.interp(travel[:, None] - position, begin + _FINE * np.arange(height.size), height)
    _, state = lfilter(forward, back, before, axis=0, zi=np.zeros((2, position.size)))
    return {
        "rail": _track_quantity(layout, begin, _FINE, height), "position": position, "forward": forward,
        "back": back[1:], "filter_state": np.ascontiguousarray(state.T),
    }  # fmt: skip
