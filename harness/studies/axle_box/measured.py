"""A pass of the car, measured as the loggers of its car do."""

from typing import Final

import numpy as np

from railgrip.scenario.seed import generator
from railgrip.studies.axle_box.accelerometer import AXLE_BOX, RATE, measure
from railgrip.studies.axle_box.instrumented_car import RATE as TWIN_RATE
from railgrip.studies.axle_box.instrumented_car import Pass, Ride, ride
from railgrip.studies.axle_box.reduction import Readings

VEHICLE: Final = 7
"""Seed of the sensors' own properties: one car carries the same accelerometers on every run."""


def readings(run: Pass) -> Readings:
    """Simulate a run and measure it."""
    motion = ride(run)
    return measured(run, motion, TWIN_RATE, float(motion.speed.mean()))


def measured(run: Pass, motion: Ride, rate: int, speed: float) -> Readings:
    """Measure the motion of a run, sampled at `rate` a second; rolling wheels shake the boxes as at `speed`, m/s."""
    true = np.hstack([motion.longitudinal[:, :, 0], motion.longitudinal[:, :, 1], motion.lateral])
    channels = measure(
        true, rate, speed, AXLE_BOX,
        vehicle=generator(VEHICLE, "sensors"), run=generator(run.seed, f"{run.name}.sensors"),
    )  # fmt: skip
    fine = np.arange(len(channels)) * (rate / RATE)
    return Readings(
        left=channels[:, :4], right=channels[:, 4:8], lateral=channels[:, 8:],
        speed=np.interp(fine, np.arange(len(motion.speed)), motion.speed), backwards=run.backwards, rate=RATE,
    )  # fmt: skip
