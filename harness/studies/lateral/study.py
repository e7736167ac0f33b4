"""The lateral study: its runs, its page with a figure of each test, and headline numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from matplotlib.figure import Figure
from typer import Option

from railgrip.campaign.work import Work
from railgrip.estimation.run import Kind
from railgrip.report import palette, style
from railgrip.report.baseline import Finding
from railgrip.report.marked import write_tables
from railgrip.report.page import Page
from railgrip.studies.lateral.judge import (
    DETECTOR,
    FRICTION_TOLERANCE,
    QUANTITIES,
    SHARE_TOLERANCE,
    WINDOW,
    beliefs_about,
    measure,
)
from railgrip.studies.lateral.literal import SHORT, Information, information, observed, refused
from railgrip.studies.lateral.run import NAMES, Case, simulate
from railgrip.studies.lateral.tables import (
    PLANT_TITLES,
    TITLES,
    Result,
    detections,
    error_rows,
    error_tables,
    flat,
    innovation_table,
    levels,
    observability_table,
    spread,
)
from railgrip.studies.lateral.wheelset import CONDITIONS, PLANTS, SERVICE_SENSORS, TESTS, Trial
from railgrip.studies.study import Study

SPEEDS: Final = (15.0, 25.0, 35.0)
"""Of the wheelset [m/s]; Mal et al. do not state theirs."""

SEEDS: Final = 10

PAGE: Final = Path("docs/papers.md")
"""From the folder of the project, where the command runs."""
OBSERVED: Final = "<!-- lateral, observed: written by `railgrip study lateral --write` -->"
REFUSED: Final = "<!-- lateral, refused: written by `railgrip study lateral --write` -->"
END: Final = "<!-- end -->"


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Runs of a study.

    Attributes:
        tests: Each at every speed on the plant of the filters; the last also at the middle speed on the other plants.
        speeds: [m/s].
        seeds: Number of seeds, from 1.
        prediction: Form of the prediction in the filters.
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
"""A few seconds of each: shows that it runs; its numbers mean nothing."""


def measured(case: Case) -> dict[str, Any]:
    """Run and measure one case; observability is that of the filters' model, so only on the plant that equals it."""
    return measure(simulate(case), observe=case.plant == "paper")


def literal_runs(plan: Plan, work: Work) -> list[Information]:
    """Return what the transition at the middle speed tells the literal filter, for each seed."""
    test, speed = plan.tests[-1], plan.middle_speed
    cases = [Case(test=test, speed=speed, plant="paper", seed=seed) for seed in range(1, plan.seeds + 1)]
    return work.map(information, cases)


def write_literal(page: Path, runs: Sequence[Information]) -> None:
    """Write both tables about the literal filter between their marks."""
    write_tables(page, {OBSERVED: observed(runs), REFUSED: refused(runs)}, END)


def page_of(plan: Plan, work: Work) -> Page:
    """Run a plan; return tables over its seeds, and a figure of each test."""
    # Compiled here once, so that no worker has to.
    simulate(Case(test=TESTS[0].shortened(0.01), speed=25.0, plant="paper", seed=0, prediction=plan.prediction))
    measures = work.map(measured, plan.cases)
    runs = literal_runs(plan, work)
    results = [Result(case=case, measures=own) for case, own in zip(plan.cases, measures, strict=True)]
    rows, speed = error_rows(results), plan.middle_speed
    drawn = replace(plan, speeds=(speed,), seeds=1).cases
    files = {f"{case.test.name}{'' if case.plant == 'paper' else '_' + case.plant}.png": case for case in drawn}
    drawings = work.map(test_figure, files.values(), keep=False)
    return Page(
        title="Wheelset with lateral and yaw dynamics",
        question="Can friction be estimated from lateral and yaw acceleration of a wheelset, and what has to be known?",
        answer=_answer(rows),
        template="studies/lateral/lateral.md.jinja",
        values={
            "seeds": plan.seeds,
            "confidence": f"{spread([0.0] * plan.seeds).confidence:.0%}",
            "friction_tolerance": FRICTION_TOLERANCE,
            "share_tolerance": f"{SHARE_TOLERANCE:.0%}",
            "window": WINDOW,
            "sensors": SERVICE_SENSORS,
            "speed": f"{speed:g}",
            "detector": DETECTOR,
            "announced": f"{DETECTOR.confidence:.0%}",
            "errors": error_tables(rows),
            "innovations": innovation_table(results),
            "observed": observed(runs),
            "refused": refused(runs),
            "short": SHORT,
            "mirrored": max(one.mirrored for one in runs),
            "observability": observability_table(results),
            "levels": levels(results),
            "detections": detections(results),
            "pictures": {name: case.test.name for name, case in files.items()},
        },
        figures=dict(zip(files, drawings, strict=True)),
        tables={"errors.csv": flat(rows)},
    )


def _answer(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the largest median RMS error of friction of each filter on the plant that it has as model."""
    errors: dict[str, list[float]] = {}
    for row in rows:
        if row["plant"] == "paper" and row["quantity"] == "friction":
            errors.setdefault(TITLES[row["filter"]], []).append(row["rmse"].median)
    words = (f"{name} {min(own):.3g} to {max(own):.3g}" for name, own in errors.items())
    return f"Median RMSE of friction over tests and speeds, with the exact model: {'; '.join(words)}."


_TOLERANCE: Final = 0.05
"""Relative tolerance of rms errors, for rounding of another machine over half a million steps."""
_HEADLINES: Final = {
    "paper": ("literal", "known_track", "unknown_track"),
    "softer": ("known_track",),
    "slightly_softer": ("known_track",),
    "service": ("known_track", "unknown_track"),
}
"""Filters of the headlines by plant."""


@dataclass(frozen=True)
class Lateral(Study):
    """Estimate creep, force and friction of a wandering wheelset with three filters, and judge them."""

    quick: bool = False
    write: Annotated[bool, Option("--write", help="Write what readings determine into docs/papers.md.")] = False
    prediction: Annotated[Kind, Option(help="Form of the prediction in the filters: FMUs, or their equations.")] = "fmu"

    @property
    def place(self) -> str:
        """Folder of the quick form."""
        return "quick" if self.quick else ""

    def page(self, work: Work) -> Page:
        """Return the page of all runs."""
        plan = replace(QUICK if self.quick else FULL, prediction=self.prediction)
        if self.write:
            write_literal(PAGE, literal_runs(plan, work))
        return page_of(plan, work)

    def headlines(self, work: Work) -> list[Finding]:
        """Return errors of filters in one transition through all conditions, with softer contacts and other sensors."""
        cases = [Case(test=TESTS[-1], speed=25.0, plant=plant, seed=1) for plant in _HEADLINES]
        findings: list[Finding] = []
        for (plant, names), measures in zip(_HEADLINES.items(), work.map(measured, cases), strict=True):
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


COLOURS: Final = {"literal": palette.VERMILION, "known_track": palette.BLUE, "unknown_track": palette.GREEN}
LABELS: Final = {
    "lateral_velocity": "lateral velocity [m/s]",
    "yaw_rate": "yaw rate [rad/s]",
    "creep": "creep",
    "creep_force": "creep force [N]",
    "friction": "friction coefficient",
}


def test_figure(case: Case) -> Figure:
    """Run a case; draw truth and estimates on the left, errors on the right, a row for each quantity."""
    trace = simulate(case)
    drawing, panels = style.panels(11, 2.0 * len(QUANTITIES), len(QUANTITIES), 2, sharex=True)
    beliefs = {name: beliefs_about(trace, name) for name in NAMES}
    for (left, right), quantity in zip(panels, QUANTITIES, strict=True):
        truth = trace.truth[quantity]
        size = float(np.max(np.abs(truth)))
        left.plot(trace.time, truth, color=palette.BLACK, linewidth=1.2, label="true")
        for name in NAMES:
            mean = beliefs[name][quantity].mean
            left.plot(trace.time, mean, color=COLOURS[name], linewidth=0.8, linestyle="--", label=TITLES[name])
            right.plot(trace.time, np.abs(mean - truth), color=COLOURS[name], linewidth=0.7)
        # A curve outside of the panel has an error of more than half of the largest true value.
        bottom = -1.5 * size if np.min(truth) < 0 else -0.1 * size
        left.set_ylim(bottom, 1.5 * size)
        style.dress(left, y=LABELS[quantity])
        right.set_yscale("log")
        right.set_ylim(1e-7 * size, 1e1 * size)
        unit = LABELS[quantity].partition("[")[2]
        style.dress(right, y=f"|error| [{unit}" if unit else "|error|")
        for axes in (left, right):
            for change in trace.changes[1:]:
                axes.axvline(change, color=palette.GREY, linewidth=0.8, linestyle=":")
    panels[0, 0].legend(ncols=2, fontsize=7, loc="upper right", framealpha=0.9)
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
        axes.set_xlim(0, trace.time[-1])
    drawing.suptitle(
        f"{case.test.name} at {case.speed:g} m/s, {PLANT_TITLES[case.plant]}, seed {case.seed}",
        fontsize=11,
        x=0.02,
        ha="left",
    )
    return drawing
