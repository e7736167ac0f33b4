"""A report to open in a browser: one self-contained page of table, figures and definitions, made of result files."""

import base64
import html
import math
from collections.abc import Callable, Sequence
from pathlib import Path

from matplotlib.figure import Figure

from railgrip.errors import RecordError
from railgrip.record.atomic import write_text
from railgrip.record.metrics import meanings
from railgrip.record.outcome import Outcome
from railgrip.record.stop import STOP_FILE, read_stop
from railgrip.report import style
from railgrip.report.compilers import from_elsewhere
from railgrip.report.distribution import distribution_texts, distributions_of
from railgrip.report.distribution_figure import distribution_figure
from railgrip.report.figures import adhesion_figure, distance_figure, friction_figure, stop_figure
from railgrip.report.panels import Panels
from railgrip.report.reference import is_published
from railgrip.report.results import CAMPAIGN_FILE, Result, Results, read_results
from railgrip.report.table import row_texts, rows_of, write_table
from railgrip.report.text import html_table, names
from railgrip.scenario.campaign import DRAW

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 75rem; padding: 0 1rem; color: #1b1b1b }
table { border-collapse: collapse; margin: .5rem 0 1.5rem } th, td { padding: .25rem .7rem; text-align: right }
th { border-bottom: 2px solid #999 } td { border-bottom: 1px solid #ddd }
td.text, th.text { text-align: left } img { max-width: 100%; height: auto } figure { margin: 1rem 0 }
details { margin: .4rem 0 } summary { cursor: pointer } .bad { color: #a03000 }
"""

_REFERENCES = (
    "Changes are against slip-based control (SBC) on the same rail: with the published thresholds, 10 and 15 % of "
    "slip, and with other ones, the best law over all stops of the same actuation and sensors. Where stops were "
    "repeated with the plant's parameters moved in the seventh digit, median and range stand beside the distance. "
    "In brackets: intervals that hold 95 %."
)

Tell = Callable[[str], None]


def write_report(directory: Path, *, panels: Panels = Panels.ALL, tell: Tell = lambda _: None) -> Path:
    """Write index.html, and for a campaign table and figures beside it; return the page.

    Args:
        directory: Of a campaign (campaign.json) or a single stop (stop.json).
        panels: Of which stops of a campaign to draw the panels: all, those with adhesion-based control, none. Without
            them, the adhesion of ABC beside SBC is not drawn either.
        tell: Called with what is being drawn.

    Raises:
        RecordError: The folder has neither, or a result is unreadable.
    """
    if (directory / CAMPAIGN_FILE).exists():
        return _campaign_report(read_results(directory), directory, panels=panels, tell=tell)
    if (directory / STOP_FILE).exists():
        record = read_stop(directory)
        result = Result(name=record.scenario["name"], variants={}, record=record, paper_distance=None)
        tell("stop")
        image = style.save(stop_figure(result), directory / "stop.png")
        body = [*_doubts(result), _image(image, "Signals of the stop"), _metrics_table(result)]
        return _page(directory, f"{result.name}: {_headline(result)}", body)
    raise RecordError(f"{directory}: has neither {CAMPAIGN_FILE} nor {STOP_FILE}; name the folder of a run or campaign")


def _campaign_report(results: Results, directory: Path, *, panels: Panels, tell: Tell) -> Path:
    tell("table")
    write_table(results, directory)
    rows = rows_of(results)
    distributions = distributions_of(rows)
    body = [f"<p>{html.escape(results.description)}</p>", f"<p>{html.escape(_REFERENCES)}</p>"]
    body += [html_table(texts) for texts in (distribution_texts(distributions), row_texts(rows)) if texts]
    body += [f"<p>{html.escape(sentence)}</p>" for sentence in from_elsewhere(results.stops)]
    if results.missing:
        body.append(f'<p class="bad">Not run: {html.escape(names(results.missing))}.</p>')

    def add(name: str, caption: str, draw: Callable[[], Figure]) -> None:
        tell(name)
        body.append(_image(style.save(draw(), directory / "figures" / f"{name}.png"), caption))

    if distributions:
        add("distributions", "Braking distances over the draws", lambda: distribution_figure(distributions))
    single = [row for row in rows if row.draw is None]
    if any(row.distance_m is not None for row in single):
        add("distances", "Braking distances", lambda: distance_figure(single))
    scenarios = _longest_of_each_scenario([stop for stop in results.stops if stop.record.has_trace])
    if scenarios:
        add("friction", "Maximum friction at the wheelsets", lambda: friction_figure(scenarios))
    shown = [stop for stop in results.stops if DRAW not in stop.variants]
    pairs = _pairs(shown) if panels is not Panels.NONE else []
    pictured = {stop.name for stop in shown} if panels is Panels.ALL else {abc.name for _, abc in pairs}
    for sbc, abc in pairs:
        name = f"adhesion-{abc.name}"
        add(name, f"Adhesion of the first wheelset, {abc.name}", lambda sbc=sbc, abc=abc: adhesion_figure(sbc, abc))
    body.append("<h2>Stops</h2>")
    for result in shown:
        inside = [*_doubts(result), _metrics_table(result)]
        if result.name in pictured:
            tell(result.name)
            image = style.save(stop_figure(result), directory / "figures" / f"stop-{result.name}.png")
            inside.insert(-1, _image(image, f"Signals of {result.name}"))
        head = f"<summary>{html.escape(result.name)}: {html.escape(_headline(result))}</summary>"
        body.append(f"<details>{head}{''.join(inside)}</details>")
    return _page(directory, f"Campaign {results.name}", body)


def _longest_of_each_scenario(stops: Sequence[Result]) -> list[Result]:
    """Return one stop of each scenario; friction over time is the same for all, the longest shows most of it."""
    longest: dict[str, Result] = {}
    for stop in stops:
        name = stop.record.scenario["name"]
        protected = stop.record.scenario["controller"]["kind"] != "full_brake"
        if protected and (name not in longest or stop.record.metrics.duration > longest[name].record.metrics.duration):
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


def _headline(result: Result) -> str:
    metrics = result.record.metrics
    if result.record.outcome is not Outcome.STANDSTILL:
        return f"{result.record.outcome.value}: {result.record.reason}"
    return f"{metrics.distance:.1f} m in {metrics.duration:.1f} s"


def _doubts(result: Result) -> list[str]:
    return [f'<p class="bad">{html.escape(sentence)}</p>' for sentence in result.record.metrics.doubts()]


def _metrics_table(result: Result) -> str:
    lines = [
        f'<tr><td class="text">{name.replace("_", " ")}</td><td>{_spelled(getattr(result.record.metrics, name))}</td>'
        f'<td class="text">{html.escape(unit)}</td><td class="text">{html.escape(meaning)}</td></tr>'
        for name, (unit, meaning) in meanings().items()
    ]
    head = '<tr><th class="text">figure</th><th>value</th><th class="text">unit</th><th class="text">meaning</th></tr>'
    return f"<table>{head}{''.join(lines)}</table>"


def _spelled(value: object) -> str:
    if isinstance(value, tuple):
        return (
            "<br>".join(_spelled(element) for element in value)
            if value and isinstance(value[0], tuple)
            else ", ".join(_spelled(element) for element in value)
        )
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _image(path: Path, caption: str) -> str:
    """Return a figure with the image inside the page, so that the page can be mailed alone."""
    data = base64.b64encode(path.read_bytes()).decode()
    return f'<figure><img alt="{html.escape(caption)}" src="data:image/png;base64,{data}"></figure>'


def _page(directory: Path, title: str, body: Sequence[str]) -> Path:
    page = directory / "index.html"
    said = html.escape(title)
    head = f'<meta charset="utf-8"><title>{said}</title><style>{_STYLE}</style>'
    whole = f"<html lang=en><head>{head}</head><body><h1>{said}</h1>{''.join(body)}</body></html>"
    write_text(page, f"<!doctype html>{whole}\n")
    return page
