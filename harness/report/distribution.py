"""What a controller does over many draws of a rail: median, range, worst, and its change against others draw by draw.

All controllers stop on the same draws, so they are compared draw by draw: what one rail is harder than another by falls
out. A draw without a standstill counts as an endless distance, never as one less. Intervals hold 95 %: of a median from
order statistics, whatever the distribution (Conover, Practical Nonparametric Statistics, 1999, section 3.2); of a share
those of Clopper and Pearson (Biometrika 26, 1934).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from railgrip.report.row import Conditions, Row
from railgrip.report.table import Table, percent, text

CONFIDENCE = 0.95


@dataclass(frozen=True, slots=True, kw_only=True)
class Paired:
    """A controller against another on the same draws.

    Attributes:
        label: Of the other.
        draws: On which both were stopped.
        shorter: Share of the draws in which it stops shorter.
        shorter_interval: Of that share.
        change: Median of distance over that of the other, less 1, draw by draw.
        change_interval: Of that median; None where too few draws give one.
        changes: Each of them, in the order of the draws; infinite where only the other came to a standstill.
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
        draws: How many.
        stood: How many of them came to a standstill.
        distances_m: By draw; infinite without standstill.
        median_m: Of the distance; infinite if half of the draws or more have none.
        low_m: 5 % of the draws are shorter.
        high_m: 95 % are.
        worst_m: The longest.
        worst_draw: Its seed.
        longest_lock_s: Median over the draws of the longest lock of any group.
        vs_sbc: Against the published slip-based control; None without it.
        vs_tuned: Against the best tuned one.
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
    vs_sbc: Paired | None
    vs_tuned: Paired | None


def distributions_of(rows: Sequence[Row]) -> tuple[Distribution, ...]:
    """Return the distributions that the draws among the rows make, in the order of the rows."""
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
    """Return the rows of a scenario's many cases as if each case were a draw."""
    cases = {case: number for number, case in enumerate(dict.fromkeys(row.case for row in rows), start=1)}
    return [replace(row, case="", draw=cases[row.case]) for row in rows]


def distribution_table(distributions: Sequence[Distribution]) -> Table:
    """Return a row for each distribution."""
    rows = [
        {
            "scenario": one.label,
            "actuation": one.actuation,
            "sensors": one.sensors,
            "creep curve": one.polach,
            "controller": one.controller_label,
            "draws": str(one.draws) if one.stood == one.draws else f"{one.draws}, {one.draws - one.stood} without stop",
            "median": _metres(one.median_m),
            "5–95 %": f"{_metres(one.low_m, '')} – {_metres(one.high_m)}",
            "worst (draw)": f"{_metres(one.worst_m)} ({one.worst_draw})",
            "longest lock, median": one.longest_lock_s,
            **_paired_texts("SBC 10/15 %", one.vs_sbc),
            **_paired_texts("best tuned SBC", one.vs_tuned),
        }
        for one in distributions
    ]
    return Table(rows, {"longest lock, median": "{:.2f} s"})


def _paired_texts(name: str, paired: Paired | None) -> dict[str, str]:
    change = shorter = ""
    if paired is not None:
        change = percent(paired.change) or "endless"
        if paired.change_interval is not None:
            change += f" [{', '.join(percent(end) or 'endless' for end in paired.change_interval)}]"
        shorter = text(100 * paired.shorter, "{:.0f} %")
        shorter += f" [{', '.join(text(100 * end, '{:.0f}') for end in paired.shorter_interval)}]"
    return {f"change vs {name}": change, f"shorter than {name}": shorter}


def _metres(distance: float, unit: str = " m") -> str:
    return f"{distance:.1f}{unit}" if math.isfinite(distance) else "no stop"


def _distribution(rows: Sequence[Row], published: Sequence[Row] | None, tuned: Sequence[Row] | None) -> Distribution:
    first, distances = rows[0], _by_draw(rows)
    values = np.array(list(distances.values()))
    # Not interpolated: a quantile is a draw, and endless ones have their place.
    low, high = (float(np.quantile(values, share, method="inverted_cdf")) for share in (0.05, 0.95))
    worst = max(distances, key=lambda draw: distances[draw])
    locks = [row.longest_lock_s for row in rows if row.longest_lock_s is not None]
    return Distribution(
        **{field.name: getattr(first, field.name) for field in fields(Conditions)},
        draws=len(values),
        stood=int(np.isfinite(values).sum()),
        distances_m=distances,
        median_m=float(np.median(values)),
        low_m=low,
        high_m=high,
        worst_m=distances[worst],
        worst_draw=worst,
        longest_lock_s=float(np.median(locks)) if locks else None,
        vs_sbc=None if published is None or published is rows else paired(distances, published),
        vs_tuned=None if tuned is None or tuned is rows else paired(distances, tuned),
    )


def paired(distances: Mapping[int, float], other: Sequence[Row]) -> Paired | None:
    """Return how distances [m] by draw compare with those of another controller; None without a common draw."""
    # scipy.stats takes a second to load, and only campaigns with draws need it.
    from scipy import stats

    others = _by_draw(other)
    both = [draw for draw in distances if draw in others]
    if not both:
        return None
    own, reference = (np.array([side[draw] for draw in both]) for side in (distances, others))
    changes = _changes(own, reference)
    count = int(np.count_nonzero(own < reference))
    # scipy's stubs do not know what its own documentation promises here.
    share = cast("Any", stats.binomtest(count, len(both)).proportion_ci(CONFIDENCE, method="exact"))
    median = cast("Any", stats.quantile_test(changes, q=0, p=0.5)).confidence_interval(CONFIDENCE)
    interval = float(median.low), float(median.high)
    return Paired(
        label=other[0].controller_label,
        draws=len(both),
        shorter=count / len(both),
        shorter_interval=(float(share.low), float(share.high)),
        change=float(np.median(changes)),
        change_interval=None if any(map(math.isnan, interval)) else interval,
        changes=tuple(map(float, changes)),
    )


def _changes(own: NDArray[np.float64], reference: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return own over reference, less 1; none where neither came to a standstill."""
    with np.errstate(invalid="ignore"):
        return np.where(np.isinf(own) & np.isinf(reference), 0.0, own / reference - 1.0)


def _by_draw(rows: Sequence[Row]) -> dict[int, float]:
    return {row.draw: math.inf if row.distance_m is None else row.distance_m for row in rows if row.draw is not None}
