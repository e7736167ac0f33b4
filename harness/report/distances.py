"""The results of a campaign for readers: a summary, tables of stops and draws, and the overview of published stops."""

from collections.abc import Collection, Mapping, Sequence
from math import isinf, isnan
from pathlib import Path
from statistics import median
from types import MappingProxyType
from typing import Any, Final, Literal

import pandas

from railgrip.base.files import write_json, write_text
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
    VALVES,
    Frame,
    StatedDistance,
    frame_of,
    groups_of,
    plain_rows,
    short_names,
    single_stops,
)
from railgrip.report.limits import SUBJECTS
from railgrip.report.page import render
from railgrip.report.reference import locked_text
from railgrip.report.results import Results, fmu_tools, from_elsewhere, remarks_on
from railgrip.report.statistics import on_common, rank
from railgrip.report.table import Form, Link, ReportTable, change, names, percent, percent_or_endless, share


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
    text = render(
        "report/distances.md.jinja",
        results=results,
        sections={
            setting: [table.without(_HEADING) for table in tables_of(here) if table]
            for setting, here in groups_of(frame, SETTING)
        },
        repeats=repeats_table(frame, {}),
        missing=names(results.missing),
        notes=[*remarks_on(results.stops), *from_elsewhere(results.stops), *notes],
    )
    write_text(as_markdown, text)
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
    above = [_ABOVE_THE_BOUND] if (single_stops(frame)["utilisation"] > 1).any() else []
    return [*draws.parts(), *single.without(hidden).parts(addresses), *above]


_ABOVE_THE_BOUND: Final = (
    "Adhesion used is above 100 % where wheelsets regain speed after a slide: the contact then brakes the train by "
    "more than the brakes draw, and the highest force of an instant, to which adhesion used refers, leaves this out. "
    "The stop of the ideal bound includes it."
)


def setting_tables(frame: Frame, pages: Mapping[str, str]) -> dict[str, list[ReportTable | str]]:
    """Return the tables of a campaign by setting, named by case, actuation, sensors and creep curve."""
    tables: dict[str, list[ReportTable | str]] = {}
    for (case, actuation, sensors, polach), here in groups_of(frame, ("case", *SETTING)):
        name = f"actuation {actuation}, sensors {sensors}, creep curve {polach}"
        tables[f"{case}: {name}" if case else name] = reader_tables(here.assign(case="", label=here["scenario"]), pages)
    return tables


def repeats_table(frame: Frame, pages: Mapping[str, str]) -> ReportTable | None:
    """Return the stated distance, that of the run and the repeats of each stop that was repeated; None without any."""
    rows = [
        {
            "stop": Link(row.stop, pages[row.stop]) if row.stop in pages else row.stop,
            "stated": row.stated.median,
            "this run": row.distance,
            "repeated": row.repeated,
            "others": row.other_repeats,
        }
        for row in frame[frame["repeated"] != ""].itertuples()
    ]
    forms: dict[str, Form] = dict.fromkeys(("stated", "this run"), IN_TABLES["distance"].text)
    return ReportTable(rows, forms, left=("stop", "others")) if rows else None


def documentation_tables(frame: Frame) -> dict[str, ReportTable]:
    """Return the tables of a campaign for a page of the documentation, by name.

    `draws` has the distributions over draws, `distances` a row for each other case and a column for each controller; of
    repeated stops it has median, range and longest lock.
    """
    cases: dict[tuple[str, str], dict[str, str]] = {}
    for row in single_stops(frame).itertuples():
        stated = row.stated
        distance = "no stop" if isinf(stated.median) else IN_TABLES["distance"].text(stated.median)
        distance += locked_text(stated.lock)
        ends = "" if stated.ends is None else "{:.1f} – {:.1f} m".format(*stated.ends)
        brackets = "; ".join(filter(None, (ends, percent(row.stated_vs_sbc))))
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
    "reduction_vs_tuned", "duration", "utilisation", "adhesion_peak", "longest_lock", "flat_length", "breaks",
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


_OWN: Final = ("adhesion_literal", "adhesion_based", "slope_seeking", "ideal_bound")
"""Controllers next to those with a published distance: the laws of the published kind, and the bound."""

_LOCKED: Final = 2.0
"""Lock of a wheelset above which it is given next to a range [s]."""

_CASES: Final = 4
"""Maximum number of columns."""

FIRST: Final = "braking distance"
"""Heading of the column with the controllers."""

Origin = Literal["published", "ideal", "service"]

ORIGINS: Final[Mapping[Origin, str]] = {"published": "published", "ideal": "ideal", "service": "in service"}


def meaning_of(overview: Frame) -> str:
    """Return what the columns and rows of an overview mean."""
    lots = {len(stated.distances) for stated in overview["stated"] if stated.are_lots}
    service = f", there as medians over {max(lots)} lots of sensors" if lots else ""
    return (
        "SBC: slip-based control; ABC: adhesion-based control. Percentages are changes against SBC with 10 and 15 % of "
        "the same origin. Ideal: exact sensors, and brake cylinders that follow the demand; in service: valves, and "
        f"sensors with errors{service}. Distances that depend on rounding are the median of repeated stops, and a lock "
        "next to their range is the longest of a wheelset in them."
    )


def caveats_of(overview: Frame, published: Sequence[str]) -> list[str]:
    """Return sentences that a reader needs before the distances of an overview.

    Args:
        published: Sources of the published distances.
    """
    is_sbc = overview["reference"] == "published"
    sentences = [f"Published distances: {'; '.join(published)}."] if published else []
    if (overview["fitted"] & is_sbc & (overview["origin"] == "ideal")).any():
        sentences.append(
            "Slip-based control (SBC) with ideal equipment stops as published because the friction of these scenarios "
            "was fitted to its distances; all other rows are predictions."
        )
    if not (overview["reference"] == "best tuned").any():
        sentences.append("No SBC with tuned thresholds was run: what a law gains over one is not known here.")
    return sentences


def overview_of(frame: Frame) -> Frame | None:
    """Return published distances next to those of a campaign: a row for each controller, origin and case.

    None if the campaign has no published distances, or too many cases for a screen. Stops with valves are those of the
    same scenarios and creep curves, if they are of one kind of sensors and case.

    Columns, besides those of the campaign:

    - `origin`: one of `ORIGINS`, in this order for each controller
    - `place`: name of the case, with all cases as categories
    - `distance`: stated distance [m], infinite without standstill
    - `change`: change against slip-based control of the same origin; NaN for that itself
    """
    single = single_stops(frame)
    places = frame.loc[frame["paper_distance"].notna(), list(PLACE)].drop_duplicates()
    ideal = single.merge(places)
    if ideal.empty:
        return None
    _, names = short_names(ideal)
    ideal["place"] = [names[label].replace("\n", ", ") for label in ideal["label"]]
    cases = ideal["place"].unique()
    if len(cases) < len(places) or len(cases) > _CASES:
        return None
    keys = ["scenario", "polach"]
    served = single[single["actuation"] == VALVES].merge(ideal[[*keys, "place"]].drop_duplicates())
    if served.duplicated([*keys, "controller_label"]).any():
        served = served.head(0)
    here: Frame = pandas.concat([ideal.assign(origin="ideal"), served.assign(origin="service")], ignore_index=True)
    here = here.drop_duplicates(["controller_label", "origin", "place"], keep="last")
    here["distance"], here["change"] = [one.median for one in here["stated"]], here["stated_vs_sbc"]
    with_paper = here.groupby("controller_label")["paper_distance"].transform("count") > 0
    is_tuned = here["controller_label"].isin(here.loc[here["reference"] == "best tuned", "controller_label"])
    here = here[with_paper | is_tuned | here["controller"].isin(_OWN)]
    known = here[here["paper_distance"].notna()]
    published = known.assign(
        origin="published", change=-known["paper_reduction"], distance=known["paper_distance"],
        stated=[StatedDistance((metres,)) for metres in known["paper_distance"]],
    )  # fmt: skip
    lines: Frame = pandas.concat([published, here], ignore_index=True)
    lines["place"] = pandas.Categorical(lines["place"], cases)
    lines["controller_label"] = pandas.Categorical(lines["controller_label"], single["controller_label"].unique())
    lines["origin"] = pandas.Categorical(lines["origin"], list(ORIGINS))
    return lines.sort_values(["controller_label", "origin"], kind="stable", ignore_index=True)


def overview_table(overview: Frame) -> ReportTable:
    """Return a row for each controller and origin, and one for the ranges of distances that depend on rounding."""
    rows: list[dict[str, str]] = []
    for (controller,), of_controller in groups_of(overview, ("controller_label",)):
        for number, ((origin,), own) in enumerate(groups_of(of_controller, ("origin",))):
            name = f"– {ORIGINS[origin]}" if number else f"{controller}, {ORIGINS[origin]}"
            texts = {row.place: _distance_text(row) for row in own.itertuples()}
            rows.append({FIRST: name, **dict.fromkeys(overview["place"].cat.categories, "")} | texts)
            ranges = {row.place: _range_text(row.stated) for row in own.itertuples()}
            if any(ranges.values()):
                rows.append({**dict.fromkeys(rows[-1], ""), FIRST: "– – range [m], longest lock"} | ranges)
    return ReportTable(rows, left=(FIRST,))


def _distance_text(row: Any) -> str:
    return "no stop" if isinf(row.distance) else f"{row.distance:.1f} m {percent(row.change)}".rstrip()


def _range_text(stated: StatedDistance) -> str:
    if stated.ends is None or stated.are_lots:
        return ""
    lock = f", {stated.lock:.0f} s" if stated.lock > _LOCKED else ""
    return "{:.1f}–{:.1f}".format(*stated.ends) + lock


_GROUPS: Final = 3
"""Maximum number of conditions in a summary."""


def headline(frame: Frame, reference: ReferenceVariant | None = None, changes: Sequence[Change] = ()) -> str:
    """Return a summary with the controller, or variant, that shortens the distance most without breaking a clause.

    Controllers are compared separately for each equipment, variants for each set of conditions, on the stops that all
    of them have.

    Args:
        frame: Stops of a campaign.
        reference: The variant that others are compared with; without it, controllers are compared with the published
            slip-based control.
        changes: Changes of the other variants.
    """
    count = f"{frame['distance'].count()} of {len(frame)} stops come to a standstill."
    gap = _gap(int(_without_reference(frame).sum())) if reference is None else ""
    groups = _controllers(frame) if reference is None else _variants(changes)
    if not groups:
        return f"{gap}{count}"
    against = (
        "slip-based control (SBC) with the published, untuned thresholds of 10 and 15 %"
        if reference is None
        else f"{reference.axis} {reference.variant}"
    )
    parts = [f"{where if len(groups) > 1 else ''}{sentences}" for where, sentences in groups.items()]
    more = f" Tables have {len(groups) - _GROUPS} further conditions." if len(groups) > _GROUPS else ""
    joined = " ".join(f"{part[0].upper()}{part[1:]}" if number else part for number, part in enumerate(parts[:_GROUPS]))
    return f"Against {against}, {joined}{more} {gap}{count}"


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


def _controllers(frame: Frame) -> dict[str, str]:
    """Return equipment as the start of a clause → sentences on the controllers with a change against published SBC."""
    compared = frame[(frame["controller"] != "ideal_bound") & frame["stated_vs_sbc"].notna()]
    several = compared.groupby("controller_label")["estimator"].transform("nunique") > 1
    labels = compared["controller_label"].astype(str)
    compared = compared.assign(entrant=labels.where(~several, labels + ", estimator " + compared["estimator"]))
    return {
        f"{equipment_text(*equipment)}, ": _best_of(own, [*PLACE, "draw"], "stated_vs_sbc", "stops", "controllers")
        for equipment, own in groups_of(compared, ("actuation", "sensors"))
    }


def equipment_text(actuation: str, sensors: str) -> str:
    """Return the name of actuation and sensors in a sentence."""
    known = {("ideal", "ideal"): "with ideal equipment", (VALVES, "service"): "in service"}
    return known.get((actuation, sensors), f"with actuation {actuation} and sensors {sensors}")


def _variants(changes: Sequence[Change]) -> dict[str, str]:
    """Return conditions as the start of a clause → sentences on the variants other than the reference."""
    differ = {pair for change in changes for pair in change.conditions.items()}
    differ -= {pair for pair in differ if all(pair in change.conditions.items() for change in changes)}
    groups: dict[str, list[Frame]] = {}
    for one in changes:
        if one.stops["controller"].iloc[0] != "ideal_bound":
            under = ", ".join(" ".join(pair) for pair in one.conditions.items() if pair in differ)
            own = one.stops.assign(entrant=one.variant, change=one.stops["draw"].map(one.by_case))
            groups.setdefault(f"with {under}, ", []).append(own)
    return {
        where: _best_of(pandas.concat(own), ["draw"], "change", "pairs", "variants") for where, own in groups.items()
    }


def _best_of(frame: Frame, case: Sequence[str], value: str, of: str, kinds: str) -> str:
    """Return sentences on the first entrant that keeps all clauses, on a shorter one, and on what is not compared.

    Entrants are ranked by a change on the cases that all of them have; clauses are those of all their stops.
    """
    common = on_common(frame, "entrant", case, value)
    if common.empty:
        return f"{names(list(frame['entrant'].unique()))} have no stop in common."
    ranked = rank(common, "entrant", case, value)
    texts = {name: _change_text(own, value, of) for (name,), own in groups_of(common, ("entrant",))}
    breaks = {name: _breaks(own) for (name,), own in groups_of(frame, ("entrant",))}
    allowed = [name for name in ranked.index if not breaks[name]]
    shortest, best = ranked.index[0], next(iter(allowed), None)
    count, sentences = len(ranked), list[str]()
    if best is None:
        none = f"none of the {count} {kinds} keeps all clauses: " if count > 1 else ""
        sentences.append(f"{none}{shortest} breaks {breaks[shortest]}.")
        sentences.append(f"It changes the distance by {texts[shortest]} and is not recommended.")
    else:
        others = ""
        if len(allowed) == 1 < count:
            others = f"; of {count} {kinds} it is the only one that keeps all clauses"
        elif len(allowed) > 1 and ranked["median"][best] < 0:
            others = f", the largest reduction of the {len(allowed)} of {count} {kinds} that keep all clauses"
        sentences.append(f"{best} changes the distance by {texts[best]}{others}.")
        if shortest != best:
            shorter = percent(ranked["median"][shortest])
            sentences.append(f"{shortest} changes it by {shorter}, but breaks {breaks[shortest]}.")
    sentences += [
        f"{one.Index} did not come to a standstill in {one.failed} of {one.cases}."
        for one in ranked.itertuples()
        if one.failed
    ]
    left = frame[value].notna().sum() - len(common)
    return " ".join([*sentences, *([f"{left} {of} that not all of them have are not compared."] if left else [])])


def _change_text(own: Frame, value: str, of: str) -> str:
    """Return the median change with its interval over pairs, or with its range, also against the best tuned SBC."""
    values = own[value].tolist()
    if of == "pairs":
        return f"{change_text(values)} in the median of {len(values)} pairs"
    if len(values) == 1:
        return f"{percent_or_endless(values[0])} in one stop{_against_tuned(own)}"
    ends = " to ".join(percent_or_endless(choose(values)) for choose in (min, max))
    middle = percent_or_endless(median(values))
    return f"{middle} in the median of {len(values)} stops, from {ends}{_against_tuned(own)}"


def _against_tuned(own: Frame) -> str:
    tuned = own["stated_vs_tuned"].tolist()
    if any(isnan(change) for change in tuned):
        return ""
    ends = dict.fromkeys(percent_or_endless(choose(tuned)) for choose in (min, max))
    return f" (against the best tuned SBC by {' to '.join(ends)})"


def _breaks(stops: Frame) -> str:
    """Return the clauses that an entrant breaks, with the number of its stops; empty without any."""
    broken = stops["breaks"].explode().dropna()
    return ", ".join(
        f"the limit on {SUBJECTS[clause]} in {(broken == clause).sum()} of {len(stops)} stops"
        for clause in broken.unique()
    )
