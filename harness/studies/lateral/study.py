"""Many runs of the lateral study, two at a time, each kept under a digest of everything that decides it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import railgrip.estimators
from railgrip.campaign.store import digest_of, results_of
from railgrip.campaign.workers import workers as processes
from railgrip.estimation.run import Kind
from railgrip.fmus.build import fmu
from railgrip.fmus.native import lower
from railgrip.studies.lateral import filters, judge, run, wheelset
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
        prediction: What the filters evaluate.
    """

    tests: tuple[Trial, ...]
    speeds: tuple[float, ...]
    seeds: int
    prediction: Kind = "fmu"

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
            Case(test=test, speed=speed, plant=plant, seed=seed, prediction=self.prediction)
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
    """Return the results of all runs of a plan, in its order; those in the user's cache are not run again."""
    # Compiled here once, so that the workers find everything made.
    first = Case(test=TESTS[0].shortened(0.01), speed=25.0, plant="paper", seed=0, prediction=plan.prediction)
    simulate(first)
    # What the compiler made, not the files it read: another vehicle in the library changes nothing here.
    models = [lower(name) for name in (*CLASSES.values(), "RailBraking.FMUs.LateralContact")]
    rests_on = digest_of(
        *(fmu(name) for name in ("LateralWheelset", *(name.rpartition(".")[2] for name in CLASSES.values()))),
        *(function.serialize().encode() for model in models for function in (model.derivative, model.output)),
        repr([(p.name, p.start) for model in models for p in model.parameters]).encode(),
        Path(railgrip.estimators.__file__ or "").parent,
        *(filters, run, judge, wheelset),
    )
    with processes(workers) as pool:
        measures = results_of("lateral-runs", plan.cases, one, pool, rests_on, tell)
    return tuple(Result(case=case, measures=own) for case, own in zip(plan.cases, measures, strict=True))


def one(case: Case) -> dict[str, Any]:
    """Run and measure one case; observability is that of the model, which other plants do not keep to."""
    return measure(simulate(case), observe=case.plant == "paper")
