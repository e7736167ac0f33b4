"""A pass of the car, measured as the loggers of its car do."""

from typing import Final

import numpy as np

from railgrip.scenario.seed import generator
from railgrip.studies.axle_box.accelerometer import AXLE_BOX, RATE, Disturbance, disturbance, measure
from railgrip.studies.axle_box.instrumented_car import RATE as TWIN_RATE
from railgrip.studies.axle_box.instrumented_car import Pass, ride
from railgrip.studies.axle_box.reduction import Readings

VEHICLE: Final = 7
"""Seed of the sensors' own properties: one car carries the same accelerometers on every run."""


def readings(run: Pass) -> Readings:
    """Simulate a run and measure it."""
    motion = ride(run)
    true = np.hstack([motion.longitudinal[:, :, 0], motion.longitudinal[:, :, 1], motion.lateral])
    vehicle, own = draws(run)
    channels = measure(true, TWIN_RATE, float(motion.speed.mean()), AXLE_BOX, vehicle=vehicle, run=own)
    fine = np.arange(len(channels)) * (TWIN_RATE / RATE)
    return Readings(
        left=channels[:, :4], right=channels[:, 4:8], lateral=channels[:, 8:],
        speed=np.interp(fine, np.arange(len(motion.speed)), motion.speed), backwards=run.backwards, rate=RATE,
    )  # fmt: skip


def disturbance_of(run: Pass, count: int, speed: float) -> Disturbance:
    """Return what the sensors of the car add to `count` samples of a run at a speed, m/s."""
    vehicle, own = draws(run)
    return disturbance(count, 12, speed, AXLE_BOX, vehicle=vehicle, run=own)


def draws(run: Pass) -> tuple[np.random.Generator, np.random.Generator]:
    """Return the random streams of a run's sensors: of what belongs to the car, and of the run itself."""
    return generator(VEHICLE, "sensors"), generator(run.seed, f"{run.name}.sensors")
