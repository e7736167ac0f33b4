"""A report to open in a browser: one self-contained page of table, figures and definitions, made of result files."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from railgrip.base.errors import RecordError
from railgrip.report import style
from railgrip.report.baseline import beyond_accepted
from railgrip.report.distances import rows_of, tables_of, write_table
from railgrip.report.distribution import distributions_of
from railgrip.report.distribution_figure import distribution_figure
from railgrip.report.figures import adhesion_figure, distance_figure, friction_figure, stop_figure
from railgrip.report.page import image, write_page
from railgrip.report.reference import is_published
from railgrip.report.results import Result, Results, from_elsewhere, read_results
from railgrip.report.table import names
from railgrip.scenario.campaign import DRAW, Panels
from railgrip.scenario.outcome import Outcome
from railgrip.trace.metrics import meanings
from railgrip.trace.stop import CAMPAIGN_FILE, PAGE_FILES, STOP_FILE, others_like, read_stop

_REFERENCES = (
    "Changes are against slip-based control (SBC) on the same rail: with the published thresholds, 10 and 15 % of "
    "slip, and with other ones, the best law over all stops of the same actuation and sensors. Where stops were "
    "repeated with the plant's parameters moved in the seventh digit, median and range stand beside the distance. "
    "In brackets: intervals that hold 95 %."
)

Notify = Callable[[str], None]


def write_report(
    directory: Path, *, panels: Panels = "all", notify: Notify = lambda _: None, baseline: Path | None = None
) -> Path:
    """Write index.html, and for a campaign table and figures beside it; return the page.

    Args:
        directory: Of a campaign (campaign.json) or a single stop (stop.json).
        panels: Of which stops of a campaign to draw the panels: all, those with adhesion-based control, none. Without
            them, the adhesion of ABC beside SBC is not drawn either.
        notify: Called with the name of what is drawn next.
        baseline: File with the accepted distances of the campaign; distances of other compilers' FMUs are compared.

    Raises:
        RecordError: The folder has neither, or a result is unreadable.
    """
    if (directory / CAMPAIGN_FILE).exists():
        results = read_results(directory)
        notes = [] if baseline is None else beyond_accepted(results, baseline)
        return _campaign_report(results, directory, panels=panels, notify=notify, notes=notes)
    if (directory / STOP_FILE).exists():
        record = read_stop(directory)
        result = Result(name=record.scenario["name"], variants={}, record=record, paper_distance=None)
        notify("stop")
        page, figure = (directory / name for name in PAGE_FILES)
        return write_page(
            page, "report/stop.html.jinja", **_page_values(result, style.save(stop_figure(result), figure))
        )
    like = others_like(directory) or "; name the folder of a run or campaign"
    raise RecordError(f"{directory}: has neither {CAMPAIGN_FILE} nor {STOP_FILE}{like}")


def _campaign_report(
    results: Results, directory: Path, *, panels: Panels, notify: Notify, notes: Sequence[str]
) -> Path:
    notify("table")
    write_table(results, directory, notes)
    rows = rows_of(results)
    figures: dict[str, str] = {}

    def add(name: str, caption: str, draw: Callable[[], Figure]) -> None:
        notify(name)
        figures[caption] = image(style.save(draw(), directory / "figures" / f"{name}.png"))

    distributions = distributions_of(rows)
    if distributions:
        add("distributions", "Braking distances over the draws", lambda: distribution_figure(distributions))
    single = [row for row in rows if row.draw is None]
    if any(row.distance_m is not None for row in single):
        add("distances", "Braking distances", lambda: distance_figure(single))
    scenarios = _longest_of_each_scenario([stop for stop in results.stops if stop.record.has_trace])
    if scenarios:
        add("friction", "Maximum friction at the wheelsets", lambda: friction_figure(scenarios))
    single_stops = [stop for stop in results.stops if DRAW not in stop.variants]
    pairs = _pairs(single_stops) if panels != "none" else []
    with_panels = {stop.name for stop in single_stops} if panels == "all" else {abc.name for _, abc in pairs}
    for sbc, abc in pairs:
        name = f"adhesion-{abc.name}"
        add(name, f"Adhesion of the first wheelset, {abc.name}", lambda sbc=sbc, abc=abc: adhesion_figure(sbc, abc))
    stops: list[dict[str, Any]] = []
    for stop in single_stops:
        signals = None
        if stop.name in with_panels:
            notify(stop.name)
            signals = style.save(stop_figure(stop), directory / "figures" / f"stop-{stop.name}.png")
        stops.append(_page_values(stop, signals))
    return write_page(
        directory / "index.html",
        "report/campaign.html.jinja",
        results=results,
        paragraphs=(results.description, _REFERENCES),
        tables=[table for table in tables_of(rows) if table],
        notes=[*from_elsewhere(results.stops), *notes],
        missing=names(results.missing),
        figures=figures,
        stops=stops,
    )


def _page_values(result: Result, signals: Path | None) -> dict[str, Any]:
    """Return what a page says of a stop."""
    record = result.record
    metrics = record.metrics
    return {
        "name": result.name,
        "headline": f"{metrics.distance:.1f} m in {metrics.duration:.1f} s"
        if record.outcome is Outcome.STANDSTILL
        else f"{record.outcome.value}: {record.reason}",
        "doubts": metrics.doubts(),
        "signals": None if signals is None else image(signals),
        "metrics": [
            (name.replace("_", " "), _text(getattr(metrics, name)), unit, meaning)
            for name, (unit, meaning) in meanings().items()
        ],
    }


def _longest_of_each_scenario(stops: Sequence[Result]) -> list[Result]:
    """Return one stop of each scenario; friction over time is the same for all, the longest shows most of it."""
    longest: dict[str, Result] = {}
    for stop in stops:
        name = stop.record.scenario["name"]
        has_protection = stop.record.scenario["controller"]["kind"] != "full_brake"
        if has_protection and (
            name not in longest or stop.record.metrics.duration > longest[name].record.metrics.duration
        ):
            longest[name] = stop
    return list(longest.values())


def _pairs(stops: Sequence[Result]) -> list[tuple[Result, Result]]:
    """Return the stops with ABC, each with the SBC stop that differs in nothing but the controller."""
    others = {_but_controller(stop): stop for stop in stops if is_published(stop.record.scenario["controller"])}
    return [
        (others[_but_controller(stop)], stop)
        for stop in stops
        if stop.variants.get("controller") == "adhesion_based" and _but_controller(stop) in others
    ]


def _but_controller(stop: Result) -> tuple[tuple[str, str], ...]:
    return tuple((axis, variant) for axis, variant in stop.variants.items() if axis != "controller")


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return (
            "\n".join(_text(element) for element in value)
            if value and isinstance(value[0], tuple)
            else ", ".join(_text(element) for element in value)
        )
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
