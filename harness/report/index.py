"""Write the report of results: one self-contained page for a browser of a campaign, or of a stop."""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from railgrip.base.errors import InputError
from railgrip.base.groups import gather
from railgrip.base.records import claim
from railgrip.report import style
from railgrip.report.baseline import baseline_deviations
from railgrip.report.campaign_figures import (
    FIGURE_MEANING,
    adhesion_figure,
    distance_figure,
    distribution_figure,
    exceedance_figure,
    friction_figure,
    overview_figure,
)
from railgrip.report.comparison import flat, unit_of, without_numbers
from railgrip.report.distances import (
    caveats_of,
    headline,
    meaning_of,
    overview_of,
    overview_table,
    reader_tables,
    repeats_table,
    setting_tables,
    write_table,
)
from railgrip.report.distribution import (
    ReferenceVariant,
    change_table,
    changes_against,
    distributions_of,
    quantile_table,
    worst_table,
)
from railgrip.report.frame import Frame, frame_of, single_stops
from railgrip.report.limits import describe_clauses, limits_of
from railgrip.report.page import FORMATS, Page
from railgrip.report.reference import is_published, label
from railgrip.report.results import Results, from_elsewhere, provenance, read_results, remarks_on
from railgrip.report.signals import signals_plot
from railgrip.report.statistics import finite
from railgrip.report.stop import (
    PAGE_FILES,
    Stop,
    is_campaign,
    metrics_table,
    read_stop,
    value_text,
)
from railgrip.report.table import ReportTable, names
from railgrip.scenario.campaign import DRAW, Panels, PlannedStop
from railgrip.scenario.keys import meanings_of_keys
from railgrip.scenario.outcome import Outcome


def stop_page(stop: Stop, *, back: str = "") -> Page:
    """Return the page of a stop; without samples it has no figure of the signals.

    Args:
        stop: The stop.
        back: Address of the page of its campaign.

    Raises:
        RecordError: The samples do not belong to the figures of the stop.
    """
    scenario = stop.inputs
    return Page(
        title=f"Stop {stop.name}",
        question=question(scenario),
        answer=answer(stop),
        template="report/stop.md.jinja",
        values={
            "back": back,
            "doubts": [*stop.metrics.doubts(), *stop.remarks, *stop.warning_sentences()],
            "reason": stop.reason,
            "description": scenario.get("description", ""),
            "scenario": scenario_table(scenario),
            "metrics": metrics_table(stop.figures),
        },
        signals=signals_plot(stop.trace, stop.cars) if stop.has_trace else None,
        provenance=provenance(stop),
    )


def question(scenario: Mapping[str, Any]) -> str:
    """Return the question of a scenario, one sentence."""
    estimator, speed = scenario["estimator"]["kind"], 3.6 * scenario["start"]["speed"]
    return (
        f"How far does the train travel from {speed:.0f} km/h on the rail “{scenario['name'].replace('_', ' ')}” under "
        f"{label(scenario)}, with {scenario['actuation']['kind']} actuation, {scenario['sensors']['kind']} sensors and "
        f"{'no estimator' if estimator == 'none' else f'estimator {estimator}'}?"
    )


def answer(stop: Stop) -> str:
    """Return distance and duration, and the utilisation of the adhesion, in two sentences."""
    metrics = stop.metrics
    way = f"{metrics.distance_travelled:.1f} m in {metrics.duration:.1f} s"
    first = (
        f"The train stops in {way}."
        if stop.outcome is Outcome.STANDSTILL
        else f"The train does not come to a standstill: the stop ends with {stop.outcome.value} after {way}."
    )
    share = f"It uses {100 * metrics.utilisation:.1f} % of the possible adhesion, and its"
    second = (
        f"{share if isfinite(metrics.utilisation) else 'Its'} longest lock lasts {max(metrics.longest_lock):.2f} s."
    )
    if isfinite(metrics.adhesion_allowed):
        second += f" The creep curve allows an adhesion α of {metrics.adhesion_allowed:.4f}, a mean for v²/(2 g α)."
    return f"{first} {second}"


def scenario_table(scenario: Mapping[str, Any]) -> ReportTable:
    """Return every key of a scenario in SI units, with its meaning."""
    rows = [
        {"key": key, "value": ", ".join(map(value_text, value)) if isinstance(value, list) else value_text(value),
         "unit": unit_of(key), "meaning": meanings_of_keys().get(without_numbers(key), "")}
        for key, value in flat(scenario).items()
    ]  # fmt: skip
    return ReportTable(rows, left=("key", "value", "unit", "meaning"))


_LEGEND: Mapping[str, str] = {
    "reduction_vs_sbc": "Changes are against slip-based control (SBC) on the same rail: with the published thresholds, "
    "10 and 15 % of slip, and with other ones, the best law over all stops of the same actuation and sensors.",
    "repeated": "Each row is one run; repeats with the plant's parameters moved in the seventh digit have a table.",
    "draw": "In brackets: intervals that hold 95 %.",
    "outside": "A filter that states its errors correctly has a NIS, the median squared innovation over the expected "
    "one, near 1, and a true adhesion or pad friction outside of ±2σ of its estimate for 5 % of the time; of all "
    "groups the largest share is shown. With more, estimates are less certain than the filter says.",
}
"""Column of a campaign → sentence for a page on which a stop has a value in it."""

IN_BROWSER = "stop.html"
"""Page that runs a stop (`railgrip export --page`), to which that of a campaign in the same folder has a link."""

Notify = Callable[[str], None]


def write_report(
    directory: Path,
    *,
    panels: Panels = "all",
    notify: Notify = lambda _: None,
    baseline: Path | None = None,
    formats: Sequence[str] = FORMATS[:1],
    against: str | None = None,
) -> Path:
    """Write index.html, and for a campaign table, figures and the pages of its stops; return the path of the page.

    Args:
        directory: Folder of a campaign (campaign.json) or of a single stop (stop.json).
        panels: Stops of a campaign that get a page with panels: all that have samples, those with adhesion-based
            control, or none. With none, the figure of peak seeking and SBC is omitted as well.
        notify: Called with the name of the next figure.
        baseline: File with the accepted distances of the campaign; distances of other compilers' FMUs are compared.
        formats: Formats of the figure files.
        against: Variant with which the others of its axis are compared in pairs; see `ReferenceVariant.find`.

    Raises:
        RecordError: The folder has neither file, or a result is unreadable.
        InputError: The campaign has no variant `against`, or the folder is that of a stop.
    """
    if not is_campaign(directory):
        if against is not None:
            raise InputError(f"--against {against}: {directory} holds a stop; only a campaign has variants.")
        stop = read_stop(directory)
        notify("stop")
        if stop.has_trace:
            claim(directory, *(f"stop.{form}" for form in formats))
            style.save_as(stop.plot(), directory / PAGE_FILES[1], formats)
        return stop_page(stop).write(directory)
    results = read_results(directory)
    notes = [] if baseline is None else baseline_deviations(results, baseline)
    reference = reference_of(results.stops, against)
    notify("table")
    write_table(results, directory, notes)
    single = [stop for stop in results.stops if DRAW not in stop.variants]
    pairs = _pairs(single) if panels != "none" else []
    longest = {row["stop"] for row in worst_table(frame_of(results), {}).rows}
    with_panels = {"all": results.stops, "abc": [abc for _, abc in pairs], "none": ()}[panels]
    chosen = [stop for stop in with_panels if stop.has_trace and stop.name not in longest]
    # The longest of all draws have a page even if their samples were not kept.
    chosen += [stop for stop in results.stops if stop.name in longest]
    pages = {stop.name: f"{stop.name}/index.html" for stop in chosen}
    for stop in chosen:
        notify(stop.name)
        stop_page(stop, back="../index.html").write(directory / stop.name)
    page = campaign_page(results, notes=notes, pages=pages, pairs=pairs, notify=notify, reference=reference)
    if (directory / IN_BROWSER).is_file():
        page = replace(page, values={**page.values, "in_browser": IN_BROWSER})
    return page.write(directory, formats)


def reference_of(stops: Iterable[Stop | PlannedStop], against: str | None) -> ReferenceVariant | None:
    """Find the variant among the stops of a campaign that a user has named; None without a name.

    Raises:
        InputError: See `ReferenceVariant.find`.
    """
    return None if against is None else ReferenceVariant.find(against, [stop.variants for stop in stops])


def campaign_page(
    results: Results,
    *,
    notes: Sequence[str],
    pages: Mapping[str, str],
    pairs: Sequence[tuple[Stop, Stop]],
    notify: Notify,
    reference: ReferenceVariant | None = None,
) -> Page:
    """Return the page of a campaign.

    Args:
        results: Results of its stops.
        notes: Sentences below the tables.
        pages: Name of a stop → address of its page.
        pairs: Stops with SBC and with peak seeking whose adhesion is drawn.
        notify: Called with the name of the next figure.
        reference: Variant with which the others of its axis are compared.
    """
    frame = frame_of(results)
    changes = () if reference is None else changes_against(reference, results.stops, frame)
    figures: dict[str, Figure] = {}
    captions: dict[str, str] = {}

    def draw(name: str, caption: str, figure_of: Callable[..., Figure], *of: Any) -> None:
        notify(name)
        figures[f"figures/{name}.png"], captions[f"figures/{name}.png"] = figure_of(*of), caption

    overview, distributions, single = overview_of(frame), distributions_of(frame), single_stops(frame)
    if overview is not None:
        draw("overview", "", overview_figure, overview)
    if len(distributions):
        draw("exceedance", "", exceedance_figure, distributions, results.permitted_distance)
        draw("distributions", "Braking distances over the draws", distribution_figure, distributions)
    if single["distance"].count():
        metres = [finite(stated.median) for stated in single["stated"]]
        stated = single.assign(distance=metres, reduction_vs_sbc=-single["stated_vs_sbc"])
        draw("distances", "Braking distances", distance_figure, stated.astype({"distance": float}))
    protected = [stop for stop in results.stops if stop.has_trace and stop.inputs["controller"]["kind"] != "full_brake"]
    if protected:
        draw("friction", "Maximum friction at the wheelsets", friction_figure, protected)
    for sbc, abc in pairs:
        draw(f"adhesion-{abc.name}", f"Adhesion of the first wheelset, {abc.name}", adhesion_figure, sbc, abc)
    return Page(
        title=results.description.rstrip(".") or f"Campaign {results.name}",
        question="Which braking distance does each controller need in the same conditions?",
        answer=headline(frame, reference, changes),
        caveats=() if overview is None else caveats_of(overview, results.published),
        overview=None if overview is None else overview_table(overview),
        note="" if overview is None else f"{meaning_of(overview)} {FIGURE_MEANING}",
        narrow={} if overview is None else {"figures/overview.png": overview_figure(overview, is_narrow=True)},
        template="report/campaign.md.jinja",
        values={
            "in_browser": "",
            "references": " ".join(_legend(frame)),
            "changes": [] if reference is None else change_table(reference, changes).parts(),
            "quantiles": quantile_table(distributions, results.permitted_distance).parts(),
            "worst": worst_table(frame, pages).parts(),
            "tables": reader_tables(frame, pages) if overview is None else [],
            "sections": {} if overview is None else setting_tables(frame, pages),
            "repeats": repeats_table(frame, pages),
            "notes": [*remarks_on(results.stops), *from_elsewhere(results.stops), *notes],
            "missing": names(results.missing),
            "captions": dict(list(captions.items())[1:]),
            "scenarios": _scenarios(results.stops),
        },
        figures=figures,
        provenance=_provenance(results),
    )


def _legend(frame: Frame) -> list[str]:
    sentences = [text for column, text in _LEGEND.items() if frame[column].dropna().astype(bool).any()]
    if any(frame["breaks"]):
        sentences.append(
            "Column “breaks” lists the limits of the type test that a stop does not keep. A controller or variant that "
            f"breaks one in any stop is not recommended. Judged are: {describe_clauses(limits_of())}."
        )
    return sentences


def _scenarios(stops: Sequence[Stop]) -> ReportTable:
    rows = []
    for name, scenarios in gather((stop.inputs["name"], stop.inputs) for stop in stops).items():
        seeds = sorted({scenario["seed"] for scenario in scenarios})
        speeds = sorted({scenario["start"]["speed"] for scenario in scenarios})
        rows.append(
            {
                "scenario": name,
                "description": scenarios[0].get("description", ""),
                "train": ", ".join(sorted({_train_of(scenario["vehicle"]) for scenario in scenarios})),
                "start speed": ", ".join(f"{3.6 * speed:.4g} km/h" for speed in speeds),
                "seeds": str(seeds[0]) if len(seeds) == 1 else f"{seeds[0]} to {seeds[-1]}, {len(seeds)} of them",
                "stops": len(scenarios),
            }
        )
    return ReportTable(rows, left=("scenario", "description", "train", "start speed", "seeds"))


def _train_of(vehicle: Mapping[str, Any]) -> str:
    return str(next((vehicle[key] for key in ("train", "model", "plant") if vehicle.get(key)), "unknown"))


def _provenance(results: Results) -> dict[str, str]:
    versions = gather(pair for stop in results.stops for pair in stop.versions.items())
    digests = "".join(sorted(f"{stop.digest}{stop.trace_digest}" for stop in results.stops))
    dates = sorted(filter(None, (provenance(stop)["result written"] for stop in results.stops)))
    return {
        "digest of scenarios and traces (SHA-256)": hashlib.sha256(digests.encode()).hexdigest(),
        "results written": f"{dates[0]} to {dates[-1]}" if dates else "–",
        **{name: ", ".join(sorted(set(of))) for name, of in sorted(versions.items())},
    }


def _pairs(stops: Sequence[Stop]) -> list[tuple[Stop, Stop]]:
    """Return the stops with peak seeking, each with the SBC stop that differs only in the controller."""
    others = {_without_controller(stop): stop for stop in stops if is_published(stop.inputs["controller"])}
    return [
        (others[_without_controller(stop)], stop)
        for stop in stops
        if stop.variants.get("controller") == "adhesion_based" and _without_controller(stop) in others
    ]


def _without_controller(stop: Stop) -> tuple[tuple[str, str], ...]:
    return tuple((axis, variant) for axis, variant in stop.variants.items() if axis != "controller")
