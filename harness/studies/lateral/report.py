"""The page of the lateral study."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from railgrip.report import style
from railgrip.report.page import write_page
from railgrip.report.style import save
from railgrip.studies.lateral.filters import NAMES
from railgrip.studies.lateral.judge import (
    DETECTOR,
    FRICTION_TOLERANCE,
    QUANTITIES,
    SHARE_TOLERANCE,
    WINDOW,
    beliefs_about,
)
from railgrip.studies.lateral.run import Case, Trace, simulate
from railgrip.studies.lateral.study import Plan, Result
from railgrip.studies.lateral.tables import (
    PLANT_TITLES,
    TITLES,
    detections,
    error_rows,
    error_tables,
    innovation_table,
    levels,
    observability_table,
    spread,
    write_csv,
)
from railgrip.studies.lateral.wheelset import PLANTS, SERVICE_SENSORS


def write_report(
    plan: Plan, results: Sequence[Result], directory: Path, tell: Callable[[str], None] = lambda what: None
) -> Path:
    """Write lateral.md, errors.csv and a figure of each test into a folder, and return the page."""
    rows = error_rows(results)
    write_csv(rows, directory / "errors.csv")
    speed = plan.middle_speed
    cases = [Case(test=test, speed=speed, plant="paper", seed=1) for test in plan.tests]
    cases += [Case(test=plan.tests[-1], speed=speed, plant=plant, seed=1) for plant in PLANTS if plant != "paper"]
    pictures: dict[str, str] = {}
    for case in cases:
        name = f"{case.test.name}{'' if case.plant == 'paper' else '_' + case.plant}.png"
        tell(name)
        save(test_figure(simulate(case)), directory / name)
        pictures[name] = case.test.name
    return write_page(
        directory / "lateral.md",
        "studies/lateral/lateral.md.jinja",
        seeds=plan.seeds,
        confidence=f"{spread([0.0] * plan.seeds).confidence:.0%}",
        friction_tolerance=FRICTION_TOLERANCE,
        share_tolerance=f"{SHARE_TOLERANCE:.0%}",
        window=WINDOW,
        sensors=SERVICE_SENSORS,
        speed=f"{speed:g}",
        detector=DETECTOR,
        announced=f"{DETECTOR.confidence:.0%}",
        errors=error_tables(rows),
        innovations=innovation_table(results),
        observability=observability_table(results),
        levels=levels(results),
        detections=detections(results),
        pictures=pictures,
    )


COLOURS: Final = {"literal": style.VERMILION, "known_track": style.BLUE, "unknown_track": style.GREEN}
LABELS: Final = {
    "lateral_velocity": "lateral velocity [m/s]",
    "yaw_rate": "yaw rate [rad/s]",
    "creep": "creep",
    "creep_force": "creep force [N]",
    "friction": "friction coefficient",
}


def test_figure(trace: Trace) -> Figure:
    """Return truth and estimates on the left, errors on the right, a row for each quantity."""
    drawing, panels = style.panels(11, 2.0 * len(QUANTITIES), len(QUANTITIES), 2, sharex=True)
    beliefs = {name: beliefs_about(trace, name) for name in NAMES}
    for (left, right), quantity in zip(panels, QUANTITIES, strict=True):
        truth = trace.truth[quantity]
        size = float(np.max(np.abs(truth)))
        left.plot(trace.time, truth, color=style.BLACK, linewidth=1.2, label="true")
        for name in NAMES:
            mean = beliefs[name][quantity].mean
            left.plot(trace.time, mean, color=COLOURS[name], linewidth=0.8, linestyle="--", label=TITLES[name])
            right.plot(trace.time, np.abs(mean - truth), color=COLOURS[name], linewidth=0.7)
        # Room for twice the truth: a filter that leaves the panel is wrong by more than all there is to estimate.
        bottom = -1.5 * size if np.min(truth) < 0 else -0.1 * size
        left.set_ylim(bottom, 1.5 * size)
        style.dress(left, y=LABELS[quantity])
        right.set_yscale("log")
        right.set_ylim(1e-7 * size, 1e1 * size)
        unit = LABELS[quantity].partition("[")[2]
        style.dress(right, y=f"|error| [{unit}" if unit else "|error|")
        for axes in (left, right):
            for change in trace.changes[1:]:
                axes.axvline(change, color=style.GREY, linewidth=0.8, linestyle=":")
    panels[0, 0].legend(ncols=2, fontsize=7, loc="upper right", framealpha=0.9)
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
        axes.set_xlim(0, trace.time[-1])
    case = trace.case
    drawing.suptitle(
        f"{case.test.name} at {case.speed:g} m/s, {PLANT_TITLES[case.plant]}, seed {case.seed}",
        fontsize=11,
        x=0.02,
        ha="left",
    )
    return drawing
