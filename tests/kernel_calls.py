"""The C functions of the loop, called one at a time for a vehicle of `synthetic.LAYOUT`."""

import numpy as np
from synthetic import LAYOUT, LIBRARY

from railgrip.kernel import kernel
from railgrip.scenario.demand import blank_phases
from railgrip.scenario.load import load
from railgrip.simulate.loop.interfaces import BLOCK
from railgrip.simulate.sensors.ideal import IdealSensors
from railgrip.simulate.sensors.service import ServiceSensors, encoder

KERNEL = kernel(LAYOUT)

SERVICE = {
    "kind": "service",
    "wheel": {"pulses": 100, "pitch_error": 0.003, "clock": 1e-6, "cut_off": 0.3},
    "speed": {"noise": 0.1, "scale_error": 0.0, "scale_offset": 0.002, "period": 0.05, "latency": 0.05},
    "acceleration": {"noise": 0.03, "bias": 0.0},
    "deflection": {"noise": 2e-4},
    "pressure": {"full_scale": 1e6, "error": 0.0, "bits": 12, "lag": 0.01},
}
"""Table of the sensors of a train in service, without the errors that are drawn once a stop."""


def service_table(**changes):
    """Return the table of service sensors with changes, key by key: `wheel={"clock": 1e-9}`."""
    return load(LIBRARY / "plain.toml").revised({"sensors": SERVICE}).revised({"sensors": changes})


def service_sensors(fields=None, **changes):
    """Return the sensors of `service_table`; `fields` replace those of `Service` in sensors.h."""
    scenario = service_table(**changes)
    sensors = scenario.sensors.open(scenario, LAYOUT, 0.38)
    sensors.struct.set(**(fields or {}))
    return sensors


def along_track(begin, step, values):
    """Return a `TrackQuantity` of sensors.h."""
    return KERNEL.struct("TrackQuantity", begin=begin, step=step, values=np.asarray(values), count=len(values))


def phase_of(until="end", **fields):
    """Return one phase of a driver without demands except `fields`."""
    row = blank_phases(LAYOUT, 1)
    row["until"] = getattr(KERNEL.functions, f"AT_{until.upper()}")
    for name, value in fields.items():
        row[name] = value
    return row


def drive(driver, sample, truth):
    """Return the driver's demand at a sample [Pa]."""
    KERNEL.functions.drive(driver.struct.pointer, sample, KERNEL.doubles(truth))
    return driver.struct.view("pressure").copy()


def show(faults, sample, reading, layout=LAYOUT):
    """Return the readings of a vehicle after sensor faults."""
    values, library = np.array(reading, dtype=np.float64), kernel(layout)
    library.functions.change_reading(faults.struct.pointer, sample, library.doubles(values))
    return values


def transmit(faults, sample, truth, commands):
    """Return the commands that arrive at the plant."""
    arriving = np.array(commands, dtype=np.float64)
    vectors = (KERNEL.doubles(vector) for vector in (truth, arriving))
    KERNEL.functions.change_command(faults.struct.pointer, sample, *vectors)
    return arriving


def read(sensors, sample, truth, layout=LAYOUT):
    """Return the reading of a sample by any sensors of a vehicle."""
    if isinstance(sensors, IdealSensors):
        return truth.take(sensors.places)
    if not isinstance(sensors, ServiceSensors):
        return sensors.read(sample, truth)
    if sample % BLOCK == 0:
        sensors.draw()
    reading, library = np.empty(layout.readings), kernel(layout)
    library.functions.read_service(sensors.struct.pointer, sample, library.doubles(truth), library.doubles(reading))
    return reading


def holds(plausibility, sample, truth, inputs):
    """Return whether the outputs of a sample are possible."""
    pointer = plausibility.struct.pointer
    return KERNEL.functions.plausible(pointer, sample, KERNEL.doubles(truth), KERNEL.doubles(inputs)) == 1


class Encoder:
    """One pole wheel of service sensors."""

    def __init__(self, wheel=None, **gap):
        table = service_table(wheel=wheel or {}).sensors.wheel
        self.struct = encoder(LAYOUT, table, 0.38, 1e-3, np.random.default_rng(1), **gap)

    def read(self, sample, speed):
        return KERNEL.functions.read_encoder(self.struct.pointer, sample, speed)
