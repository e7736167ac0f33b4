"""Results by family of cases: by creep curve, axis of the friction, rail, cleaning, faults and train."""

from typing import Any, Final

import pandas

from railgrip.report.frame import Frame, groups_of
from railgrip.report.statistics import endless
from railgrip.report.table import ReportTable, share
from railgrip.studies.type_test.judge import EQUAL, over_best, statistics_of

AXES: Final = ("curve", "over", "rail", "cleaning", "passage", "number of faults", "train", "mechanics")
"""Variants of a case that make families."""

FEWEST: Final = 5
"""Minimum number of compared cases of a family in which a controller can be said to lose."""

Interval = tuple[float | None, float | None]


def families(stops: Frame) -> Frame:
    """Return a row for each controller in the cases of one value of one axis, in the order of `AXES`.

    Columns: `axis`, `value` and `controller`; those of `judge.statistics_of`; and `lost`, the share of the compared
    cases in which it is longer than the best baseline, None without a comparison.
    """
    rows: list[dict[str, Any]] = []
    for axis in AXES:
        of_axis = stops.assign(value=[variants.get(axis) for variants in stops["variants"]])
        of_axis = of_axis.dropna(subset="value").sort_values("value", kind="stable")
        for (value, controller), own in groups_of(of_axis, ("value", "controller")):
            ratios = over_best(own)
            lost = float((ratios > 1.0 + EQUAL).mean()) if len(ratios) else None
            rows.append({"axis": axis, "value": value, "controller": controller, "lost": lost} | statistics_of(own))
    return pandas.DataFrame(rows, dtype=object)


def losses(rows: Frame, board: Frame) -> ReportTable:
    """Return for each controller the family in which its median over the best baseline is largest.

    Of families with the same median it is the one with the larger share of cases in which the controller is longer.
    Families with fewer than `FEWEST` compared cases do not count.
    """
    by_controller = {
        name: list(own.itertuples())
        for (name,), own in groups_of(rows[rows["compared"] >= FEWEST] if len(rows) else rows, ("controller",))
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
            "median of all": with_interval(summary.median, (None, None)),
        }
        for summary in board.itertuples()
        if (worst := max(by_controller.get(summary.controller, ()), key=_badness, default=None))
    ]
    return ReportTable(table, {"stops": share, "longer than best": share}, ("controller", "loses where"))


def _badness(row: Any) -> tuple[float, float, float]:
    return endless(row.median), row.lost or 0.0, endless(row.p95)


def with_interval(value: float | None, interval: Interval) -> str:
    """Return a ratio with its interval in brackets; None is a train that does not stop."""
    text = "no stop" if value is None else f"{value:.3f}"
    low, high = interval
    return text if low is None else f"{text} [{low:.3f}, {'no stop' if high is None else f'{high:.3f}'}]"


def by_axis(rows: Frame, board: Frame) -> dict[str, ReportTable]:
    """Return a table for each axis: median and 95 % quantile of each controller in each family."""
    tables: dict[str, ReportTable] = {}
    for (axis,), of_axis in groups_of(rows, ("axis",)):
        cells: dict[str, dict[str, object]] = {}
        counts = dict(zip(of_axis["value"], of_axis["compared"], strict=True))
        for row in of_axis.itertuples():
            unknown = (None, None)
            text = f"{with_interval(row.median, unknown)} / {with_interval(row.p95, unknown)}" if row.compared else ""
            of_controller = cells.setdefault(row.controller, {"controller": row.controller})
            of_controller[f"{row.value} ({counts[row.value]})"] = text
        order = [name for name in board["controller"] if name in cells]
        columns = max(cells.values(), key=len)
        filled = [{name: cells[controller].get(name, "") for name in columns} for controller in order]
        tables[axis] = ReportTable(filled, left=("controller",))
    return tables


def table_of_controller(rows: Frame, summary: Any) -> ReportTable:
    """Return the results of one controller: a row for all cases, then one for each family."""
    table: list[dict[str, object]] = [
        {
            "family": "all cases",
            "compared": f"{summary.compared} of {summary.cases}",
            "stops": summary.stops,
            "median": with_interval(summary.median, summary.median_interval),
            "95 %": with_interval(summary.p95, summary.p95_interval),
            "longer than best": "",
            "over bound": summary.over_bound,
        }
    ]
    for row in rows.itertuples():
        if row.controller == summary.controller:
            table.append(
                {
                    "family": f"{row.axis}: {row.value}",
                    "compared": f"{row.compared} of {row.cases}",
                    "stops": row.stops,
                    "median": with_interval(row.median, row.median_interval) if row.compared else "",
                    "95 %": with_interval(row.p95, row.p95_interval) if row.compared else "",
                    "longer than best": "" if row.lost is None else share(row.lost),
                    "over bound": row.over_bound,
                }
            )
    return ReportTable(table, {"stops": share, "over bound": "{:.3f}"}, ("family",))


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
