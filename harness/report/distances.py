"""The table of braking distances: one row for each stop, as JSON for programs and as text for readers.

Stops that differ only in their draw are summarised as distributions, by `railgrip.report.distribution`.
"""

from collections.abc import Collection, Mapping, Sequence
from math import isnan
from pathlib import Path
from types import MappingProxyType
from typing import Final

from railgrip.base.files import write_json
from railgrip.base.records import claim
from railgrip.report.distribution import distribution_table, distributions_of, plain_distributions
from railgrip.report.frame import IN_TABLES, SETTING, Frame, frame_of, groups_of, plain_rows, single_stops
from railgrip.report.limits import SUBJECTS
from railgrip.report.page import write_page
from railgrip.report.reference import locked_text
from railgrip.report.results import Results, fmu_tools, from_elsewhere, remarks_on
from railgrip.report.table import Form, Link, ReportTable, change, names, share


def write_table(results: Results, directory: Path, notes: Sequence[str] = ()) -> tuple[Path, Path]:
    """Write NAME.json and NAME.md of a campaign, with notes below its tables, and return their paths."""
    frame = frame_of(results)
    content = {
        "campaign": results.name,
        "rows": plain_rows(frame),
        "distributions": plain_distributions(distributions_of(frame)),
        "missing": list(results.missing),
        "fmus": {stop.name: fmu_tools(stop.versions) for stop in results.stops},
    }
    as_json, as_markdown = directory / f"{results.name}.json", directory / f"{results.name}.md"
    claim(directory, as_json.name, as_markdown.name)
    write_json(as_json, content)
    write_page(
        as_markdown,
        "report/distances.md.jinja",
        results=results,
        sections={
            setting: [table.without(_HEADING) for table in tables_of(here) if table]
            for setting, here in groups_of(frame, SETTING)
        },
        missing=names(results.missing),
        notes=[*remarks_on(results.stops), *from_elsewhere(results.stops), *notes],
    )
    return as_json, as_markdown


def tables_of(frame: Frame) -> tuple[ReportTable, ReportTable]:
    """Return the table of distributions over draws and that of all other stops, both without empty columns."""
    draws, single = distribution_table(distributions_of(frame)), _stops_table(single_stops(frame))
    return draws.drop_empty_columns(), single.drop_empty_columns()


def reader_tables(
    frame: Frame, pages: Mapping[str, str] = MappingProxyType({}), hidden: Collection[str] = ()
) -> list[ReportTable | str]:
    """Return the tables of a campaign for a reader, each after a sentence on the values that all of its rows share.

    Args:
        frame: Stops of a campaign.
        pages: Stop → address of its page, to link its row to.
        hidden: Columns to omit.
    """
    draws, single = tables_of(frame)
    addresses = [pages.get(stop) for stop in single_stops(frame)["stop"]]
    return [*draws.parts(), *single.without(hidden).parts(addresses)]


def setting_tables(frame: Frame, pages: Mapping[str, str]) -> dict[str, list[ReportTable | str]]:
    """Return the tables of a campaign by setting, named by case, actuation, sensors and creep curve."""
    tables: dict[str, list[ReportTable | str]] = {}
    for (case, actuation, sensors, polach), here in groups_of(frame, ("case", *SETTING)):
        name = f"actuation {actuation}, sensors {sensors}, creep curve {polach}"
        tables[f"{case}: {name}" if case else name] = reader_tables(here.assign(case="", label=here["scenario"]), pages)
    return tables


def repeats_table(frame: Frame, pages: Mapping[str, str]) -> ReportTable | None:
    """Return the repeats of each stop that was repeated; None without repeats."""
    rows = [
        {
            "stop": Link(row.stop, pages[row.stop]) if row.stop in pages else row.stop,
            "distance": row.distance,
            "repeated": row.repeated,
            "others": row.other_repeats,
        }
        for row in frame[frame["repeated"] != ""].itertuples()
    ]
    return ReportTable(rows, {"distance": IN_TABLES["distance"].text}, left=("stop", "others")) if rows else None


def documentation_tables(frame: Frame) -> dict[str, ReportTable]:
    """Return the tables of a campaign for a page of the documentation, by name.

    `draws` has the distributions over draws, `distances` a row for each other case and a column for each controller; a
    distance that depends on rounding has its range.
    """
    cases: dict[tuple[str, str], dict[str, str]] = {}
    for row in single_stops(frame).itertuples():
        distance = "no stop" if isnan(row.distance) else IN_TABLES["distance"].text(row.distance)
        distance += locked_text(row.longest_lock)
        ends = "" if row.repeats is None else f"{row.repeats[1]:.1f} – {row.repeats[2]:.1f} m"
        brackets = "; ".join(filter(None, (ends, change(row.reduction_vs_sbc))))
        cells = cases.setdefault((row.label, row.polach), {"scenario": row.label, "creep curve": row.polach})
        cells[row.controller_label] = f"{distance} ({brackets})" if brackets else distance
    columns = dict.fromkeys(column for cells in cases.values() for column in cells)
    table = ReportTable(
        [dict.fromkeys(columns, "") | cells for cells in cases.values()], left=("scenario", "creep curve")
    )
    draws = distribution_table(distributions_of(frame)).drop_empty_columns()
    alike = {name for name in _HEADING if len({row.get(name) for row in draws.rows}) == 1}
    return {"draws": draws.without(alike), "distances": table}


_HEADING = ("actuation", "sensors", "creep curve")
"""Columns whose values are in the heading of a section."""

_COLUMNS: Final = (
    "label", *SETTING, "controller_label", "distance", "paper_distance", "reduction_vs_sbc", "paper_reduction",
    "reduction_vs_tuned", "repeated", "duration", "utilisation", "adhesion_peak", "longest_lock", "breaks",
    "actuations", "air_used", "estimator", "nis_ratio", "outside",
)  # fmt: skip
"""Columns of the table of stops in their order; those of further figures follow."""

_HEADINGS: Final = {
    "label": "scenario", "polach": "creep curve", "controller_label": "controller", "paper_distance": "paper",
    "reduction_vs_sbc": "vs SBC 10/15 %", "paper_reduction": "paper vs SBC", "reduction_vs_tuned": "vs best tuned SBC",
    "outside": "outside ±2σ",
} | {name: figure.column for name, figure in IN_TABLES.items()}  # fmt: skip

_FORMS: Final[Mapping[str, Form]] = {figure.column: figure.text for figure in IN_TABLES.values()} | {
    "paper": IN_TABLES["distance"].text,
    **dict.fromkeys(("vs SBC 10/15 %", "vs best tuned SBC", "paper vs SBC"), change),
    "outside ±2σ": share,
}


def _stops_table(frame: Frame) -> ReportTable:
    """Return a row for each stop."""
    shown = frame.assign(
        distance=frame["distance"].astype(object).where(frame["distance"].notna(), "none: " + frame["outcome"]),
        breaks=[", ".join(SUBJECTS[clause] for clause in breaks) for breaks in frame["breaks"]],
    )
    columns = dict.fromkeys((*_COLUMNS, *IN_TABLES))
    return ReportTable.of_frame(shown[list(columns)].rename(columns=_HEADINGS), _FORMS)
