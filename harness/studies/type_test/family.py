"""Results by family of cases: by creep curve, axis of the friction, rail, cleaning, faults and train."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from railgrip.report.statistics import endless, finite, quantile, quantile_interval
from railgrip.report.table import ReportTable, share
from railgrip.studies.type_test.judge import CaseJudgement, Summary

AXES: Final = ("curve", "over", "rail", "cleaning", "passage", "number of faults", "train", "mechanics")
"""Variants of a case that make families."""

FEWEST: Final = 5
"""Minimum number of compared cases of a family in which a controller can be said to lose."""

_SAME: Final = 0.002
"""Relative difference below which distances are the same."""

Interval = tuple[float | None, float | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Family:
    """One controller in the cases of one value of one axis; ratios are as in `judge.Summary`.

    Attributes:
        axis, value: Variant of the cases and its value.
        controller: Name of the entrant.
        cases: Number of cases that it has run.
        compared: Number of those with an admissible baseline.
        stops: Share of `cases` in which the train stops.
        lost: Share of `compared` in which it is longer than the best baseline; None without a comparison.
        median, p95: Of distance over that of the best baseline; None without a comparison, or infinite.
        median_interval, p95_interval: 95 % bootstrap intervals.
        over_bound: Median of distance over that of the ideal bound; None without a bound.
    """

    axis: str
    value: str
    controller: str
    cases: int
    compared: int
    stops: float
    lost: float | None
    median: float | None
    median_interval: Interval
    p95: float | None
    p95_interval: Interval
    over_bound: float | None


def families(stops: Sequence[CaseJudgement]) -> list[Family]:
    """Return the results of each controller by axis and value, in the order of `AXES`."""
    groups: dict[tuple[str, str, str], list[CaseJudgement]] = {}
    for axis in AXES:
        for stop in sorted(stops, key=lambda stop: stop.variants.get(axis, "")):
            if axis in stop.variants:
                groups.setdefault((axis, stop.variants[axis], stop.controller), []).append(stop)
    return [_family(*key, members) for key, members in groups.items()]


def _family(axis: str, value: str, controller: str, stops: Sequence[CaseJudgement]) -> Family:
    ratios = [endless(stop.over_best) for stop in stops if stop.best_m]
    bounds = [endless(stop.over_bound) for stop in stops if stop.bound_m]
    return Family(
        axis=axis,
        value=value,
        controller=controller,
        cases=len(stops),
        compared=len(ratios),
        stops=float(np.mean([stop.distance_m is not None for stop in stops])),
        lost=float(np.mean([ratio > 1.0 + _SAME for ratio in ratios])) if ratios else None,
        median=finite(quantile(ratios, 0.5)),
        median_interval=_interval(ratios, 0.5),
        p95=finite(quantile(ratios, 0.95)),
        p95_interval=_interval(ratios, 0.95),
        over_bound=finite(quantile(bounds, 0.5)),
    )


def _interval(ratios: Sequence[float], of: float) -> Interval:
    low, high = quantile_interval(ratios, of) or (math.nan, math.nan)
    return finite(low), finite(high)


def losses(rows: Iterable[Family], board: Sequence[Summary]) -> ReportTable:
    """Return for each controller the family in which its median over the best baseline is largest.

    Of families with the same median it is the one with the larger share of cases in which the controller is longer.
    Families with fewer than `FEWEST` compared cases do not count.
    """
    by_controller: dict[str, list[Family]] = {}
    for row in rows:
        if row.compared >= FEWEST:
            by_controller.setdefault(row.controller, []).append(row)
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
        for summary in board
        if (worst := max(by_controller.get(summary.controller, ()), key=_badness, default=None))
    ]
    return ReportTable(table, {"stops": share, "longer than best": share}, ("controller", "loses where"))


def _badness(row: Family) -> tuple[float, float, float]:
    return endless(row.median), row.lost or 0.0, endless(row.p95)


def with_interval(value: float | None, interval: Interval) -> str:
    """Return a ratio with its interval in brackets; None is a train that does not stop."""
    text = "no stop" if value is None else f"{value:.3f}"
    low, high = interval
    return text if low is None else f"{text} [{low:.3f}, {'no stop' if high is None else f'{high:.3f}'}]"


def by_axis(rows: Sequence[Family], board: Sequence[Summary]) -> dict[str, ReportTable]:
    """Return a table for each axis: median and 95 % quantile of each controller in each family."""
    tables: dict[str, ReportTable] = {}
    for axis in AXES:
        cells: dict[str, dict[str, object]] = {}
        counts: Mapping[str, int] = {row.value: row.compared for row in rows if row.axis == axis}
        for row in rows:
            if row.axis == axis:
                heading = f"{row.value} ({counts[row.value]})"
                text = "" if not row.compared else f"{with_interval(row.median, (None, None))} / {_p95(row)}"
                cells.setdefault(row.controller, {"controller": row.controller})[heading] = text
        if cells:
            order = [summary.controller for summary in board if summary.controller in cells]
            columns = max(cells.values(), key=len)
            filled = [{name: cells[controller].get(name, "") for name in columns} for controller in order]
            tables[axis] = ReportTable(filled, left=("controller",))
    return tables


def _p95(row: Family) -> str:
    return with_interval(row.p95, (None, None))


def table_of_controller(rows: Iterable[Family], summary: Summary) -> ReportTable:
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
    for row in rows:
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


def table_of_families(rows: Iterable[Family]) -> ReportTable:
    """Return every family as a row, with intervals, for a CSV file."""
    plain: list[dict[str, object]] = []
    for row in rows:
        plain.append(
            {
                "axis": row.axis,
                "value": row.value,
                "controller": row.controller,
                "cases": row.cases,
                "compared": row.compared,
                "stops": row.stops,
                "longer_than_best": row.lost,
                "median": row.median,
                "median_low": row.median_interval[0],
                "median_high": row.median_interval[1],
                "p95": row.p95,
                "p95_low": row.p95_interval[0],
                "p95_high": row.p95_interval[1],
                "over_bound": row.over_bound,
            }
        )
    return ReportTable(plain)
