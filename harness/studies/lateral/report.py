"""The page of the lateral study."""

from collections.abc import Callable, Sequence
from pathlib import Path

from railgrip.record.atomic import write_text
from railgrip.report.style import save
from railgrip.studies.lateral.figures import test_figure
from railgrip.studies.lateral.judge import DETECTOR, FRICTION_TOLERANCE, SHARE_TOLERANCE, WINDOW
from railgrip.studies.lateral.run import Case, simulate
from railgrip.studies.lateral.study import Plan, Result
from railgrip.studies.lateral.tables import (
    detection_lines,
    error_rows,
    error_tables,
    innovation_lines,
    level_lines,
    observability_lines,
    spread,
    write_csv,
)
from railgrip.twins.lateral import PLANTS, SERVICE_SENSORS


def write_report(
    plan: Plan, results: Sequence[Result], directory: Path, tell: Callable[[str], None] = lambda what: None
) -> Path:
    """Write lateral.md, errors.csv and a figure of each test into a folder, and return the page."""
    rows = error_rows(results)
    write_csv(rows, directory / "errors.csv")
    speed = plan.middle_speed
    cases = [Case(test=test, speed=speed, plant="paper", seed=1) for test in plan.tests]
    cases += [Case(test=plan.tests[-1], speed=speed, plant=plant, seed=1) for plant in PLANTS if plant != "paper"]
    pictures: list[str] = []
    for case in cases:
        name = f"{case.test.name}{'' if case.plant == 'paper' else '_' + case.plant}.png"
        tell(name)
        save(test_figure(simulate(case)), directory / name)
        pictures += [f"![{case.test.name}]({name})", ""]
    confidence = spread([0.0] * plan.seeds).confidence
    page = directory / "lateral.md"
    write_text(
        page,
        "\n".join(
            [
                "# Wheelset with lateral and yaw dynamics",
                "",
                "After Mal, Hussain, Chowdhry and Memon (2020). Track: random, scaled to ±7 mm in every run, white "
                "noise through a low-pass of second order at 2 Hz; the paper gives neither spectrum nor speed. Plant, "
                "readings and filters at 50 µs; readings with the paper's noise, 0.32 mm/s² and 0.32 µrad/s.",
                "",
                f"Figures are medians over {plan.seeds} seeds, in brackets an interval that holds the median with "
                f"{confidence:.0%}. NEES is the mean of e²/σ² of the quantity: one for a filter that knows its "
                f"errors. Settled: friction within {FRICTION_TOLERANCE:g} for good, all else within "
                f"{SHARE_TOLERANCE:.0%} of its rms; the slowest of a run's changes counts, ∞ is never.",
                "",
                "The literal filter knows track and condition and has a Q for each; its creep and force are judged by "
                "magnitude, as its equations do not tell their signs. The others have one Q and know no condition.",
                "",
                "## Errors",
                "",
                *error_tables(rows),
                "## What innovations tell of the filters",
                "",
                "Lost: innovations were ten times what the filter claims, or it failed; its belief means nothing from "
                "then on. NIS: median over the expected one, 1 for a consistent filter. The best constant is what "
                "knows nothing but the mean of the true friction of the run.",
                "",
                *innovation_lines(results),
                "## Where friction can be known at all",
                "",
                f"Standard deviation to which μ0 is told by {WINDOW:g} s of readings alone, the track known and the "
                "model exact (from the observability Gramian along the true run): a bound for every filter. Service "
                f"sensors: {SERVICE_SENSORS[0]:g} m/s² and {SERVICE_SENSORS[1]:g} rad/s at 50 µs. Windows of "
                f"{plan.seeds} seeds.",
                "",
                *observability_lines(results),
                "## What an inexact model costs",
                "",
                f"The transition at {speed:g} m/s, {plan.seeds} seeds: what the filters that know no condition believe "
                f"of μ0 from {WINDOW:g} s after each change on.",
                "",
                *level_lines(results),
                "## Detected condition",
                "",
                f"Announced when {DETECTOR.confidence:.0%} probable for {DETECTOR.hold:g} s, with "
                f"{DETECTOR.model_deviation:g} added to the filter's σ(μ0). A delay of 0.001 s is a condition that "
                "had been announced, wrongly, before it came.",
                "",
                *detection_lines(results),
                "## The five tests",
                "",
                *pictures,
            ]
        ),
    )
    return page
