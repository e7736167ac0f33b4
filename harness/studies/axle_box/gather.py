"""From a pass of the car to what estimators are trained on."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from railgrip.campaign.work import Work
from railgrip.estimators.belief import Array
from railgrip.scenario.seed import generator
from railgrip.studies.axle_box.accelerometer import AXLE_BOX, RATE, measure
from railgrip.studies.axle_box.instrumented_car import RATE as TWIN_RATE
from railgrip.studies.axle_box.instrumented_car import Pass, Ride, ride, slope
from railgrip.studies.axle_box.reduction import SPECTRAL, Readings, Run, reduce

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


EVERY: Final = 20.0
"""m between the spectral features that are kept."""
SETTLED: Final = 60.0
"""m before the first of them."""


def spectral_features(run: Run) -> Array:
    """Return features every `EVERY` metres once `SETTLED` metres are travelled, shape (m, features)."""
    speed = run.slow[:, 8]
    every = SPECTRAL.features(run.slow[:, :4], run.slow[:, 4:8], speed)
    metres = np.cumsum(np.abs(speed)) / SPECTRAL.rate
    first, last = max(SETTLED, 2 * SPECTRAL.settling * run.speed), metres[-1]
    return every[np.searchsorted(metres, np.arange(min(first, last), last, EVERY))]


def gather(passes: Sequence[Pass], work: Work) -> list[Run]:
    """Return the reduced runs of passes."""
    # Longest first, so that no worker is left with a long one at the end.
    order = sorted(passes, key=lambda one: one.speed / one.length)
    run_of_pass = dict(zip(order, work.map(run_of, order), strict=True))
    return [replace(run_of_pass[one], slope=slope(one)) for one in passes]


def run_of(run: Pass) -> Run:
    """Simulate, measure and reduce a pass."""
    return reduce(run.name, run.friction, readings(run))
