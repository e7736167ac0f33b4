"""The page of the lateral study."""

from collections.abc import Callable, Sequence
from pathlib import Path

from railgrip.report.page import write_page
from railgrip.report.style import save
from railgrip.studies.lateral.figures import test_figure
from railgrip.studies.lateral.judge import DETECTOR, FRICTION_TOLERANCE, SHARE_TOLERANCE, WINDOW
from railgrip.studies.lateral.run import Case, simulate
from railgrip.studies.lateral.study import Plan, Result
from railgrip.studies.lateral.tables import (
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
