"""The instruments of a scenario, drawn from its seed."""

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from railgrip.errors import ScenarioError
from railgrip.loop.ports import Sensors
from railgrip.loop.sensors import IdealSensors, ServiceInstruments, ServiceSensors, WhiteSensors
from railgrip.scenario.custom import Custom
from railgrip.scenario.quantity import Magnitude, in_units
from railgrip.scenario.schema import Scenario
from railgrip.scenario.seed import generator
from railgrip.scenario.sensors import IdealSensors as IdealTable
from railgrip.scenario.sensors import WhiteSensors as WhiteTable
from railgrip.signals import EXTRA_READINGS, READINGS, Layout, Signal

_ALL = {signal.name.removeprefix("reading_"): signal for signal in (*READINGS, *EXTRA_READINGS)}


def readings_of(scenario: Scenario, shown: Collection[str]) -> tuple[Signal, ...]:
    """Return what the sensors of a scenario show.

    Args:
        scenario: With the sensors.
        shown: Names of what the plant shows.

    Raises:
        ScenarioError: A quantity is named that is none, or that the plant does not show.
    """
    table = scenario.sensors
    if not isinstance(table, WhiteTable):
        return READINGS
    unknown = sorted(table.named - set(_ALL))
    unseen = sorted(table.named - set(unknown) - set(shown))
    if unknown or unseen:
        problem = f"there is no quantity {unknown[0]}" if unknown else f"the plant does not show {unseen[0]}"
        known = ", ".join(name for name in _ALL if name in shown)
        raise ScenarioError(f"{scenario.name}: [sensors]: {problem}; there is {known}")
    return (*READINGS, *(signal for name, signal in _ALL.items() if name in table.named and signal in EXTRA_READINGS))


def sensors_of(scenario: Scenario, layout: Layout, wheel_radius: float) -> Sensors:
    """Return the sensors of a scenario; what is constant over a stop is drawn here."""
    table = scenario.sensors
    if isinstance(table, IdealTable):
        return IdealSensors(layout)
    if isinstance(table, Custom):
        raise ScenarioError(f"{scenario.name}: [sensors] kind '{table.kind}' is no sensor model of this project")
    if isinstance(table, WhiteTable):
        return _white(scenario, table, layout)
    period = scenario.periods.communication
    lot = generator(scenario.seed, "sensors.lot")
    instruments = ServiceInstruments(
        pulses=table.wheel.pulses,
        pitch_error=table.wheel.pitch_error,
        clock=table.wheel.clock,
        cut_off=table.wheel.cut_off,
        wheel_radius=wheel_radius,
        speed_noise=table.speed.noise,
        speed_scale=table.speed.scale_offset + table.speed.scale_error * float(lot.standard_normal()),
        speed_every=max(round(table.speed.period / period), 1),
        speed_latency=round(table.speed.latency / period),
        acceleration_noise=table.acceleration.noise,
        acceleration_bias=table.acceleration.bias * float(lot.standard_normal()),
        deflection_noise=table.deflection.noise,
        pressure_offset=table.pressure.error * table.pressure.full_scale * lot.standard_normal(layout.formation.groups),
        pressure_step=table.pressure.full_scale / float(np.exp2(table.pressure.bits)),
        pressure_lag=table.pressure.lag,
    )
    return ServiceSensors(layout, instruments, period, generator(scenario.seed, "sensors.noise"))


def _white(scenario: Scenario, table: WhiteTable, layout: Layout) -> WhiteSensors:
    def each(values: Mapping[str, float]) -> NDArray[np.float64]:
        found = np.zeros(layout.readings)
        for name, value in values.items():
            found[layout.reading[name]] = value
        return found

    lot = generator(scenario.seed, "sensors.lot")
    return WhiteSensors(
        np.concatenate([np.arange(at.start, at.stop) for at in (layout.output[name] for name in layout.reading)]),
        1.0 + each(table.scale) * lot.standard_normal(layout.readings),
        each(_deviations(scenario, "bias", table.bias)) * lot.standard_normal(layout.readings),
        each(_deviations(scenario, "noise", table.noise)),
        generator(scenario.seed, "sensors.noise"),
    )


def _deviations(scenario: Scenario, table: str, written: Mapping[str, Magnitude]) -> dict[str, float]:
    where = f"{scenario.name}: [sensors.{table}]"
    values = in_units(where, written, {name: signal.unit for name, signal in _ALL.items()})
    negative = next((name for name, value in values.items() if value < 0.0), None)
    if negative is not None:
        raise ScenarioError(f"{where} {negative} is a standard deviation and not negative, got {values[negative]:g}")
    return values
