"""The results of a campaign for readers: a summary, tables of stops and draws, and the overview of published stops."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import isnan, nan
from pathlib import Path
from types import MappingProxyType
from typing import Final

import pandas

from railgrip.base.files import write_json
from railgrip.base.records import claim
from railgrip.report.distribution import (
    Change,
    ReferenceVariant,
    change_text,
    distribution_table,
    distributions_of,
    plain_distributions,
)
from railgrip.report.frame import (
    IN_TABLES,
    PLACE,
    SETTING,
    Frame,
    frame_of,
    groups_of,
    plain_rows,
    short_names,
    single_stops,
)
from railgrip.report.limits import SUBJECTS
from railgrip.report.page import write_page
from railgrip.report.reference import locked_text
from railgrip.report.results import Results, fmu_tools, from_elsewhere, remarks_on
from railgrip.report.statistics import endless
from railgrip.report.table import Form, Link, ReportTable, change, names, percent, share, text


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
    "reduction_vs_tuned", "repeated", "duration", "utilisation", "adhesion_peak", "longest_lock", "flat_length",
    "breaks", "actuations", "air_used", "estimator", "nis_ratio", "outside",
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


_OWN: Final = ("adhesion_literal", "adhesion_based", "ideal_bound")
"""Controllers next to those with a published distance: the laws of the published kind, and the bound."""

_LOCKED: Final = 2.0
"""Lock of a wheelset above which it is given next to the distances of a controller [s]."""

_CASES: Final = 4
"""Maximum number of columns."""

FIRST: Final = "braking distance"
"""Heading of the column with the controllers."""


OVERVIEW_MEANING: Final = (
    "published and simulated braking distances, with the change against slip-based control (SBC) of the same origin; "
    "medians where the distance of repeated stops depends on rounding."
)


def overview_of(frame: Frame) -> Frame | None:
    """Return published distances next to those of a campaign: a row for each controller, origin and case.

    None if the campaign has no published distances, or too many cases for a screen. The published distances of a
    controller are before its own.

    Columns, besides those of the campaign:

    - `line`: name of the controller, with the origin of the distances; `is_published`: whether they are published
    - `place`: name of the case, with all cases as categories
    - `distance`: distance [m], the median over repeats that depend on rounding; NaN without standstill
    - `change`: change against slip-based control of the same origin; NaN for that itself
    - `ends`: lowest and highest distance of repeats [m]; None if all repeats agree or are published
    - `lock`: longest lock of a wheelset [s]; NaN if none of the line is long
    """
    here = single_stops(frame).merge(frame.loc[frame["paper_distance"].notna(), list(PLACE)].drop_duplicates())
    if here.empty:
        return None
    _, names = short_names(here)
    here["place"] = [names[label].replace("\n", ", ") for label in here["label"]]
    cases = here["place"].unique()
    if len(cases) < len(here[list(PLACE)].drop_duplicates()) or len(cases) > _CASES:
        return None
    here["distance"] = [row.distance if row.repeats is None else row.repeats[0] for row in here.itertuples()]
    here["ends"] = [None if repeats is None else repeats[1:] for repeats in here["repeats"]]
    sbc = here[here["reference"] == "published"].drop_duplicates("place", keep="last").set_index("place")["distance"]
    here["change"] = (here["distance"] / here["place"].map(sbc) - 1).where(here["reference"] != "published")
    here["place"] = pandas.Categorical(here["place"], cases)
    here = here.drop_duplicates(["controller_label", "place"], keep="last")
    of_law, label = here.groupby("controller_label"), here["controller_label"]
    is_compared = of_law["paper_distance"].transform("count") > 0
    own = here.assign(
        line=label.where(~is_compared, label + ", simulated"),
        is_published=False,
        lock=here["longest_lock"].where(of_law["longest_lock"].transform("max") > _LOCKED),
    )[is_compared | here["controller"].isin(_OWN)]
    known = own[own["paper_distance"].notna()]
    published = known.assign(
        line=known["controller_label"] + ", published",
        is_published=True,
        distance=known["paper_distance"],
        change=-known["paper_reduction"],
        ends=None,
        lock=nan,
    )
    order = {name: number for number, name in enumerate(label.unique())}
    lines = pandas.concat([published, own])
    return lines.sort_values("controller_label", key=lambda names: names.map(order), kind="stable")


def overview_table(overview: Frame) -> ReportTable:
    """Return a row for each controller, and rows for ranges and locks where they matter."""
    metres = ["no stop" if isnan(distance) else f"{distance:.1f} m" for distance in overview["distance"]]
    shown = overview.assign(
        text=[f"{each} {percent(change)}".rstrip() for each, change in zip(metres, overview["change"], strict=True)],
        range=["" if ends is None else f"{ends[0]:.1f} – {ends[1]:.1f} m" for ends in overview["ends"]],
        locked=[text(lock, "{:.1f} s") for lock in overview["lock"]],
    )
    rows = [
        {FIRST: name, **dict.fromkeys(overview["place"].cat.categories, "")}
        | dict(zip(own["place"], own[column], strict=True))
        for line, own in shown.groupby("line", sort=False)
        for name, column in (
            (line, "text"),
            ("– range of repeated stops", "range"),
            ("– longest lock of a wheelset", "locked"),
        )
        if any(own[column])
    ]
    return ReportTable(rows, left=(FIRST,))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Contender:
    """A controller, or a variant under some conditions.

    Attributes:
        name: Name for the sentence.
        change: Median of its distance over that of the reference, minus 1.
        text: The change with its range or interval, and the number of stops.
        stops: Its stops.
        incomparable: Number of them without a change, because the reference does not come to a standstill.
    """

    name: str
    change: float
    text: str
    stops: Frame
    incomparable: int = 0

    @property
    def violations(self) -> dict[str, int]:
        clauses = self.stops["breaks"].explode().dropna()
        return {clause: int((clauses == clause).sum()) for clause in clauses.unique()}


def headline(frame: Frame, reference: ReferenceVariant | None = None, changes: Sequence[Change] = ()) -> str:
    """Return a summary with the controller, or variant, that shortens the distance most without breaking a clause.

    Args:
        frame: Stops of a campaign.
        reference: The variant that others are compared with; without it, controllers are compared with the published
            slip-based control.
        changes: Changes of the other variants.
    """
    count = f"{frame['distance'].count()} of {len(frame)} stops come to a standstill."
    candidates = _controllers(frame) if reference is None else _variants(changes)
    if not candidates:
        return f"{_gap(int(_without_reference(frame).sum()))}{count}"
    against = "slip-based control with 10 and 15 %" if reference is None else f"{reference.axis} {reference.variant}"
    kinds = "controllers" if reference is None else "variants"
    shortest = min(candidates, key=lambda candidate: candidate.change)
    allowed = [candidate for candidate in candidates if not candidate.violations]
    if not allowed:
        none = f"none of the {len(candidates)} {kinds} keeps all clauses" if len(candidates) > 1 else ""
        breaks = f"{shortest.name} breaks {_breaks(shortest)}"
        what = f"{none}: {breaks}" if none else breaks
        what = f"Against {against}, {what}. It changes the distance by {shortest.text} and is not recommended. "
        return f"{what}{_gap(shortest.incomparable)}{count}"
    best = min(allowed, key=lambda candidate: candidate.change)
    others = ""
    if len(allowed) == 1 < len(candidates):
        others = f"; of {len(candidates)} {kinds} it is the only one that keeps all clauses"
    elif len(allowed) > 1 and best.change < 0:
        others = f", the largest reduction of the {len(allowed)} of {len(candidates)} {kinds} that keep all clauses"
    more = (
        f" {shortest.name} changes it by {percent(shortest.change)}, but breaks {_breaks(shortest)}."
        if shortest is not best
        else ""
    )
    what = f"Against {against}, {best.name} changes the distance by {best.text}{others}.{more} "
    return f"{what}{_gap(best.incomparable)}{count}"


def _gap(count: int) -> str:
    """Return a sentence on stops that cannot be compared; empty for none."""
    if not count:
        return ""
    whose = "1 stop has" if count == 1 else f"{count} stops have"
    return f"{whose} no change, because slip-based control does not come to a standstill there. "


def _without_reference(frame: Frame) -> pandas.Series:
    """Return whether the slip-based control that a stop is compared with does not come to a standstill."""
    keys = pandas.Series(list(frame[[*PLACE, "draw"]].itertuples(index=False, name=None)), frame.index, dtype=object)
    failed = keys[(frame["reference"] == "published") & frame["distance"].isna()]
    return keys.isin(set(failed)) & (frame["reference"] != "published") & (frame["controller"] != "ideal_bound")


def _controllers(frame: Frame) -> list[_Contender]:
    compared, without = frame[frame["controller"] != "ideal_bound"], _without_reference(frame)
    candidates: list[_Contender] = []
    for name, own in compared.groupby("controller_label", sort=False):
        shares = own["reduction_vs_sbc"].dropna()
        if len(shares):
            median, smallest, largest = (
                change(share) or "endless" for share in (shares.median(), shares.max(), shares.min())
            )
            text = f"{median} in the median of {len(shares)} stops, from {smallest} to {largest}"
            text = text if len(shares) > 1 else f"{median} in one stop"
            gaps = int(without[own.index].sum())
            candidates.append(
                _Contender(name=str(name), change=-shares.median(), text=text, stops=own, incomparable=gaps)
            )
    return candidates


def _variants(changes: Sequence[Change]) -> list[_Contender]:
    """Return the variants other than the reference; several conditions of one variant are several candidates."""
    differ = {pair for change in changes for pair in change.conditions.items()}
    differ -= {pair for pair in differ if all(pair in change.conditions.items() for change in changes)}

    def name(change: Change) -> str:
        under = ", ".join(" ".join(pair) for pair in change.conditions.items() if pair in differ)
        return f"{change.variant} (with {under})" if under else change.variant

    return [
        _Contender(
            name=name(change),
            change=endless(change.paired.change),
            text=f"{change_text(change.paired)} in the median of {change.paired.draws} pairs",
            stops=change.stops,
        )
        for change in changes
        if change.stops["controller"].iloc[0] != "ideal_bound"
    ]


def _breaks(candidate: _Contender) -> str:
    count = len(candidate.stops)
    return ", ".join(
        f"the limit on {SUBJECTS[clause]} in {broken} of {count} stops"
        for clause, broken in candidate.violations.items()
    )
