"""Sensors with white noise, constant errors and a GNSS receiver."""

import math
from collections.abc import Collection, Mapping
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from railgrip.base.errors import ScenarioError, SensorsFailed
from railgrip.scenario.onboard import SampledSensors, steps_between
from railgrip.scenario.quantity import Magnitude, UnitRange, in_units
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Deviation, Duration, Period, Table
from railgrip.scenario.track import Plan, Track, gravity_along, slope_of
from railgrip.simulate.loop.interfaces import BLOCK, draw_block
from railgrip.vehicle.signals import EXTRA_READINGS, READINGS, Layout, Signal

GNSS = ("latitude", "longitude", "height")
"""Quantities that a receiver reads."""

_SOURCE = {"acceleration_along": "acceleration"} | dict.fromkeys(GNSS, "distance")
"""Output of the plant for a quantity that has another name, or is derived from it."""

_ALL = {signal.name.removeprefix("reading_"): signal for signal in (*READINGS, *EXTRA_READINGS)}

_PlaceError = Annotated[float, UnitRange("m", between=(0, 1000), because="an error of this size is a failure")]


class Gnss(Table):
    """A GNSS receiver with carrier phases in the middle of the train: small white errors plus a slowly wandering one.

    North, east and height each have both errors; the wandering one is a Gauss-Markov process.
    """

    period: Period = Field(description="between two readings")
    horizontal: _PlaceError = Field(description="1σ of either, white, each reading")
    height: _PlaceError = Field(description="1σ, white, each reading")
    horizontal_wander: _PlaceError = Field(description="1σ of either")
    height_wander: _PlaceError = Field(description="1σ")
    wander_time: Duration = Field(description="over which the autocorrelation of the wander falls to 1/e")


class White(SampledSensors):
    """Readings are the plant's outputs with errors, every sample; a quantity that no table names has no error.

    Quantities are those that every train reads (speed, wheelset_speed, deflection, acceleration, cylinder_pressure) and
    any other output of the plant, such as pad_force: once it is named, the trace has it as reading_pad_force. Others
    are acceleration_along, of an accelerometer over each group that also reads the gradient, and latitude, longitude
    and height by GNSS, NaN between its readings.
    """

    kind: Literal["white"]
    noise: dict[str, Magnitude] = Field(default={}, description="1σ of each quantity, white from sample to sample")
    bias: dict[str, Magnitude] = Field(default={}, description="1σ of each quantity, drawn once a stop for each sensor")
    scale: dict[str, Deviation] = Field(default={}, description="1σ of the relative error, drawn once a stop")
    gnss: Gnss | None = Field(default=None, description="satellite receiver; needs [track.plan]")

    @property
    def named(self) -> frozenset[str]:
        """Quantities with errors."""
        receiver = () if self.gnss is None else GNSS
        return frozenset((*self.noise, *self.bias, *self.scale, *receiver))

    def extra_readings(self, outputs: Collection[str]) -> tuple[Signal, ...]:
        """Return the signals of the named quantities that other kinds of sensors do not read.

        Raises:
            ScenarioError: A named quantity does not exist, or is not an output of the plant.
        """
        unknown = sorted(self.named - set(_ALL))
        absent = sorted(self.named - set(unknown) - set(outputs) - set(_SOURCE))
        if unknown or absent:
            problem = f"there is no quantity {unknown[0]}" if unknown else f"the plant does not show {absent[0]}"
            choice = ", ".join(name for name in _ALL if name in outputs or name in _SOURCE)
            raise ScenarioError(f"[sensors]: {problem}; there is {choice}")
        return tuple(signal for name, signal in _ALL.items() if name in self.named and signal in EXTRA_READINGS)

    def open(self, scenario: Scenario, layout: Layout, wheel_radius: float) -> "WhiteSensors | TrackSensors":
        """Return the sensors of a stop; errors that are constant over a stop are drawn here."""

        def each(values: Mapping[str, float]) -> NDArray[np.float64]:
            vector = np.zeros(layout.readings)
            for name, value in values.items():
                if name not in layout.reading:
                    raise ScenarioError(
                        f"[sensors] names '{name}', which this plant does not show; its sensors read "
                        f"{', '.join(layout.reading)}"
                    )
                vector[layout.reading[name]] = value
            return vector

        def available(name: str) -> NDArray[np.intp]:
            source, at = layout.output[_SOURCE.get(name, name)], layout.reading[name]
            return source.start + np.arange(at.stop - at.start) % (source.stop - source.start)

        communication, lot = scenario.periods.communication, self.random(scenario.seed, "lot")
        white = WhiteSensors(
            np.concatenate([available(name) for name in layout.reading]),
            1.0 + each(self.scale) * lot.standard_normal(layout.readings),
            each(_deviations("bias", self.bias)) * lot.standard_normal(layout.readings),
            each(_deviations("noise", self.noise)),
            self.random(scenario.seed, "noise"),
            self.samples_in(communication),
        )
        if not _SOURCE.keys() & layout.reading.keys():
            return white
        receiver = None
        if self.gnss is not None and scenario.track.plan is not None:
            period = communication * self.sampled_every(communication)
            receiver = _Receiver(self.gnss, scenario.track.plan, period, self.random(scenario.seed, "gnss"))
        return TrackSensors(white, layout, scenario.track, receiver)


class WhiteSensors:
    """Readings are the plant's outputs times a gain, plus a bias and noise that is white from sample to sample.

    Attributes:
        places: Output that each entry of a reading is taken from.
        gain, bias: Gain and bias of each entry, constant over a stop.
        noise: Noise of `BLOCK` samples from a multiple of it on, shape (BLOCK, readings).
        deviation: Standard deviation of the noise, shape (readings,).
        fields: Fields of `Instruments` in cycle.h.
    """

    def __init__(
        self,
        places: NDArray[np.intp],
        gain: NDArray[np.float64],
        bias: NDArray[np.float64],
        deviation: NDArray[np.float64],
        random: np.random.Generator,
        draws: int = 1,
    ) -> None:
        """Set up the sensors; `random` draws the noise, of the standard deviation of each entry.

        See `draw_block` for `draws`.
        """
        self.places, self.gain, self.bias = places, gain, bias
        self.noise = np.empty((BLOCK, deviation.size))
        self.deviation, self._random, self._draws = deviation, random, draws
        self.fields: Mapping[str, object] = {"output_at": places, "gain": gain, "bias": bias, "noise": self.noise}

    def draw(self) -> None:
        """Draw the noise of the next block; due before every sample that is a multiple of `BLOCK`."""
        draw_block(self.noise, self._random, self._draws)
        self.noise *= self.deviation

    def read(self, sample: int, truth: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the reading of a sample; samples are read in order, from 0 on."""
        if sample % BLOCK == 0:
            self.draw()
        return truth.take(self.places) * self.gain + self.bias + self.noise[sample % BLOCK]


class TrackSensors:
    """White sensors, accelerometers that read the gradient, and a GNSS receiver."""

    def __init__(self, white: WhiteSensors, layout: Layout, track: Track, receiver: "_Receiver | None") -> None:
        """Add the effects of a track to `white`."""
        self._white, self._slope, self._receiver = white, slope_of(track), receiver
        self._distance = layout.output["distance"].start
        self._along, self._position = layout.reading.get("acceleration_along"), slice(0, 0)
        formation = layout.formation
        behind = np.zeros(formation.wheelsets) if formation.position is None else formation.position
        # Each group has its accelerometer in the middle of its wheelsets.
        self._behind = [float(behind[members].mean()) for members in formation.members()]
        if receiver is not None:
            self._position = slice(layout.reading[GNSS[0]].start, layout.reading[GNSS[-1]].stop)

    def read(self, sample: int, truth: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the reading of a sample; samples are read in order, from 0 on.

        Raises:
            SensorsFailed: The train has left its track.
        """
        reading, distance = self._white.read(sample, truth), float(truth[self._distance])
        if self._along is not None:
            reading[self._along] += gravity_along([self._slope(distance - behind) for behind in self._behind])
        if self._receiver is not None:
            reading[self._position] = self._receiver.read(sample, distance)
        return reading


class _Receiver:
    def __init__(self, table: Gnss, track: Plan, period: float, random: np.random.Generator) -> None:
        self._track, self._plan, self._random = track, track.alignment().plan(), random
        self._every = steps_between(table.period, period)
        self._keeps = math.exp(-table.period / table.wander_time)
        self._wander = self._random.standard_normal(3)
        self._wanders = np.array([table.horizontal_wander, table.horizontal_wander, table.height_wander])
        self._white = np.array([table.horizontal, table.horizontal, table.height])

    def read(self, sample: int, distance: float) -> NDArray[np.float64]:
        """Return latitude, longitude [deg] and height [m], NaN without a new reading."""
        if sample // self._every == (sample - 1) // self._every:
            return np.full(3, np.nan)
        place, length = float(self._track.place(distance)), self._plan.track.length
        if not 0.0 <= place <= length:
            raise SensorsFailed(
                f"The train has left its track at {place:.0f} m of [track.plan], which is {length:g} m long; move its "
                "start, or lay more."
            )
        if sample:
            fresh = math.sqrt(1.0 - self._keeps**2)
            self._wander = self._keeps * self._wander + fresh * self._random.standard_normal(3)
        north, east, up = self._wander * self._wanders + self._white * self._random.standard_normal(3)
        latitude, longitude, height = self._plan.positions(place)
        # The radii of the sphere are within 0.4 % of the ellipsoid's: less than a millimetre for the wander.
        metre = math.degrees(1.0 / 6.371e6)
        return np.array(
            [latitude + north * metre, longitude + east * metre / math.cos(math.radians(latitude)), height + up]
        )


def _deviations(table: str, magnitudes: Mapping[str, Magnitude]) -> dict[str, float]:
    where = f"[sensors.{table}]"
    values = in_units(where, magnitudes, {name: signal.unit for name, signal in _ALL.items()})
    negative = next((name for name, value in values.items() if value < 0.0), None)
    if negative is not None:
        raise ScenarioError(f"{where} {negative} is a standard deviation and not negative, got {values[negative]:g}")
    return values
