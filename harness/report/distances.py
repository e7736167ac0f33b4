"""The table of braking distances: one row for each stop, as JSON for programs and as text for readers.

Stops that differ only in their draw are summarised as distributions, by `railgrip.report.distribution`.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, replace
from math import isfinite
from pathlib import Path
from types import MappingProxyType
from typing import Any

from railgrip.base.files import write_json
from railgrip.base.outputs import claim
from railgrip.report.distribution import distribution_table, distributions_of
from railgrip.report.limits import SUBJECTS, limits_of
from railgrip.report.page import write_page
from railgrip.report.reference import controller_of, label, locked_text, references, setting_of
from railgrip.report.results import Results, fmu_tools, from_elsewhere, remarks_on
from railgrip.report.row import Row
from railgrip.report.statistics import finite
from railgrip.report.stop import Stop
from railgrip.report.table import Form, Link, ReportTable, change, names, percent, share
from railgrip.scenario.campaign import DRAW
from railgrip.scenario.conditioning import RepeatedDistances
from railgrip.scenario.outcome import Outcome

STALE = "stale: other repeats"

VALVES = "pneumatic"
"""Kind of actuation with valves; with the ideal one, reversals of the pressure command are counted."""


def rows_of(results: Results) -> tuple[Row, ...]:
    """Return the rows of a campaign, in its order."""
    constant = _hidden_axes(results.stops)
    compared_with = references(results.stops, lambda stop: stop.inputs, lambda stop: stop.braking_distance)
    limits = limits_of()
    return tuple(
        _row(stop, published, tuned, constant, limits.find_violations(stop))
        for stop, (published, tuned) in zip(results.stops, compared_with, strict=True)
    )


def write_table(results: Results, directory: Path, notes: Sequence[str] = ()) -> tuple[Path, Path]:
    """Write NAME.json and NAME.md of a campaign, with notes below its tables, and return their paths."""
    rows = rows_of(results)
    content = {
        "campaign": results.name,
        "rows": [asdict(row) for row in rows],
        "distributions": [asdict(distribution) for distribution in distributions_of(rows)],
        "missing": list(results.missing),
        "fmus": {stop.name: fmu_tools(stop.versions) for stop in results.stops},
    }
    as_json, as_markdown = directory / f"{results.name}.json", directory / f"{results.name}.md"
    claim(directory, as_json.name, as_markdown.name)
    write_json(as_json, content)
    sections: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        sections.setdefault(row.setting, []).append(row)
    write_page(
        as_markdown,
        "report/distances.md.jinja",
        results=results,
        sections={
            setting: [table.without(_HEADING) for table in tables_of(here) if table]
            for setting, here in sections.items()
        },
        missing=names(results.missing),
        notes=[*remarks_on(results.stops), *from_elsewhere(results.stops), *notes],
    )
    return as_json, as_markdown


def tables_of(rows: Sequence[Row]) -> tuple[ReportTable, ReportTable]:
    """Return the table of distributions over draws and that of all other rows, both without empty columns."""
    cells = [{name: of(row) for name, of in _COLUMNS.items()} for row in rows if row.draw is None]
    return distribution_table(distributions_of(rows)).drop_empty_columns(), ReportTable(
        cells, _FORMS
    ).drop_empty_columns()


def reader_tables(
    rows: Sequence[Row], pages: Mapping[str, str] = MappingProxyType({}), hidden: Collection[str] = ()
) -> list[ReportTable | str]:
    """Return the tables of a campaign for a reader, each after a sentence on the values that all of its rows share.

    Args:
        rows: Rows of a campaign.
        pages: Stop → address of its page, to link its row to.
        hidden: Columns to omit.
    """
    draws, single = tables_of(rows)
    addresses = [pages.get(row.stop) for row in rows if row.draw is None]
    return [*draws.parts(), *single.without(hidden).parts(addresses)]


def setting_tables(rows: Sequence[Row], pages: Mapping[str, str]) -> dict[str, list[ReportTable | str]]:
    """Return the tables of a campaign by setting, named by case, actuation, sensors and creep curve."""
    settings: dict[str, list[Row]] = {}
    for row in rows:
        name = f"actuation {row.actuation}, sensors {row.sensors}, creep curve {row.polach}"
        settings.setdefault(f"{row.case}: {name}" if row.case else name, []).append(row)
    return {name: reader_tables([replace(row, case="") for row in here], pages) for name, here in settings.items()}


def repeats_table(rows: Sequence[Row], pages: Mapping[str, str]) -> ReportTable | None:
    """Return the repeats of each stop that was repeated; None without repeats."""
    cells = [
        {
            "stop": Link(row.stop, pages[row.stop]) if row.stop in pages else row.stop,
            "distance": row.distance_m,
            "repeated": row.repeated,
            "others": row.other_repeats,
        }
        for row in rows
        if row.repeated
    ]
    return ReportTable(cells, {"distance": "{:.1f} m"}, left=("stop", "others")) if cells else None


def documentation_tables(rows: Sequence[Row]) -> dict[str, ReportTable]:
    """Return the tables of a campaign for a page of the documentation, by name.

    `draws` has the distributions over draws, `distances` a row for each other case and a column for each controller; a
    distance that depends on rounding has its range.
    """
    cases: dict[tuple[str, str], dict[str, str]] = {}
    for row in rows:
        if row.draw is None:
            distance = "no stop" if row.distance_m is None else f"{row.distance_m:.1f} m"
            distance += locked_text(row.longest_lock_s)
            change = percent(None if row.reduction_vs_sbc is None else -row.reduction_vs_sbc)
            ends = "" if row.repeats is None else f"{row.repeats[1]:.1f} – {row.repeats[2]:.1f} m"
            brackets = "; ".join(filter(None, (ends, change)))
            cells = cases.setdefault((row.label, row.polach), {"scenario": row.label, "creep curve": row.polach})
            cells[row.controller_label] = f"{distance} ({brackets})" if brackets else distance
    columns = dict.fromkeys(column for cells in cases.values() for column in cells)
    table = ReportTable(
        [dict.fromkeys(columns, "") | cells for cells in cases.values()], left=("scenario", "creep curve")
    )
    draws = distribution_table(distributions_of(rows)).drop_empty_columns()
    alike = {name for name in _HEADING if len({row.get(name) for row in draws.rows}) == 1}
    return {"draws": draws.without(alike), "distances": table}


_HEADING = ("actuation", "sensors", "creep curve")
"""Columns whose values are in the heading of a section."""

_COLUMNS: Mapping[str, Callable[[Row], Any]] = {
    "scenario": lambda row: row.label,
    "actuation": lambda row: row.actuation,
    "sensors": lambda row: row.sensors,
    "creep curve": lambda row: row.polach,
    "controller": lambda row: row.controller_label,
    "distance": lambda row: f"none: {row.outcome}" if row.distance_m is None else row.distance_m,
    "paper": lambda row: row.paper_distance_m,
    "vs SBC 10/15 %": lambda row: row.reduction_vs_sbc,
    "paper vs SBC": lambda row: row.paper_reduction,
    "vs best tuned SBC": lambda row: row.reduction_vs_tuned,
    "repeated": lambda row: row.repeated,
    "duration": lambda row: row.duration_s,
    "adhesion used": lambda row: row.utilisation,
    "greatest adhesion": lambda row: row.adhesion_peak,
    "longest lock": lambda row: row.longest_lock_s,
    "breaks": lambda row: ", ".join(SUBJECTS[clause] for clause in row.breaks),
    "valve strokes": lambda row: row.valve_strokes,
    "air": lambda row: row.air_l,
    "estimator": lambda row: row.estimator,
    "NIS": lambda row: row.nis,
    "outside ±2σ": lambda row: row.outside,
}

_FORMS: Mapping[str, Form] = {
    **dict.fromkeys(("distance", "paper"), "{:.1f} m"),
    **dict.fromkeys(("vs SBC 10/15 %", "vs best tuned SBC", "paper vs SBC"), change),
    **dict.fromkeys(("adhesion used", "outside ±2σ"), share),
    "duration": "{:.1f} s",
    "greatest adhesion": "{:.3f}",
    "longest lock": "{:.2f} s",
    "air": "{:.0f} l",
    "NIS": "{:.2g}",
}


def _row(stop: Stop, sbc: Stop | None, tuned: Stop | None, constant: Sequence[str], breaks: tuple[str, ...]) -> Row:
    scenario, metrics, distance = stop.inputs, stop.figures, stop.braking_distance
    actuation, sensors, polach = setting_of(scenario)
    return Row(
        scenario=scenario["name"],
        case=", ".join(f"{axis} {stop.variants[axis]}" for axis in constant),
        polach=polach,
        actuation=actuation,
        sensors=sensors,
        controller=controller_of(scenario),
        controller_label=label(scenario),
        estimator=_estimator(scenario),
        friction=_friction(scenario["adhesion"]),
        draw=int(stop.variants[DRAW]) if DRAW in stop.variants else None,
        reference="published" if sbc is stop else "best tuned" if tuned is stop else None,
        distance_m=distance,
        repeated=range_text(stop.conditioning, stop.digest, distance),
        repeats=_spread(stop),
        other_repeats=_other_repeats(stop),
        duration_s=metrics.duration if stop.outcome is Outcome.STANDSTILL else None,
        reduction_vs_sbc=_reduction(distance, sbc, stop),
        reduction_vs_tuned=_reduction(distance, tuned, stop),
        utilisation=finite(metrics.utilisation),
        paper_distance_m=stop.paper_distance,
        paper_reduction=None
        if sbc is None or sbc is stop or sbc.paper_distance is None or stop.paper_distance is None
        else 1 - stop.paper_distance / sbc.paper_distance,
        outcome=stop.outcome.value,
        breaks=breaks,
        adhesion_peak=finite(max(metrics.adhesion_peak)),
        longest_lock_s=finite(max(metrics.longest_lock)),
        valve_strokes=round(sum(metrics.actuations)) if actuation == VALVES else None,
        air_l=finite(1000 * metrics.air_used),
        nis=metrics.nis_ratio,
        outside=max((*(metrics.adhesion_outside or ()), *(metrics.pad_friction_outside or ())), default=None),
        stop=stop.name,
    )


def range_text(conditioning: RepeatedDistances | None, digest: str, distance: float | None) -> str:
    """Return median and range of the repeats of a stop, or `STALE` if they are the repeats of another stop.

    Args:
        digest: Digest of the scenario of the stop.
        distance: Distance of the stop [m], None without standstill.
    """
    if conditioning is None:
        return ""
    if not conditioning.belongs(digest, distance):
        return STALE
    return f"{conditioning.median:.1f} m ({conditioning.lowest:.1f} – {conditioning.highest:.1f})"


def _spread(stop: Stop) -> tuple[float, float, float] | None:
    repeats = stop.own_repeats
    if repeats is None or not repeats.spreads or not isfinite(repeats.highest):
        return None
    return repeats.median, repeats.lowest, repeats.highest


def _other_repeats(stop: Stop) -> str:
    repeats = stop.own_repeats
    if repeats is None:
        return ""
    texts = [
        f"{compiler} {'no stop' if other is None else f'{other:.1f} m'}"
        for compiler, other in repeats.compilers.items()
    ]
    texts += [f"{len(repeats.lots)} lots of sensors {repeats.lots_text}"] if repeats.lots else []
    return "; ".join(texts)


def _hidden_axes(stops: Sequence[Stop]) -> tuple[str, ...]:
    """Return the axes along which stops differ although all columns are equal; draws have a separate column."""
    alike: dict[tuple[str, ...], list[Stop]] = {}
    for stop in stops:
        scenario = stop.inputs
        columns = (scenario["name"], *setting_of(scenario), label(scenario), _estimator(scenario))
        alike.setdefault(columns, []).append(stop)
    axes = dict.fromkeys(axis for stop in stops for axis in stop.variants if axis != DRAW)
    return tuple(
        axis for axis in axes if any(len({stop.variants.get(axis) for stop in same}) > 1 for same in alike.values())
    )


def _friction(adhesion: Mapping[str, Any]) -> str:
    if adhesion["kind"] != "constant":
        return ""
    patches = sorted({value for patch in adhesion.get("patch", ()) for value in patch["mu0"]})
    rail, places = (", ".join(f"{value:g}" for value in values) for values in (adhesion["mu0"], patches))
    return f"{rail}, in patches {places}" if places else rail


def _estimator(scenario: Mapping[str, Any]) -> str:
    estimator = scenario["estimator"]
    return estimator["kind"] if estimator["kind"] == "none" else f"{estimator['model']} ({estimator['kind']})"


def _reduction(distance: float | None, reference: Stop | None, own: Stop) -> float | None:
    """Return 1 − distance over that of the reference; None if one is missing, and for the reference itself."""
    before = reference.braking_distance if reference is not None and reference is not own else None
    return None if distance is None or before is None else 1 - distance / before
