"""The instruments of a scenario, drawn from its seed."""

import numpy as np

from railgrip.errors import ScenarioError
from railgrip.loop.ports import Sensors
from railgrip.loop.sensors import IdealSensors, ServiceInstruments, ServiceSensors
from railgrip.scenario.custom import Custom
from railgrip.scenario.schema import Scenario
from railgrip.scenario.seed import generator
from railgrip.scenario.sensors import IdealSensors as IdealTable
from railgrip.signals import Layout


def sensors_of(scenario: Scenario, layout: Layout, wheel_radius: float) -> Sensors:
    """Return the sensors of a scenario; what is constant over a stop is drawn here."""
    table = scenario.sensors
    if isinstance(table, IdealTable):
        return IdealSensors(layout)
    if isinstance(table, Custom):
        raise ScenarioError(f"{scenario.name}: [sensors] kind '{table.kind}' is no sensor model of this project")
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
