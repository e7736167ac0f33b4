"""The lateral study: its runs, its page with a figure of each test, and headline numbers."""

from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Annotated, Any, Final

import pandas
from typer import Option

from railgrip.campaign.work import Work
from railgrip.estimation.models import Kind
from railgrip.report.baseline import Finding
from railgrip.report.frame import Frame, groups_of
from railgrip.report.page import Page
from railgrip.studies.lateral.information import (
    KNOWN,
    SHORT,
    errors_of_run,
    information,
    known_table,
    observability_by_condition,
    stiffness_cases,
    stiffness_table,
    surface_change_table,
)
from railgrip.studies.lateral.judge import (
    DETECTOR,
    FRICTION_TOLERANCE,
    SHARE_TOLERANCE,
    WINDOW,
    measure,
)
from railgrip.studies.lateral.run import LateralCase, simulate
from railgrip.studies.lateral.tables import (
    FIRST_FIGURES,
    GROUP,
    TITLES,
    compare_with_paper,
    confidence_of,
    creep_curves,
    detections,
    error_rows,
    error_tables,
    flat,
    frame_of,
    friction_errors,
    innovation_table,
    levels,
    longitudinal,
    observability_table,
    skill,
    spike_figure,
    spikes,
    test_figure,
    typical,
    typical_table,
)
from railgrip.studies.lateral.wheelset import CONDITIONS, PLANTS, SERVICE_SENSORS, TESTS, SurfaceTest
from railgrip.studies.papers.pages import write_results
from railgrip.studies.study import Study

SPEEDS: Final = (15.0, 25.0, 35.0)
"""Speeds of the wheelset [m/s]; Mal et al. do not state theirs."""

SEEDS: Final = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class LateralPlan:
    """Runs of a study.

    Attributes:
        tests: Tests at every speed on the plant of the filters; the last one also at the middle speed on the other
            plants.
        speeds: Speeds [m/s].
        seeds: Number of seeds, from 1.
        prediction: Form of the prediction in the filters.
    """

    tests: tuple[SurfaceTest, ...]
    speeds: tuple[float, ...]
    seeds: int
    prediction: Kind = "fmu"

    @property
    def middle_speed(self) -> float:
        """Speed of figures and of the plants that differ [m/s]."""
        return self.speeds[len(self.speeds) // 2]

    @property
    def cases(self) -> tuple[LateralCase, ...]:
        """All runs."""
        variants = [(test, speed, "paper") for speed in self.speeds for test in self.tests]
        others = [(self.tests[-1], self.middle_speed, plant) for plant in PLANTS if plant != "paper"]
        return tuple(
            LateralCase(test=test, speed=speed, plant=plant, seed=seed, prediction=self.prediction)
            for test, speed, plant in (*variants, *others)
            for seed in range(1, self.seeds + 1)
        )


FULL: Final = LateralPlan(tests=TESTS, speeds=SPEEDS, seeds=SEEDS)
QUICK: Final = LateralPlan(tests=tuple(test.shorten(2.5) for test in TESTS), speeds=(25.0,), seeds=2)
"""A few seconds of each test, to check that the study runs; the numbers have no meaning."""


def measure_case(case: LateralCase) -> dict[str, Any]:
    """Run and measure one case; observability is that of the filters' model, so only on the plant that equals it."""
    return measure(simulate(case), observe=case.plant == "paper")


def page_of(plan: LateralPlan, work: Work, *, write: bool = False) -> Page:
    """Run a plan; return tables over its seeds, and a figure of a typical run of each test.

    Args:
        write: Whether to write tables and figures into docs/papers.
    """
    # Compiled once here instead of in every worker.
    simulate(LateralCase(test=TESTS[0].shorten(0.01), speed=25.0, plant="paper", seed=0, prediction=plan.prediction))
    measures = work.map(measure_case, plan.cases)
    transitions = [case for case in plan.cases if case.plant == "paper" and case.test is plan.tests[-1]]
    runs = work.map(information, [case for case in transitions if case.speed == plan.middle_speed])
    frame, speed = frame_of(zip(plan.cases, measures, strict=True)), plan.middle_speed
    errors, middle = error_rows(frame), frame[frame["speed"] == speed]
    drawn = [typical(group) for _, group in groups_of(middle, GROUP)]
    files = {
        f"{case.test.name}{'' if case.plant == 'paper' else '_' + case.plant}.png": case
        for case in (run.case for run in drawn)
    }
    transition = simulate(drawn[len(plan.tests) - 1].case)
    drawings = dict(zip(files, work.map(test_figure, files.values(), keep=False), strict=True))
    last = middle[middle["test"] == plan.tests[-1].name]
    tables = {
        "compared": compare_with_paper(transition),
        "typical": typical_table(drawn[: len(plan.tests)]),
        "spikes": spikes(last[last["plant"] == "paper"]),
        "skill": skill(frame, speed),
        "friction": friction_errors(frame, speed),
        "transition": innovation_table(last).without(("speed [m/s]", "test")),
        "longitudinal": longitudinal(frame, speed),
        "observed": observability_by_condition(runs),
        "refused": surface_change_table(runs),
    }
    drawings["creep_curves.svg"] = creep_curves(speed)
    drawings["spike.png"] = spike_figure(transition)
    if write:
        figures = {"lateral_wheelset_2.svg": drawings["creep_curves.svg"]}
        figures["lateral_wheelset_spike.png"] = drawings["spike.png"]
        figures |= {f"lateral_wheelset_{FIRST_FIGURES[test.name]}.png": drawings[f"{test.name}.png"] for test in TESTS}
        write_results("lateral_wheelset.md", tables, figures)
    return Page(
        title="Wheelset with lateral and yaw dynamics",
        question="Can friction be estimated from lateral and yaw acceleration of a wheelset, and what has to be known?",
        answer=_answer(errors),
        template="studies/lateral/lateral.md.jinja",
        values={
            "seeds": plan.seeds,
            "confidence": f"{100 * confidence_of(plan.seeds):.0f} %",
            "friction_tolerance": FRICTION_TOLERANCE,
            "share_tolerance": f"{100 * SHARE_TOLERANCE:.0f} %",
            "window": WINDOW,
            "sensors": SERVICE_SENSORS,
            "speed": f"{speed:g}",
            "detector": DETECTOR,
            "announced": f"{100 * DETECTOR.confidence:.0f} %",
            "errors": error_tables(errors),
            "innovations": innovation_table(frame),
            **tables,
            "short": SHORT,
            "mirrored": max(run.mirrored for run in runs),
            "observability": observability_table(frame),
            "levels": levels(frame),
            "detections": detections(frame),
            "pictures": {name: case.test.name for name, case in files.items()},
        },
        figures=drawings,
        tables={"errors.csv": flat(errors)},
    )


def _page_of_stiffness(seeds: int, duration: float, work: Work, *, write: bool) -> Page:
    cases = stiffness_cases(seeds, duration)
    frame = pandas.DataFrame(row for rows in work.map(errors_of_run, cases) for row in rows)
    tables = {"stiffness": stiffness_table(frame), "known": known_table(frame)}
    if write:
        write_results("lateral_wheelset.md", tables, {})
    return Page(
        title="Friction and creep stiffness of a wheelset",
        question="Can friction be known if the stiffness of the contact is not?",
        answer="A filter that estimates the creep stiffness too is as accurate with a wrong one as with the exact one. "
        "Where creepages are small, its interval of friction shows that readings do not determine friction.",
        template="studies/lateral/stiffness.md.jinja",
        values={"seeds": seeds, "window": WINDOW, "known_limit": KNOWN, **tables},
        tables={f"{name}.csv": table for name, table in tables.items()},
        screen=tuple(tables.values()),
    )


def _answer(errors: Frame) -> str:
    known = errors[(errors["plant"] == "paper") & (errors["quantity"] == "friction")]
    medians = known["rmse"].map(attrgetter("median")).groupby(known["filter"], sort=False)
    words = [f"{values.min():.2g} to {values.max():.2g} ({TITLES[name]})" for name, values in medians]
    return (
        f"With the exact model the median RMSE of friction over tests and speeds is {', '.join(words)}. "
        "Friction is between 0 and 1: a filter with a larger error has diverged."
    )


_TOLERANCE: Final = 0.05
"""Relative tolerance of rms errors, for rounding of another machine over half a million steps."""
_HEADLINES: Final = {
    "paper": ("reconstruction", "known_track", "unknown_track"),
    "softer": ("known_track",),
    "slightly_softer": ("known_track",),
    "service": ("known_track", "unknown_track"),
}
"""Filters of the headlines by plant."""


@dataclass(frozen=True)
class Lateral(Study, quick="2.5 s of each test at one speed with two seeds"):
    """Estimate creep, force and friction of a wandering wheelset with three filters, and compare their errors."""

    stiffness: Annotated[bool, Option(help="Only runs with an unknown creep stiffness.")] = False
    write: Annotated[bool, Option("--write", help="Write tables and figures into docs/papers.")] = False
    prediction: Annotated[Kind, Option(help="Form of the prediction in the filters: FMUs, or their equations.")] = "fmu"

    @property
    def place(self) -> str:
        """Folder of the runs on creep stiffness."""
        return "stiffness" if self.stiffness else ""

    def page(self, work: Work) -> Page:
        """Return the page of all runs, or of those on creep stiffness."""
        if self.stiffness:
            return _page_of_stiffness(2 if self.quick else SEEDS, 2.5 if self.quick else 10.0, work, write=self.write)
        plan = replace(QUICK if self.quick else FULL, prediction=self.prediction)
        return page_of(plan, work, write=self.write)

    def headlines(self, work: Work) -> list[Finding]:
        """Return errors of filters in one transition through all conditions, with softer contacts and other sensors."""
        cases = [LateralCase(test=TESTS[-1], speed=25.0, plant=plant, seed=1) for plant in _HEADLINES]
        findings: list[Finding] = []
        for (plant, names), measures in zip(_HEADLINES.items(), work.map(measure_case, cases), strict=True):
            for name in names:
                findings += _of_filter(f"lateral, {plant}, {name}", name, measures)
            constant = measures["constant"]["friction"]
            who = f"lateral, {plant}, the best constant"
            findings.append(Finding(f"{who}: friction RMSE", constant, "1", _TOLERANCE * constant))
            if measures["observability"] is not None:
                least = min(value for value in measures["observability"]["service"] if value is not None)
                who = f"lateral, {plant}: least sd of mu0, service sensors"
                findings.append(Finding(who, least, "1", _TOLERANCE * least))
        return findings


STUDY = Lateral


def _of_filter(who: str, name: str, measures: dict[str, Any]) -> list[Finding]:
    rms = measures["errors"][name]["friction"]["rmse"]
    findings = [Finding(f"{who}: friction RMSE", rms, "1", _TOLERANCE * abs(rms or 1))]
    if name in measures["detection"]:
        counts = measures["detection"][name]["confusion"]
        right = sum(counts[k][k] for k in range(len(CONDITIONS))) / sum(map(sum, counts))
        findings.append(Finding(f"{who}: condition right, share of time", right, "1", 0.01))
    return findings
