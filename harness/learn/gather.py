"""From a pass to what estimators are trained on, cached by content.

A run at the loggers' rate is some hundred megabytes; kept are only the block means of the paper's chain and the
lateral and yaw acceleration at 128 samples a second, some hundred kilobytes.
"""

import ast
import hashlib
import json
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

import estimators.learned.antialias
import estimators.learned.channels
import estimators.learned.preprocessing
import harness.twins.accelerometer
import harness.twins.instrumented_car
import harness.twins.irregularity
from estimators.learned.antialias import AntiAlias
from estimators.learned.channels import motions
from estimators.learned.preprocessing import BLOCKS, Chain
from estimators.learned.spectral import Spectral
from fmus.build import fmu
from harness.record.atomic import replacing
from harness.scenario.seed import generator
from harness.twins.accelerometer import AXLE_BOX, RATE, measure
from harness.twins.instrumented_car import FMU, MPH, Pass, ride, slope

Array = NDArray[np.float64]

CACHE: Final = Path("build/learn/runs")
SLOW: Final = AntiAlias(rate=RATE, keep=40)
SPECTRAL: Final = Spectral(rate=SLOW.slow_rate)
EVERY: Final = 20.0
"""m between the spectral features that are kept."""
SETTLED: Final = 60.0
"""m before the first of them."""
VEHICLE: Final = 7
"""Seed of the sensors' own properties: one car carries the same accelerometers on every run."""

_CODE: Final = (
    estimators.learned.channels, estimators.learned.preprocessing, estimators.learned.antialias,
    harness.twins.accelerometer, harness.twins.instrumented_car, harness.twins.irregularity,
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """What the loggers wrote during one run.

    Attributes:
        left, right, lateral: m/s², shape (n, 4), in axes of the car.
        speed: m/s.
        backwards: Whether the fourth wheelset led.
        rate: Samples a second.
    """

    left: Array
    right: Array
    lateral: Array
    speed: float
    backwards: bool
    rate: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """One labelled run, reduced.

    Attributes:
        name: Unique.
        group: Speed class, mph.
        speed: m/s.
        friction: The label.
        blocks: Of the paper's chain, 12 channels (longitudinal, lateral, yaw), m/s², shape (n, 12).
        settled: The same with the high-pass started at the mean of the first second.
        slow: Lateral and yaw acceleration at the rate of `SLOW`, in axes that point forwards, m/s², shape (m, 8).
        slope: Of the creep curve over that of a clean contact, which only a twin knows.
    """

    name: str
    group: int
    speed: float
    friction: float
    blocks: Array
    settled: Array
    slow: Array
    slope: float | None = None


def readings(run: Pass) -> Readings:
    """Simulate a run and measure it."""
    made = ride(run)
    true = np.hstack([made.longitudinal[:, :, 0], made.longitudinal[:, :, 1], made.lateral])
    written = measure(
        true, harness.twins.instrumented_car.RATE, float(made.speed.mean()), AXLE_BOX,
        vehicle=generator(VEHICLE, "sensors"), run=generator(run.seed, f"{run.name}.sensors"),
    )  # fmt: skip
    return Readings(
        left=written[:, :4], right=written[:, 4:8], lateral=written[:, 8:],
        speed=float(made.speed.mean()), backwards=run.backwards, rate=RATE,
    )  # fmt: skip


def reduce(name: str, friction: float, seen: Readings) -> Run:
    """Return a run as estimators are trained on it."""
    group = min(BLOCKS, key=lambda mph: abs(mph * MPH - seen.speed))
    raw = motions(seen.left, seen.right, seen.lateral, "longitudinal, lateral, yaw")
    chain = Chain(rate=seen.rate, block=BLOCKS[group])
    settled = Chain(rate=seen.rate, block=BLOCKS[group], start="first second")
    return Run(
        name=name, group=group, speed=seen.speed, friction=friction,
        blocks=chain.process(raw), settled=settled.process(raw), slow=forward(seen),
    )  # fmt: skip


def spectral_features(run: Run, spectral: Spectral = SPECTRAL) -> Array:
    """Return features every `EVERY` metres once `SETTLED` metres are travelled, shape (m, features)."""
    every = spectral.features(run.slow[:, :4], run.slow[:, 4:], run.speed)
    metres = np.arange(len(every)) * (run.speed / spectral.rate)
    first, last = max(SETTLED, 2 * spectral.settling * run.speed), metres[-1]
    return every[np.searchsorted(metres, np.arange(min(first, last), last, EVERY))]


def forward(seen: Readings) -> Array:
    """Return lateral and yaw acceleration at the slow rate in axes that point forwards, shape (m, 8)."""
    slow = SLOW(np.hstack([seen.lateral, seen.right - seen.left]))
    if seen.backwards:  # half a turn: the fourth wheelset leads, left is right, and yaw stays yaw
        return np.hstack([-slow[:, 3::-1], slow[:, :3:-1]])
    return slow


def gather(
    passes: Iterable[Pass], pool: Executor, *, cache: Path = CACHE, tell: Callable[[str], None] = lambda _: None
) -> list[Run]:
    """Return the reduced runs of passes, simulating those that are not in the cache.

    Args:
        pool: Simulates, see `workers`.
        tell: Told the name of every run as it is there.
    """
    wanted = list(passes)
    common = _common()
    files = {p.name + str(p.seed): cache / f"{_key(p, common)}.npz" for p in wanted}
    missing = [p for p in wanted if not files[p.name + str(p.seed)].exists()]
    for p in wanted:
        if p not in missing:
            tell(p.name)
    # Longest first, so that no worker is left with a long one at the end.
    missing.sort(key=lambda p: p.speed / p.length)
    running = {pool.submit(_make, p, files[p.name + str(p.seed)]): p for p in missing}
    for done in as_completed(running):
        done.result()
        tell(running[done].name)
    return [_read(files[p.name + str(p.seed)], slope(p)) for p in wanted]


def _make(run: Pass, file: Path) -> None:
    made = reduce(run.name, run.friction, readings(run))
    file.parent.mkdir(parents=True, exist_ok=True)
    with replacing(file) as partial, partial.open("wb") as stream:
        np.savez_compressed(stream, **{k: v for k, v in asdict(made).items() if v is not None})


def _read(file: Path, known_slope: float) -> Run:
    with np.load(file) as held:
        return Run(
            name=str(held["name"]), group=int(held["group"]), speed=float(held["speed"]),
            friction=float(held["friction"]),
            blocks=held["blocks"], settled=held["settled"], slow=held["slow"].astype(np.float64), slope=known_slope,
        )  # fmt: skip


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
