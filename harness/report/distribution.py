"""Distances of a controller over many draws of a rail: median, range, maximum, and change against others by draw.

`railgrip.report.statistics` defines how controllers are compared.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from railgrip.report.row import Conditions, Row
from railgrip.report.statistics import (
    endless,
    median_interval,
    order_interval,
    quantile,
    relative_change,
    share_interval,
)
from railgrip.report.table import Link, ReportTable, percent, share, text


@dataclass(frozen=True, slots=True, kw_only=True)
class PairedComparison:
    """A controller compared with another on the same draws.

    Attributes:
        label: Name of the other controller.
        draws: Number of draws in which both were run.
        shorter: Share of the draws in which this controller stops shorter.
        shorter_interval: Interval of that share.
        change: Median over the draws of the distance over that of the other controller, minus 1.
        change_interval: Interval of that median; None with too few draws.
        changes: Changes in the order of the draws; infinite if only the other controller came to a standstill.
    """

    label: str
    draws: int
    shorter: float
    shorter_interval: tuple[float, float]
    change: float
    change_interval: tuple[float, float] | None
    changes: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Distribution(Conditions):
    """One controller over the draws of one set of conditions.

    Attributes:
        draws: Number of draws.
        stood: Number of draws that ended in a standstill.
        distances_m: Distance by draw; infinite without standstill.
        median_m: Median distance; infinite if half of the draws or more have no standstill.
        low_m: 5 % quantile of the distance.
        high_m: 95 % quantile of the distance.
        worst_m: Longest distance.
        worst_draw: Seed of the draw with the longest distance.
        longest_lock_s: Median over the draws of the longest lock of any group.
        vs_sbc: Comparison with the published slip-based control; None without it.
        vs_tuned: Comparison with the best tuned slip-based control; None without it.
    """

    draws: int
    stood: int
    distances_m: Mapping[int, float]
    median_m: float
    low_m: float
    high_m: float
    worst_m: float
    worst_draw: int
    longest_lock_s: float | None
    vs_sbc: PairedComparison | None
    vs_tuned: PairedComparison | None


def distributions_of(rows: Sequence[Row]) -> tuple[Distribution, ...]:
    """Return the distributions over the draws among the rows, in the order of the rows."""
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        if row.draw is not None:
            groups.setdefault((*row.place, row.controller_label, row.estimator), []).append(row)
    references = {(here[0].place, here[0].reference): here for here in groups.values() if here[0].reference is not None}
    return tuple(
        _distribution(
            here,
            references.get((here[0].place, "published")),
            references.get((here[0].place, "best tuned")),
        )
        for here in groups.values()
    )


def over_cases(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of a scenario with many cases as if each case were a draw."""
    cases = {case: number for number, case in enumerate(dict.fromkeys(row.case for row in rows), start=1)}
    return [replace(row, case="", draw=cases[row.case]) for row in rows]


def distribution_table(distributions: Sequence[Distribution]) -> ReportTable:
    """Return a row for each distribution."""
    rows = [
        {
            **_question(distribution),
            "draws": str(distribution.draws)
            if distribution.stood == distribution.draws
            else f"{distribution.draws}, {distribution.draws - distribution.stood} without stop",
            "median": _metres(distribution.median_m),
            "5–95 %": f"{_metres(distribution.low_m, '')} – {_metres(distribution.high_m)}",
            "worst (draw)": f"{_metres(distribution.worst_m)} ({distribution.worst_draw})",
            "longest lock, median": distribution.longest_lock_s,
            **paired_texts("SBC 10/15 %", distribution.vs_sbc),
            **paired_texts("best tuned SBC", distribution.vs_tuned),
        }
        for distribution in distributions
    ]
    return ReportTable(rows, {"longest lock, median": "{:.2f} s"})


def _question(distribution: Distribution) -> dict[str, str]:
    return {
        "scenario": distribution.label,
        "actuation": distribution.actuation,
        "sensors": distribution.sensors,
        "creep curve": distribution.polach,
        "controller": distribution.controller_label,
    }


QUANTILES = (0.5, 0.95, 0.99)
"""Quantiles of the distance in tables: the median, and distances that are rarely and hardly ever exceeded."""


def quantile_table(distributions: Sequence[Distribution], permitted: float | None) -> ReportTable:
    """Return P50, P95 and P99 of each distribution with their intervals, and how often a distance [m] is exceeded.

    Draws without standstill exceed every distance. An interval requires enough draws, that of P99 nearly 400.
    """
    rows: list[dict[str, Any]] = []
    for distribution in distributions:
        values = list(distribution.distances_m.values())
        row: dict[str, Any] = {**_question(distribution), "draws": len(values)}
        for level in QUANTILES:
            interval = order_interval(values, level)
            ends = "" if interval is None else f" [{_metres(interval[0], '')}, {_metres(interval[1], '')}]"
            row[f"P{100 * level:.0f}"] = _metres(quantile(values, level)) + ends
        if permitted is not None:
            count = sum(value > permitted for value in values)
            low, high = share_interval(count, len(values))
            row[f"over {permitted:g} m"] = f"{100 * count / len(values):.2f} % [{100 * low:.2f}, {100 * high:.2f}]"
        rows.append(row)
    return ReportTable(rows, title="Quantiles of the braking distance, with intervals of 95 %")


def worst_table(rows: Sequence[Row], pages: Mapping[str, str], count: int = 10) -> ReportTable:
    """Return the longest stops of all draws, starting with those without standstill, linked to their pages."""
    drawn = [row for row in rows if row.draw is not None and row.controller != "ideal_bound"]
    cells: list[dict[str, Any]] = [
        {
            "stop": Link(row.stop, pages[row.stop]) if row.stop in pages else row.stop,
            "controller": row.controller_label,
            "seed": row.draw,
            "distance": f"none: {row.outcome}" if row.distance_m is None else row.distance_m,
            "adhesion used": row.utilisation,
            "longest lock": row.longest_lock_s,
        }
        for row in sorted(drawn, key=lambda row: -endless(row.distance_m))[:count]
    ]
    return ReportTable(cells, {"distance": "{:.1f} m", "adhesion used": share, "longest lock": "{:.2f} s"})


def change_text(paired: PairedComparison) -> str:
    """Return the median change with its interval in brackets, if there are enough draws for one."""
    median = percent(paired.change) or "endless"
    if paired.change_interval is None:
        return median
    return f"{median} [{', '.join(percent(end) or 'endless' for end in paired.change_interval)}]"


def paired_texts(name: str, paired: PairedComparison | None) -> dict[str, str]:
    """Return the columns of a table that compare with another controller or variant of this name."""
    change = shorter = ""
    if paired is not None:
        change = change_text(paired)
        shorter = text(100 * paired.shorter, "{:.0f} %")
        shorter += f" [{', '.join(text(100 * end, '{:.0f}') for end in paired.shorter_interval)}]"
    return {f"change vs {name}": change, f"shorter than {name}": shorter}


def _metres(distance: float, unit: str = " m") -> str:
    return f"{distance:.1f}{unit}" if math.isfinite(distance) else "no stop"


def _distribution(rows: Sequence[Row], published: Sequence[Row] | None, tuned: Sequence[Row] | None) -> Distribution:
    distances = by_draw(rows)
    values = list(distances.values())
    worst = max(distances, key=lambda draw: distances[draw])
    locks = [row.longest_lock_s for row in rows if row.longest_lock_s is not None]
    return Distribution(
        **{field.name: getattr(rows[0], field.name) for field in fields(Conditions)},
        draws=len(values),
        stood=sum(map(math.isfinite, values)),
        distances_m=distances,
        median_m=float(np.median(values)),
        low_m=quantile(values, 0.05),
        high_m=quantile(values, 0.95),
        worst_m=distances[worst],
        worst_draw=worst,
        longest_lock_s=float(np.median(locks)) if locks else None,
        vs_sbc=None if published is None or published is rows else compare_pairs(distances, published),
        vs_tuned=None if tuned is None or tuned is rows else compare_pairs(distances, tuned),
    )


def compare_pairs(distances: Mapping[int, float], other: Sequence[Row]) -> PairedComparison | None:
    """Return the comparison of distances [m] by draw with those of another controller; None without a common draw."""
    others = by_draw(other)
    pairs = [(distances[draw], others[draw]) for draw in distances if draw in others]
    if not pairs:
        return None
    changes = tuple(relative_change(distance, reference) for distance, reference in pairs)
    count = sum(distance < reference for distance, reference in pairs)
    return PairedComparison(
        label=other[0].controller_label,
        draws=len(pairs),
        shorter=count / len(pairs),
        shorter_interval=share_interval(count, len(pairs)),
        change=float(np.median(changes)),
        change_interval=median_interval(changes),
        changes=changes,
    )


def by_draw(rows: Sequence[Row]) -> dict[int, float]:
    """Return the distance [m] of each draw, infinite without standstill."""
    return {row.draw: endless(row.distance_m) for row in rows if row.draw is not None}
