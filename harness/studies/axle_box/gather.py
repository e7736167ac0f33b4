"""From a pass of the car to what estimators are trained on, cached by content."""

import json
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, replace
from typing import Final

import numpy as np

import railgrip.estimators.learned.antialias
import railgrip.estimators.learned.channels
import railgrip.estimators.learned.preprocessing
import railgrip.studies.axle_box.accelerometer
import railgrip.studies.axle_box.instrumented_car
import railgrip.studies.axle_box.measured
import railgrip.studies.axle_box.reduction
import railgrip.track.irregularity
from railgrip.campaign.store import ground, results_of
from railgrip.estimators.arrays import Array
from railgrip.fmus.build import fmu
from railgrip.studies.axle_box.accelerometer import AXLE_BOX
from railgrip.studies.axle_box.instrumented_car import FMU, Pass, slope
from railgrip.studies.axle_box.measured import VEHICLE, readings
from railgrip.studies.axle_box.reduction import SLOW, SPECTRAL, Run, reduce

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
    """Return the reduced runs of passes, simulating those that are not in the user's cache.

    Args:
        tell: Told the name of every run as it is there.
    """
    rests_on = ground(
        fmu(FMU), json.dumps([asdict(AXLE_BOX), asdict(SLOW), VEHICLE]).encode(),
        railgrip.estimators.learned.channels, railgrip.estimators.learned.preprocessing,
        railgrip.estimators.learned.antialias,
        railgrip.studies.axle_box.measured, railgrip.studies.axle_box.reduction,
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
