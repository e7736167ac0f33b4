"""The instruments of a scenario, drawn from its seed."""

import math
from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from railgrip.assemble.faults import missing_teeth
from railgrip.errors import ScenarioError, SensorsFailed
from railgrip.loop.parts import Instruments
from railgrip.loop.sensors import Course, IdealSensors, RoughRail, ServiceInstruments, ServiceSensors, WhiteSensors
from railgrip.scenario.custom import Custom
from railgrip.scenario.quantity import Magnitude, in_units
from railgrip.scenario.schema import Scenario
from railgrip.scenario.seed import generator
from railgrip.scenario.sensors import GNSS, Gnss, RailUnderWheels, SpeedSensor, sampled_every
from railgrip.scenario.sensors import IdealSensors as IdealTable
from railgrip.scenario.sensors import WhiteSensors as WhiteTable
from railgrip.scenario.track import gravity_along, slope_of
from railgrip.signals import EXTRA_READINGS, READINGS, Layout, Signal

_ALL = {signal.name.removeprefix("reading_"): signal for signal in (*READINGS, *EXTRA_READINGS)}


def readings_of(scenario: Scenario, outputs: Collection[str]) -> tuple[Signal, ...]:
    """Return what the sensors of a scenario show.

    Args:
        outputs: Names of what the plant shows.

    Raises:
        ScenarioError: A quantity is named that is none, or that the plant does not show.
    """
    table = scenario.sensors
    if not isinstance(table, WhiteTable):
        return READINGS
    unknown = sorted(table.named - set(_ALL))
    absent = sorted(table.named - set(unknown) - set(outputs) - set(_SOURCE))
    if unknown or absent:
        problem = f"there is no quantity {unknown[0]}" if unknown else f"the plant does not show {absent[0]}"
        choice = ", ".join(name for name in _ALL if name in outputs or name in _SOURCE)
        raise ScenarioError(f"{scenario.name}: [sensors]: {problem}; there is {choice}")
    return (*READINGS, *(signal for name, signal in _ALL.items() if name in table.named and signal in EXTRA_READINGS))


def sensors_of(scenario: Scenario, layout: Layout, wheel_radius: float) -> Instruments:
    """Return the sensors of a scenario; what is constant over a stop is drawn here."""
    table, missing = scenario.sensors, missing_teeth(scenario, layout.formation)
    if isinstance(table, IdealTable):
        return IdealSensors(layout)
    if isinstance(table, Custom):
        raise ScenarioError(f"{scenario.name}: [sensors] kind '{table.kind}' is no sensor model of this project")
    if isinstance(table, WhiteTable):
        return _white(scenario, table, layout)
    period = scenario.periods.communication * sampled_every(table, scenario.periods.communication)
    lot = generator(scenario.seed, "sensors.lot")
    instruments = ServiceInstruments(
        pulses=table.wheel.pulses,
        pitch_error=table.wheel.pitch_error,
        clock=table.wheel.clock,
        cut_off=table.wheel.cut_off,
        wheel_radius=wheel_radius,
        speed_noise=table.speed.noise,
        speed_factor=_speed_factor(
            scenario, table.speed, table.speed.scale_error * float(lot.standard_normal()), period
        ),
        speed_every=max(round(table.speed.period / period), 1),
        speed_latency=round(table.speed.latency / period),
        acceleration_noise=table.acceleration.noise,
        acceleration_bias=table.acceleration.bias * float(lot.standard_normal()),
        deflection_noise=table.deflection.noise,
        pressure_offset=table.pressure.error * table.pressure.full_scale * lot.standard_normal(layout.formation.groups),
        pressure_step=table.pressure.full_scale / float(np.exp2(table.pressure.bits)),
        pressure_lag=table.pressure.lag,
        missing_teeth=missing,
        gravity=_gravity(scenario) if table.acceleration.feels_gradient else None,
        rail=_rough_rail(scenario, table.deflection.irregularity, layout, period),
    )
    return ServiceSensors(layout, instruments, period, generator(scenario.seed, "sensors.noise"))


def _speed_factor(scenario: Scenario, table: SpeedSensor, scale: float, period: float) -> NDArray[np.float64]:
    """Return what a speed sensor makes of the speed at each of its readings; NaN in drop-outs."""
    fixed = 1.0 + (table.scale_offset + scale)
    if not table.drift and not table.dropouts:
        return np.array([fixed])
    every = max(round(table.period / period), 1) * period
    count = int(scenario.limits.horizon / every) + 2
    factor, random = np.full(count, fixed), generator(scenario.seed, "sensors.speed")
    if table.drift_time is not None:
        from scipy.signal import lfilter  # half a second to load, which most scenarios need not spend

        keeps = math.exp(-every / table.drift_time)
        fresh = random.standard_normal(count) * np.append(1.0, np.full(count - 1, math.sqrt(1.0 - keeps**2)))
        factor += table.drift * np.asarray(lfilter([1.0], [1.0, -keeps], fresh))
    if table.dropout_time is not None:
        # A chain of two states whose stay in the second lasts dropout_time on average, in its steady state.
        returns = min(every / table.dropout_time, 1.0)
        fails = min(returns * table.dropouts / (1.0 - table.dropouts), 1.0)
        silent = random.uniform() < table.dropouts
        for i, chance in enumerate(random.uniform(size=count)):
            if silent:
                factor[i] = np.nan
            silent = chance >= returns if silent else chance < fails
    return factor


def _gravity(scenario: Scenario) -> Course:
    """Return what an accelerometer along the track feels of its slopes; one that changes does so over 0.1 m."""
    track, step = scenario.track, 0.1
    begin, end = 0.0, max((section.begin for section in track.gradient), default=0.0)
    if (plan := track.plan) is not None:
        begin, end = sorted(plan.way * (edge - plan.start) for edge in (0.0, plan.laid().length))
        step = 1.0
    places = np.arange(begin, end + 2.0 * step, step)
    slope = slope_of(track)
    slopes = np.array([slope(min(place, end)) for place in places.tolist()]) + scenario.truth.gradient
    return Course(begin=begin, step=step, values=gravity_along(slopes))


_LONGEST_RAIL = 5000.0
"""m of irregularities; beyond them the rail is even."""
_FINE = 0.02
"""m between two places of a rail: a sixtieth of its shortest wave."""
_LEAD_IN = 2.0
"""s that a frame has been rolling before the stop begins."""


def _rough_rail(scenario: Scenario, table: RailUnderWheels | None, layout: Layout, period: float) -> RoughRail | None:
    """Return the rail that the deflections show.

    A frame on its primary suspension moves as z̈ = ω² (r - z) + 2 ζ ω (ṙ - ż) over the height r under a wheelset; read
    is r - z.

    Raises:
        ScenarioError: Nobody says where the wheelsets are.
    """
    if table is None:
        return None
    if not layout.formation.wheelset_position:
        raise ScenarioError(
            f"{scenario.name}: [sensors.deflection.irregularity] wants the places of the wheelsets: give "
            "[vehicle.formation] wheelset_position"
        )
    from scipy.signal import bilinear, lfilter

    from railgrip.track.irregularity import realise

    position = np.array(layout.formation.wheelset_position)
    lead_in = scenario.start.speed * _LEAD_IN
    begin = -float(position.max()) - lead_in
    length = min(scenario.start.speed * scenario.limits.horizon, _LONGEST_RAIL) - begin
    rail = realise(table.track, length, generator(scenario.seed, f"track.{table.track}"), kinds=("vertical",))
    height = Course(begin=begin, step=_FINE, values=rail.at("vertical", np.arange(0.0, length, _FINE)))
    omega = 2.0 * math.pi * table.frequency
    filter_ = bilinear([1.0, 0.0, 0.0], [1.0, 2.0 * table.damping * omega, omega**2], fs=1.0 / period)
    forward, back = (np.asarray(part, dtype=np.float64) for part in filter_)
    travel = np.arange(-lead_in, 0.0, scenario.start.speed * period)
    before = np.interp(travel[:, None] - position, begin + _FINE * np.arange(height.values.size), height.values)
    _, state = lfilter(forward, back, before, axis=0, zi=np.zeros((2, position.size)))
    return RoughRail(
        height=height, position=position, forward=forward, back=back[1:], state=np.ascontiguousarray(state.T)
    )


class OnTrack:
    """White sensors, accelerometers that feel the gradient, and a GNSS receiver."""

    def __init__(self, white: WhiteSensors, layout: Layout, scenario: Scenario, gnss: Gnss | None) -> None:
        """Add to `white` what the track of a scenario does."""
        self._white, self._slope = white, slope_of(scenario.track)
        self._distance = layout.output["distance"].start
        self._along, self._position = layout.reading.get("acceleration_along"), slice(0, 0)
        self._receiver = None
        if gnss is not None:
            self._position = slice(layout.reading[GNSS[0]].start, layout.reading[GNSS[-1]].stop)
            self._receiver = _Receiver(gnss, scenario)

    def read(self, sample: int, truth: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the reading of a sample; they come one after the other, from 0 on.

        Raises:
            SensorsFailed: The train has left its track.
        """
        reading, distance = self._white.read(sample, truth), float(truth[self._distance])
        if self._along is not None:
            reading[self._along] += gravity_along(self._slope(distance))
        if self._receiver is not None:
            reading[self._position] = self._receiver.read(sample, distance)
        return reading


class _Receiver:
    def __init__(self, table: Gnss, scenario: Scenario) -> None:
        assert scenario.track.plan is not None  # the scenario has been checked
        self._track, self._random = scenario.track.plan, generator(scenario.seed, "sensors.gnss")
        self._plan = self._track.laid().plan()
        step = scenario.periods.communication
        self._every = max(round(table.period / (step * sampled_every(scenario.sensors, step))), 1)
        self._keeps = math.exp(-table.period / table.wander_time)
        self._wander = self._random.standard_normal(3)
        self._wanders = np.array([table.horizontal_wander, table.horizontal_wander, table.height_wander])
        self._white = np.array([table.horizontal, table.horizontal, table.height])

    def read(self, sample: int, distance: float) -> NDArray[np.float64]:
        """Return latitude, longitude [deg] and height [m], NaN where there is no new reading."""
        if sample % self._every:
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
        # Radii of the sphere are within 0.4 % of the ellipsoid's: less than a millimetre of a wander.
        metre = math.degrees(1.0 / 6.371e6)
        return np.array(
            [latitude + north * metre, longitude + east * metre / math.cos(math.radians(latitude)), height + up]
        )


_SOURCE = {"acceleration_along": "acceleration"} | dict.fromkeys(GNSS, "distance")
"""What the plant shows of a quantity that has another name, or takes the place of."""


def _white(scenario: Scenario, table: WhiteTable, layout: Layout) -> WhiteSensors | OnTrack:
    def each(values: Mapping[str, float]) -> NDArray[np.float64]:
        vector = np.zeros(layout.readings)
        for name, value in values.items():
            if name not in layout.reading:
                raise ScenarioError(
                    f"{scenario.name}: [sensors] names '{name}', which this plant does not show; its sensors read "
                    f"{', '.join(layout.reading)}"
                )
            vector[layout.reading[name]] = value
        return vector

    def shown(name: str) -> NDArray[np.intp]:
        source, at = layout.output[_SOURCE.get(name, name)], layout.reading[name]
        return source.start + np.arange(at.stop - at.start) % (source.stop - source.start)

    lot = generator(scenario.seed, "sensors.lot")
    white = WhiteSensors(
        np.concatenate([shown(name) for name in layout.reading]),
        1.0 + each(table.scale) * lot.standard_normal(layout.readings),
        each(_deviations(scenario, "bias", table.bias)) * lot.standard_normal(layout.readings),
        each(_deviations(scenario, "noise", table.noise)),
        generator(scenario.seed, "sensors.noise"),
    )
    return OnTrack(white, layout, scenario, table.gnss) if _SOURCE.keys() & layout.reading.keys() else white


def _deviations(scenario: Scenario, table: str, magnitudes: Mapping[str, Magnitude]) -> dict[str, float]:
    where = f"{scenario.name}: [sensors.{table}]"
    values = in_units(where, magnitudes, {name: signal.unit for name, signal in _ALL.items()})
    negative = next((name for name, value in values.items() if value < 0.0), None)
    if negative is not None:
        raise ScenarioError(f"{where} {negative} is a standard deviation and not negative, got {values[negative]:g}")
    return values
