"""Many runs of the lateral study, two at a time, each kept under a digest of everything that decides it."""

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Final

from railgrip.campaign.store import results_of
from railgrip.campaign.workers import workers as processes
from railgrip.fmus.build import fmu
from railgrip.fmus.native import lower
from railgrip.studies.lateral.filters import CLASSES
from railgrip.studies.lateral.judge import measure
from railgrip.studies.lateral.run import Case, simulate
from railgrip.studies.lateral.wheelset import PLANTS, TESTS, Trial

SPEEDS: Final = (15.0, 25.0, 35.0)
"""Of the wheelset [m/s]; Mal et al. do not state theirs."""

SEEDS: Final = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Which runs.

    Attributes:
        tests: Each at every speed on the plant that the filters know; the last also at the middle speed on the others.
        speeds: [m/s].
        seeds: 1 to this number.
    """

    tests: tuple[Trial, ...]
    speeds: tuple[float, ...]
    seeds: int

    @property
    def middle_speed(self) -> float:
        """Speed of figures and of the plants that differ [m/s]."""
        return self.speeds[len(self.speeds) // 2]

    @property
    def cases(self) -> tuple[Case, ...]:
        """All runs."""
        variants = [(test, speed, "paper") for speed in self.speeds for test in self.tests]
        others = [(self.tests[-1], self.middle_speed, plant) for plant in PLANTS if plant != "paper"]
        return tuple(
            Case(test=test, speed=speed, plant=plant, seed=seed)
            for test, speed, plant in (*variants, *others)
            for seed in range(1, self.seeds + 1)
        )


FULL: Final = Plan(tests=TESTS, speeds=SPEEDS, seeds=SEEDS)
QUICK: Final = Plan(tests=tuple(test.shortened(2.5) for test in TESTS), speeds=(25.0,), seeds=2)
"""A few seconds of everything: shows that it runs, not what is true."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """What one run gave: its case and what `judge.measure` returned."""

    case: Case
    measures: dict[str, Any]


def conduct(
    plan: Plan, *, workers: int = 2, tell: Callable[[Case, bool], None] = lambda case, was_there: None
) -> tuple[Result, ...]:
    """Return the results of all runs of a plan, in its order; those in the user's cache are not run again.

    Args:
        tell: Told of every finished run, and whether it had been there.
    """
    # Compiled here once, so that the workers find everything made.
    simulate(Case(test=TESTS[0].shortened(0.01), speed=25.0, plant="paper", seed=0))
    keys = {case: key(case) for case in plan.cases}
    with processes(workers) as pool:
        measures = results_of("lateral-runs", {key: case for case, key in keys.items()}, one, pool, tell)
    return tuple(Result(case=case, measures=measures[keys[case]]) for case in plan.cases)


def one(case: Case) -> dict[str, Any]:
    """Run and measure one case."""
    return measure(simulate(case), observe=_with_observability(case))


def key(case: Case) -> str:
    """Return the digest of a case and of everything that its result rests on."""
    text = json.dumps([asdict(case), _with_observability(case)], sort_keys=True)
    return hashlib.sha256((_ground() + text).encode()).hexdigest()[:20]


def _with_observability(case: Case) -> bool:
    """Return whether observability is asked for: it is that of the model, which other plants do not keep to."""
    return case.plant == "paper"


@cache
def _ground() -> str:
    """Return a digest of the plant's FMU, the predictions' equations and the code that runs and judges them."""
    # What the compiler made, not the files it read: another vehicle in the library changes nothing here.
    digest = hashlib.sha256(fmu("LateralWheelset").read_bytes())
    for class_name in (*CLASSES.values(), "RailBraking.FMUs.LateralContact"):
        model = lower(class_name)
        digest.update(model.derivative.serialize().encode() + model.output.serialize().encode())
        digest.update(repr([(p.name, p.start) for p in model.parameters]).encode())
    for package, names in (
        ("railgrip.estimators", None),
        ("railgrip.estimators.kernel", None),
        ("railgrip.loop.kernel", None),
        ("railgrip.studies.lateral", ("filters.py", "run.py", "judge.py", "wheelset.py")),
        ("railgrip.loop", ("compiled.py",)),
    ):
        for name, text in _sources(package, names):
            digest.update(f"{package}/{name}\0{text}\0".encode())
    return digest.hexdigest()


def _sources(package: str, names: Sequence[str] | None) -> list[tuple[str, str]]:
    room, *below = package.removeprefix("railgrip.").split(".")
    folder = files(f"railgrip.{room}").joinpath(*below)
    of_package = sorted(file.name for file in folder.iterdir() if file.name.endswith((".py", ".c", ".h")))
    return [(name, folder.joinpath(name).read_text(encoding="utf-8")) for name in names or of_package]
