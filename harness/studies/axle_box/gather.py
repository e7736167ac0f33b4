"""From a pass of the car to what estimators are trained on, cached by content."""

import ast
import hashlib
import json
from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from dataclasses import asdict, replace
from pathlib import Path
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
from railgrip.campaign.store import results_of
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
_CODE: Final = (
    railgrip.estimators.learned.channels, railgrip.estimators.learned.preprocessing,
    railgrip.estimators.learned.antialias,
    railgrip.studies.axle_box.measured, railgrip.studies.axle_box.reduction,
    railgrip.studies.axle_box.accelerometer, railgrip.studies.axle_box.instrumented_car,
    railgrip.track.irregularity,
)  # fmt: skip


def spectral_features(run: Run) -> Array:
    """Return features every `EVERY` metres once `SETTLED` metres are travelled, shape (m, features)."""
    speed = run.slow[:, 8]
    every = SPECTRAL.features(run.slow[:, :4], run.slow[:, 4:8], speed)
    metres = np.cumsum(np.abs(speed)) / SPECTRAL.rate
    first, last = max(SETTLED, 2 * SPECTRAL.settling * run.speed), metres[-1]
    return every[np.searchsorted(metres, np.arange(min(first, last), last, EVERY))]


def gather(passes: Iterable[Pass], pool: Executor, *, tell: Callable[[str], None] = lambda _: None) -> list[Run]:
    """Return the reduced runs of passes, simulating those that are not in the user's cache.

    Args:
        tell: Told the name of every run as it is there.
    """
    plan, common = list(passes), _common()
    keys = [_key(p, common) for p in plan]
    # Longest first, so that no worker is left with a long one at the end.
    tasks = dict(sorted(zip(keys, plan, strict=True), key=lambda item: item[1].speed / item[1].length))
    runs = results_of(KIND, tasks, run_of, pool, lambda run, was_there: tell(run.name))
    return [replace(runs[key], slope=slope(p)) for key, p in zip(keys, plan, strict=True)]


def run_of(run: Pass) -> Run:
    """Simulate, measure and reduce a pass."""
    return reduce(run.name, run.friction, readings(run))


def _common() -> str:
    """Return a digest of what every run depends on: the FMU, sensors, filters and the code around them."""
    digest = hashlib.sha256(fmu(FMU).read_bytes())
    for module in _CODE:
        # What the code does, not how it is laid out or commented.
        digest.update(ast.dump(ast.parse(Path(module.__file__ or "").read_text())).encode())
    digest.update(json.dumps([asdict(AXLE_BOX), asdict(SLOW), VEHICLE]).encode())
    return digest.hexdigest()


def _key(run: Pass, common: str) -> str:
    return hashlib.sha256((common + json.dumps(asdict(run), sort_keys=True)).encode()).hexdigest()[:24]
