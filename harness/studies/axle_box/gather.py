"""From a pass of the car to what estimators are trained on, cached by content."""

import json
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, replace
from typing import Final

import numpy as np

import railgrip.estimators.learned.channels
import railgrip.estimators.learned.preprocessing
import railgrip.studies.axle_box.accelerometer
import railgrip.studies.axle_box.instrumented_car
import railgrip.studies.axle_box.reduction
import railgrip.track.irregularity
from railgrip.campaign.store import digest_of, results_of
from railgrip.estimators.belief import Array
from railgrip.fmus.build import fmu
from railgrip.scenario.seed import generator
from railgrip.studies.axle_box.accelerometer import AXLE_BOX, RATE, measure
from railgrip.studies.axle_box.instrumented_car import FMU, Pass, Ride, ride, slope
from railgrip.studies.axle_box.instrumented_car import RATE as TWIN_RATE
from railgrip.studies.axle_box.reduction import SLOW, SPECTRAL, Readings, Run, reduce

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


KIND: Final = "axle-box-runs"
"""Their shelf in the user's cache."""
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


def gather(passes: Sequence[Pass], pool: Executor, *, tell: Callable[[str], None] = lambda _: None) -> list[Run]:
    """Return the reduced runs of passes, simulating those that are not in the user's cache."""
    rests_on = digest_of(
        fmu(FMU), json.dumps([asdict(AXLE_BOX), asdict(SLOW), VEHICLE]).encode(),
        railgrip.estimators.learned.channels, railgrip.estimators.learned.preprocessing,
        sys.modules[__name__], railgrip.studies.axle_box.reduction,
        railgrip.studies.axle_box.accelerometer, railgrip.studies.axle_box.instrumented_car,
        railgrip.track.irregularity,
    )  # fmt: skip
    # Longest first, so that no worker is left with a long one at the end.
    order = sorted(passes, key=lambda one: one.speed / one.length)
    runs = results_of(KIND, order, run_of, pool, rests_on, lambda run, was_there: tell(run.name))
    run_of_pass = dict(zip(order, runs, strict=True))
    return [replace(run_of_pass[one], slope=slope(one)) for one in passes]


def run_of(run: Pass) -> Run:
    """Simulate, measure and reduce a pass."""
    return reduce(run.name, run.friction, readings(run))
