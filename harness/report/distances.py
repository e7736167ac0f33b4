"""The table of braking distances: one row a stop, as JSON for machines and texts for people.

Stops that differ only in their draw are shown as distributions, by `railgrip.report.distribution`.
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from railgrip.files import write_json
from railgrip.report.distribution import distribution_table, distributions_of
from railgrip.report.page import write_page
from railgrip.report.reference import best, controller_of, is_published, is_tuned, label, law_of
from railgrip.report.results import Result, Results, from_elsewhere, makers
from railgrip.report.row import Row
from railgrip.report.table import Form, Table, change, names, share
from railgrip.scenario.campaign import DRAW
from railgrip.scenario.conditioning import Repeated
from railgrip.trace.outcome import Outcome

STALE = "stale: other repeats"

VALVES = "pneumatic"
"""The actuation that has valves; the ideal one has turns of the pressure command."""


def rows_of(results: Results) -> tuple[Row, ...]:
    """Return the rows of a campaign, in its order."""
    published = {_conditions(stop): stop for stop in results.stops if is_published(_law(stop))}
    tuned = {_conditions(stop): stop for stop in _best_tuned(results.stops)}
    constant = _hidden_axes(results.stops)
    return tuple(
        _row(stop, published.get(_conditions(stop)), tuned.get(_conditions(stop)), constant) for stop in results.stops
    )


def write_table(results: Results, directory: Path, notes: Sequence[str] = ()) -> tuple[Path, Path]:
    """Write NAME.json and NAME.md of a campaign, with notes below its tables, and return their paths."""
    rows = rows_of(results)
    content = {
        "campaign": results.name,
        "rows": [asdict(row) for row in rows],
        "distributions": [asdict(distribution) for distribution in distributions_of(rows)],
        "missing": list(results.missing),
        "fmus": {stop.name: makers(stop.record.versions) for stop in results.stops},
    }
    as_json, as_markdown = directory / f"{results.name}.json", directory / f"{results.name}.md"
    write_json(as_json, content)
    places = dict.fromkeys((row.actuation, row.sensors, row.polach) for row in rows)
    sections = {place: [row for row in rows if (row.actuation, row.sensors, row.polach) == place] for place in places}
    write_page(
        as_markdown,
        "report/distances.md.jinja",
        results=results,
        sections={
            place: [table.without(_HEADING) for table in tables_of(here) if table] for place, here in sections.items()
        },
        missing=names(results.missing),
        notes=[*from_elsewhere(results.stops), *notes],
    )
    return as_json, as_markdown


def tables_of(rows: Sequence[Row]) -> tuple[Table, Table]:
    """Return the table of the rows that are draws and that of all others, without columns that have nothing in them."""
    return distribution_table(distributions_of(rows)).filled(), distance_table(rows).filled()


def distance_table(rows: Sequence[Row]) -> Table:
    """Return the rows that are no draws."""
    return Table([{name: of(row) for name, of in _COLUMNS.items()} for row in rows if row.draw is None], _FORMS)


_HEADING = ("actuation", "sensors", "creep curve")
"""Columns that are in the heading of a section."""

_COLUMNS: Mapping[str, Callable[[Row], Any]] = {
    "scenario": lambda row: row.label,
    "actuation": lambda row: row.actuation,
    "sensors": lambda row: row.sensors,
    "creep curve": lambda row: row.polach,
    "controller": lambda row: row.controller_label,
    "estimator": lambda row: row.estimator,
    "distance": lambda row: f"none: {row.outcome}" if row.distance_m is None else row.distance_m,
    "repeated": lambda row: row.repeated,
    "paper": lambda row: row.paper_distance_m,
    "vs SBC 10/15 %": lambda row: row.reduction_vs_sbc,
    "vs best tuned SBC": lambda row: row.reduction_vs_tuned,
    "paper vs SBC": lambda row: row.paper_reduction,
    "duration": lambda row: row.duration_s,
    "adhesion used": lambda row: row.utilisation,
    "longest lock": lambda row: row.longest_lock_s,
    "valve strokes": lambda row: row.valve_strokes,
    "air": lambda row: row.air_l,
    "NIS": lambda row: row.nis,
    "outside ±2σ": lambda row: row.outside,
}

_FORMS: Mapping[str, Form] = {
    **dict.fromkeys(("distance", "paper"), "{:.1f} m"),
    **dict.fromkeys(("vs SBC 10/15 %", "vs best tuned SBC", "paper vs SBC"), change),
    **dict.fromkeys(("adhesion used", "outside ±2σ"), share),
    "duration": "{:.1f} s",
    "longest lock": "{:.2f} s",
    "air": "{:.0f} l",
    "NIS": "{:.2g}",
}


def _row(result: Result, sbc: Result | None, tuned: Result | None, constant: Sequence[str]) -> Row:
    record = result.record
    metrics = record.metrics
    stands = record.outcome is Outcome.STANDSTILL
    return Row(
        scenario=record.scenario["name"],
        case=", ".join(f"{axis} {result.variants[axis]}" for axis in constant),
        polach=_polach(result),
        actuation=record.scenario["actuation"]["kind"],
        sensors=record.scenario["sensors"]["kind"],
        controller=controller_of(result.record.scenario),
        controller_label=label(result.record.scenario),
        estimator=_estimator(result),
        draw=int(result.variants[DRAW]) if DRAW in result.variants else None,
        reference="published" if sbc is result else "best tuned" if tuned is result else None,
        distance_m=record.braking_distance,
        repeated=spread_text(result.conditioning, record.digest, record.braking_distance),
        duration_s=metrics.duration if stands else None,
        reduction_vs_sbc=_reduction(record.braking_distance, sbc, result),
        reduction_vs_tuned=_reduction(record.braking_distance, tuned, result),
        utilisation=_number(metrics.utilisation),
        paper_distance_m=result.paper_distance,
        paper_reduction=None
        if sbc is None or sbc is result or sbc.paper_distance is None or result.paper_distance is None
        else 1 - result.paper_distance / sbc.paper_distance,
        outcome=record.outcome.value,
        longest_lock_s=_number(max(metrics.longest_lock)),
        valve_strokes=round(sum(metrics.actuations)) if record.scenario["actuation"]["kind"] == VALVES else None,
        air_l=_number(1000 * metrics.air_used),
        nis=metrics.nis_ratio,
        outside=max((*(metrics.adhesion_outside or ()), *(metrics.pad_friction_outside or ())), default=None),
        stop=result.name,
    )


def spread_text(conditioning: Repeated | None, digest: str, distance: float | None) -> str:
    """Return median and range of the repeats of a stop, nothing without any; repeats of another stop are said to be so.

    Args:
        digest: Of the scenario of the stop.
        distance: Of the stop [m], None without standstill.
    """
    if conditioning is None:
        return ""
    if not conditioning.belongs(digest, distance):
        return STALE
    others = "".join(
        f"; {compiler} {'no stop' if spread is None else f'{spread:.1f} m'}"
        for compiler, spread in conditioning.compilers.items()
    )
    return f"{conditioning.median:.2f} m ({conditioning.lowest:.2f} – {conditioning.highest:.2f} m){others}"


def _best_tuned(stops: Sequence[Result]) -> list[Result]:
    """Return the stops of the best SBC with thresholds of its own, one for each actuation, sensors and creep curve."""
    settings: dict[tuple[str, ...], list[Result]] = {}
    for stop in stops:
        if is_tuned(_law(stop)):
            settings.setdefault(_setting(stop), []).append(stop)
    candidates = (
        best(here, lambda stop: law_of(stop.record.scenario), lambda stop: stop.record.braking_distance)
        for here in settings.values()
    )
    return [stop for here in candidates for stop in here]


def _setting(result: Result) -> tuple[str, ...]:
    scenario = result.record.scenario
    return scenario["actuation"]["kind"], scenario["sensors"]["kind"], _polach(result)


def _column_values(result: Result) -> tuple[str, ...]:
    """Return what the columns of a row say about its scenario."""
    return (result.record.scenario["name"], *_setting(result), label(result.record.scenario), _estimator(result))


def _hidden_axes(stops: Sequence[Result]) -> tuple[str, ...]:
    """Return the axes in which stops differ that look the same in every column; draws have a place of their own."""
    alike: dict[tuple[str, ...], list[Result]] = {}
    for stop in stops:
        alike.setdefault(_column_values(stop), []).append(stop)
    axes = dict.fromkeys(axis for stop in stops for axis in stop.variants if axis != DRAW)
    return tuple(
        axis for axis in axes if any(len({stop.variants.get(axis) for stop in same}) > 1 for same in alike.values())
    )


def _conditions(result: Result) -> str:
    """Return everything that a stop shares with the one it is compared to: all but the controller and its estimator."""
    own = ("controller", "estimator")
    return json.dumps({key: value for key, value in result.record.scenario.items() if key not in own}, sort_keys=True)


def _law(result: Result) -> Mapping[str, Any]:
    return result.record.scenario["controller"]


def _estimator(result: Result) -> str:
    estimator = result.record.scenario["estimator"]
    return estimator["kind"] if estimator["kind"] == "none" else f"{estimator['model']} ({estimator['kind']})"


def _polach(result: Result) -> str:
    adhesion = result.record.scenario["adhesion"]
    of_places = (patch["polach"] for patch in adhesion.get("patch", ()) if patch.get("polach"))
    curves = (adhesion["polach"], *adhesion.get("polach_of_wheelset", ()), *of_places)
    return ", ".join(dict.fromkeys(curve["name"] for curve in curves))


def _number(value: float) -> float | None:
    """Return a figure, or None where it does not exist."""
    return value if math.isfinite(value) else None


def _reduction(distance: float | None, reference: Result | None, own: Result) -> float | None:
    """Return 1 − distance over that of the reference; None without either, and for the reference itself."""
    before = reference.record.braking_distance if reference is not None and reference is not own else None
    return None if distance is None or before is None else 1 - distance / before
