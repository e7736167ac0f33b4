"""The C functions of the loop, called one at a time for a vehicle of `synthetic.LAYOUT`."""

import numpy as np
from synthetic import LAYOUT

from railgrip.simulate.loop.driver import released
from railgrip.simulate.loop.library import kernel
from railgrip.simulate.loop.sensors import BLOCK, IdealSensors, ServiceSensors, _encoder

KERNEL = kernel(LAYOUT)


def phase_of(until="end", **fields):
    """Return one phase of a driver without demands except `fields`."""
    row = released(LAYOUT, 1)
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

    def __init__(self, *arguments):
        self.struct = _encoder(LAYOUT, *arguments)

    def read(self, sample, speed):
        return KERNEL.functions.read_encoder(self.struct.pointer, sample, speed)
