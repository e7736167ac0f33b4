"""Results by family of cases, and the verdict: which law is best, and on which rail.

Families are by creep curve, axis of the friction, rail, cleaning, faults and train. A law is called best only if no
other law is clearly shorter in any family.
"""

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import pandas

from railgrip.base import registry
from railgrip.base.groups import gather
from railgrip.report.frame import Frame, groups_of
from railgrip.report.statistics import endless, on_common, quantile
from railgrip.report.table import ReportTable, names, share
from railgrip.studies.type_test.stop_frames import EQUAL, STATISTICS, Interval, over_best, statistics_of
from railgrip.studies.type_test.track_case import BY_THE_CURVE, TABLE_1

AXES: Final = ("curve", "over", "rail", "cleaning", "passage", "number of faults", "train", "mechanics")
"""Variants of a case that make families."""

FEWEST: Final = 5
"""Minimum number of compared cases of a family in which a controller can be said to lose."""

COLUMNS: Final = ("axis", "value", "controller", "lost", *STATISTICS)
"""Columns of `families`; `lost` is the share of the compared cases in which a controller is longer than the best
baseline, None without a comparison."""


def by_family(stops: Frame) -> Frame:
    """Return the stops of each family, with its `axis` and `value` and both as `family`, in the order of `AXES`."""
    of_axes = [stops.assign(axis=axis, value=[variants.get(axis) for variants in stops["variants"]]) for axis in AXES]
    found = pandas.concat(of_axes, ignore_index=True).dropna(subset="value")
    return found.assign(family=[f"{axis}: {value}" for axis, value in zip(found["axis"], found["value"], strict=True)])


def families(stops: Frame) -> Frame:
    """Return a row for each controller in the cases of one value of one axis, in the order of `AXES`."""
    rows: list[dict[str, object]] = []
    for (axis,), of_axis in groups_of(by_family(stops), ("axis",)):
        for (value, controller), own in groups_of(of_axis.sort_values("value", kind="stable"), ("value", "controller")):
            ratios = over_best(own)
            lost = float((ratios > 1.0 + EQUAL).mean()) if len(ratios) else None
            about = {"axis": axis, "value": value, "controller": controller, "lost": lost}
            rows.append(about | statistics_of(own))
    return pandas.DataFrame(rows, columns=list(COLUMNS), dtype=object)


def losses(rows: Frame, board: Frame) -> ReportTable:
    """Return for each controller the family in which its median over the best baseline is largest.

    Of families with the same median it is the one with the larger share of cases in which the controller is longer.
    Families with fewer than `FEWEST` compared cases do not count.
    """
    by_controller = {
        name: list(own.itertuples()) for (name,), own in groups_of(rows[rows["compared"] >= FEWEST], ("controller",))
    }
    table = [
        {
            "controller": summary.controller,
            "loses where": f"{worst.axis}: {worst.value}",
            "cases": f"{worst.compared} of {worst.cases}",
            "stops": worst.stops,
            "longer than best": worst.lost,
            "median": with_interval(worst.median, worst.median_interval),
            "95 %": with_interval(worst.p95, worst.p95_interval),
            "median of all": with_interval(summary.median),
        }
        for summary in board.itertuples()
        if (worst := max(by_controller.get(summary.controller, ()), key=_badness, default=None))
    ]
    return ReportTable(table, {"stops": share, "longer than best": share}, ("controller", "loses where"))


def _badness(row: Any) -> tuple[float, float, float]:
    return endless(row.median), row.lost or 0.0, endless(row.p95)


def with_interval(
    value: float | None, interval: Interval = (None, None), missing: str = "no stop", form: str = "{:.3f}"
) -> str:
    """Return a ratio with its interval in brackets; None is `missing`, by default a train that does not stop."""
    text = missing if value is None else form.format(value)
    low, high = interval
    return text if low is None else f"{text} [{form.format(low)}, {'no stop' if high is None else form.format(high)}]"


def by_axis(rows: Frame, board: Frame) -> dict[str, ReportTable]:
    """Return a table for each axis: median and 95 % quantile of each controller in each family."""
    tables: dict[str, ReportTable] = {}
    for (axis,), of_axis in groups_of(rows, ("axis",)):
        counts = dict(zip(of_axis["value"], of_axis["compared"], strict=True))
        of_axis = of_axis.assign(
            column=[f"{value} ({counts[value]})" for value in of_axis["value"]],
            text=[
                f"{with_interval(row.median)} / {with_interval(row.p95)}" if row.compared else ""
                for row in of_axis.itertuples()
            ],
        )
        table = of_axis.pivot(index="controller", columns="column", values="text").fillna("")
        order = [name for name in board["controller"] if name in table.index]
        tables[axis] = ReportTable.of_frame(
            table.loc[order, of_axis["column"].unique()].reset_index(), left=("controller",)
        )
    return tables


def table_of_controller(rows: Frame, summary: Any) -> ReportTable:
    """Return the results of one controller: a row for all cases, then one for each family."""
    own = [row for row in rows.itertuples() if row.controller == summary.controller]
    table: list[dict[str, object]] = [
        {
            "family": family,
            "compared": f"{row.compared} of {row.cases}",
            "stops": row.stops,
            "median": with_interval(row.median, row.median_interval) if row.compared else "",
            "95 %": with_interval(row.p95, row.p95_interval) if row.compared else "",
            "longer than best": None if row is summary else row.lost,
            "over bound": row.over_bound,
        }
        for family, row in (("all cases", summary), *((f"{row.axis}: {row.value}", row) for row in own))
    ]
    return ReportTable(
        table, dict.fromkeys(("stops", "longer than best"), share) | {"over bound": "{:.3f}"}, ("family",)
    )


def table_of_families(rows: Frame) -> ReportTable:
    """Return every family as a row, with intervals, for a CSV file."""
    ends = {
        f"{name}_{end}": [interval[k] for interval in rows[f"{name}_interval"]]
        for name in ("median", "p95")
        for k, end in enumerate(("low", "high"))
    }
    columns = (
        "axis", "value", "controller", "cases", "compared", "stops", "longer_than_best", "median", "median_low",
        "median_high", "p95", "p95_low", "p95_high", "over_bound",
    )  # fmt: skip
    return ReportTable.of_frame(rows.rename(columns={"lost": "longer_than_best"}).assign(**ends)[list(columns)])


LIMIT: Final = 0.03
"""Relative loss against another law in the cases of a family, in the median, from which a law is beaten there."""

_LISTED: Final = 3
"""Number of laws that are listed for a kind of rail."""


def _rows_of_laws(stops: Frame) -> Frame:
    """Return the stops without those of controllers that know the true state and of full brake.

    Locked wheels may stop shortest where slip cleans the rail, but full brake is no wheel-slide protection.
    """
    return stops[~stops["controller"].isin([*registry.ANALYSES, "full_brake"])]


def _counts(family: str, cases: int) -> bool:
    return cases >= FEWEST or family == f"rail: {TABLE_1}"


def losses_of(stops: Frame) -> Frame:
    """Return the families in which a law is beaten, a row for each law and family, in the order of the axes.

    Laws are compared in the cases that both were run in.

    Columns: `law`; `family`, axis and value; `is_small`, whether the law has too few cases there for a verdict;
    `other`, the law that beats it by most; `ratio`, the median of the distance over that of the other law in the same
    case, infinite if the law does not stop; `cases`, the number of cases with both.

    Args:
        stops: Judged stops.
    """
    laws = by_family(_rows_of_laws(stops))
    laws = laws.assign(distance=laws["distance_m"].fillna(math.inf))
    rows: list[tuple[object, ...]] = []
    for (family,), here in groups_of(laws, ("family",)):
        distances = here.pivot(index="case", columns="controller", values="distance")[here["controller"].unique()]
        for law, own in distances.items():
            ratios = distances.rdiv(own, axis=0).mask(np.isinf(distances).mul(np.isinf(own), axis=0), 1.0)
            counts, is_small = ratios.count(), not _counts(family, own.count())
            is_compared = [count > 0 and (is_small or _counts(family, count)) for count in counts]
            medians = ratios.median()[is_compared].drop(law, errors="ignore")
            if (medians > 1.0 + LIMIT).any():
                other = medians.idxmax()
                rows.append((law, family, is_small, other, medians[other], counts[other]))
    columns = ["law", "family", "is_small", "other", "ratio", "cases"]
    return pandas.DataFrame(rows, columns=columns).astype({"is_small": bool})


def _by_median(stops: Frame) -> tuple[list[str], int]:
    """Return the laws by their median over the cases in which all were run, smallest first, and the number of these."""
    common = on_common(_rows_of_laws(stops).assign(run=1.0), "controller", ["case"], "run")
    ratios = over_best(common)
    medians = ratios.groupby(common["controller"], sort=False).agg(lambda own: quantile(own, 0.5))
    return medians.sort_values(kind="stable").index.tolist(), len(ratios) // max(len(medians), 1)


_COMPARED = "cases in which all laws were run and a baseline keeps the lock clause"


def verdict(stops: Frame) -> str:
    """Return whether the law with the smallest median is best, or where it loses.

    Families with too few cases are named, with the law's losses there: a law is not called best without them.

    Args:
        stops: Judged stops.
    """
    order, count = _by_median(stops)
    if not order:
        return f"There are no {_COMPARED}: no law can be called best."
    first, limit = order[0], f"{100 * LIMIT:.0f} %"
    sizes = by_family(_rows_of_laws(stops)).groupby(["controller", "family"], sort=False).size()
    families_of = gather((law, family) for (law, family), cases in sizes.items() if _counts(family, cases))
    every = {family for families in families_of.values() for family in families}
    absent = [f"*{family}*" for family in sorted(every.difference(families_of.get(first, ())))]
    losses = losses_of(stops)
    small, beaten = losses[losses["is_small"]], losses[~losses["is_small"]]
    found, too_small = _listed(beaten, first), _small_families(first, stops, small)
    if not found and not absent:
        return (
            f"{first} {'has the smallest median' if too_small else 'is the best law: its median is the smallest'} over "
            f"the {count} {_COMPARED}, and no other law is shorter by more than {limit} in any of the "
            f"{len(families_of.get(first, ()))} families that have {FEWEST} cases or are the rails of {TABLE_1}."
            f"{too_small}"
        )
    reasons = [
        *([f"loses on {found}"] if found else []),
        *([f"has too few results on {names(absent)}"] if absent else []),
    ]
    losers = set(beaten["law"])
    unbeaten = [law for law in order[1:] if every.issubset(families_of.get(law, ())) and law not in losers]
    rest = (
        f" Not beaten by more than {limit} in any family: {names(unbeaten)}."
        if unbeaten
        else f" No law with results in every family is unbeaten by {limit} in all of them."
    )
    return f"{first} is best in the median over the {count} {_COMPARED}, but {' and '.join(reasons)}.{rest}{too_small}"


def _small_families(law: str, stops: Frame, losses: Frame) -> str:
    """Return a sentence on the families of a law that are too small for a verdict; empty without any."""
    sizes = by_family(stops[stops["controller"] == law]).groupby("family", sort=False).size()
    small = {family: cases for family, cases in sizes.items() if not _counts(family, cases)}
    if not small:
        return ""
    lost = _listed(losses, law)
    return (
        f" {len(small)} families have fewer than {FEWEST} cases, too few to compare laws, so that none is called best: "
        f"{', '.join(f'*{family}* ({count})' for family, count in small.items())}. Another law is shorter by more than "
        f"{100 * LIMIT:.0f} % {f'there on {lost}' if lost else 'in none of them'}."
    )


def _listed(losses: Frame, law: str) -> str:
    return ", ".join(f"*{loss.family}* ({_text(loss)})" for loss in losses[losses["law"] == law].itertuples())


def _text(loss: Any) -> str:
    ratio = "does not stop" if math.isinf(loss.ratio) else f"{loss.ratio:.3f}"
    return f"{ratio} of {loss.other} in {loss.cases} case{'s' if loss.cases > 1 else ''}"


def rail_of(variants: Mapping[str, str]) -> str:
    """Return the kind of rail of a case: who or what cleans it."""
    if variants["rail"] == TABLE_1:
        return f"rails of {TABLE_1}"
    slip = {"none": "", "weak": "slip weakly", "strong": "slip strongly", BY_THE_CURVE: "slip, which heats the contact"}
    who = [*(["passing wheels"] if variants["passage"] != "none" else []), slip[variants["cleaning"]]]
    causes = [cause for cause in who if cause]
    return f"cleaned by {' and '.join(causes)}" if causes else "cleaned by nothing"


def recommendation(stops: Frame) -> ReportTable:
    """Return the laws with the smallest medians on each kind of rail, of those that were run in all its cases.

    Values are the median, the 95 % quantile and the maximum of the distance over that of the best baseline.
    """
    compared = _rows_of_laws(stops[stops["best_m"].notna()])
    compared = compared.assign(rail=[rail_of(variants) for variants in compared["variants"]])
    rows: list[tuple[str | int, ...]] = []
    for (kind,), of_kind in groups_of(compared, ("rail",)):
        count = of_kind["case"].nunique()
        ratios: list[tuple[float, str, str]] = []
        for (law,), own in groups_of(of_kind, ("controller",)):
            if len(own) == count:
                values = over_best(own).tolist()
                levels = [quantile(values, share) for share in (0.5, 0.95, 1.0)]
                text = " / ".join("no stop" if math.isinf(value) else f"{value:.3f}" for value in levels)
                ratios.append((levels[0], law, text))
        places = [f"{law}: {text}" for _, law, text in sorted(ratios)[:_LISTED]]
        rows.append((kind, count, len(ratios), *places, *[""] * (_LISTED - len(places))))
    rows.sort(key=lambda row: (TABLE_1 in str(row[0]), str(row[0])))
    columns = ("rail", "cases", "laws", "shortest", "second", "third")
    return ReportTable.of(columns, rows, left=columns[:1] + columns[3:])
