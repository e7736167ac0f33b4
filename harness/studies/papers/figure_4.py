"""Figure 4 of Schwarz, Posielek and Goetjes (2021): sentences of the text measured in a stop, and other wheelsets."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import uniform_filter1d

from railgrip.report import style
from railgrip.report.figures import draw_adhesion
from railgrip.report.stop import Stop
from railgrip.report.table import ReportTable
from railgrip.trace.measures import longest_lock

LIMIT = 0.15
"""Limit of adhesion in the paper, from the TSI."""

COUPLED, LAST_RISE = (9.0, 16.0), 25.0
"""Times of adhesion below the maximum possible, and of the last rise of friction, from the text of the paper [s]."""

LOCK_SPEED = 2.0
"""Speed above which no wheelset of the paper's figure locks [m/s]: its adhesion is close to the greatest possible."""

_SMOOTHED = 0.2  # s; slower changes follow the friction of the rail, faster ones are chatter

SPANS: Mapping[str, tuple[float, float]] = {
    "before 9 s": (0.0, 9.0),
    "9 to 16 s": (9.0, 16.0),
    "16 to 25 s": (16.0, 25.0),
}
"""Spans that the text of the paper distinguishes [s]."""


def course_of_adhesion(stop: Stop) -> dict[str, Any]:
    """Return measures of a stop's use of the rail's adhesion, by name.

    `duration` [s]. Of wheelset 1: `used`, adhesion over the greatest possible up to the limit, means before, in and
    after `COUPLED`; `chatter`, rms deviation of adhesion from its mean over 0.2 s, before and after `LAST_RISE`. Of
    all groups until `LAST_RISE`: `used_groups`, as `used`, and `lowest_group`, the minimum of them. Of all groups:
    `peak`, the greatest adhesion; `over`, the longest time that one of them has more than `LIMIT` [s]; `lock`, the
    longest lock of one of them while the train is faster than `LOCK_SPEED` [s].
    """
    trace = stop.trace
    time, adhesion, greatest = trace["time"].values, trace["adhesion"].values[:, 0], trace["peak_adhesion"].values[:, 0]
    window = round(_SMOOTHED / float(time[1] - time[0]))
    deviation = adhesion - uniform_filter1d(adhesion, window)
    used = adhesion / np.minimum(greatest, LIMIT)
    parts = {"before": time < COUPLED[0], "coupled": (time >= COUPLED[0]) & (time < COUPLED[1])}
    parts["after"] = (time >= COUPLED[1]) & (time < LAST_RISE)
    of_groups = trace["group_adhesion"].values
    shares = of_groups / np.minimum(trace["peak_adhesion"].values, LIMIT)
    used_groups = shares[time < LAST_RISE].mean(axis=0).tolist()
    return {
        "duration": stop.metrics.duration,
        "used": {name: float(np.mean(used[there])) for name, there in parts.items()},
        "chatter": [float(np.sqrt(np.mean(deviation[there] ** 2))) for there in (time < LAST_RISE, time >= LAST_RISE)],
        "used_groups": used_groups,
        "lowest_group": min(used_groups),
        "peak": float(of_groups.max()),
        "over": max(stop.metrics.time_over_alpha_max),
        "lock": max(longest_lock(trace, above=LOCK_SPEED)),
    }


def wheelset_figure(slip_based: Stop, law: Stop, name: str, limit: float) -> Figure:
    """Draw adhesion of all wheelsets but the first with SBC and a law."""
    numbers = range(1, slip_based.trace.sizes["wheelset"])
    drawing, panels = style.panels(9, 1.7 * len(numbers) + 0.6, len(numbers), 1, sharex=True, sharey=True)
    for panel, number in zip(panels, numbers, strict=True):
        draw_adhesion(panel, {"SBC": slip_based.trace, name: law.trace}, limit, wheelset=number)
        style.dress(panel, y="adhesion", title=f"wheelset {number + 1}")
        panel.set_ylim(0, 0.24)
    panels[-1].set_xlabel("time since the brake demand [s]")
    drawing.legend(
        *panels[0].get_legend_handles_labels(), fontsize=8, ncols=5, loc="outside upper center", frameon=False
    )
    return drawing


def used_by_wheelset(stop: Stop, limit: float) -> list[list[float]]:
    """Return adhesion over the greatest possible up to the limit, means by wheelset and span of `SPANS`."""
    trace = stop.trace
    group = trace["group_of_wheelset"].values - 1
    used = trace["adhesion"].values / np.minimum(trace["peak_adhesion"].values[:, group], limit)
    time = trace["time"].values
    means = [np.mean(used[(time >= begin) & (time < end)], axis=0) for begin, end in SPANS.values()]
    return np.transpose(means).tolist()


def used_table(found: Mapping[str, Any]) -> ReportTable:
    """Return a row for each wheelset and a column for each law; `found` is law → `used_by_wheelset`."""
    rows = [
        (f"wheelset {number}", *(" / ".join(f"{100 * share:.0f} %" for share in shares) for shares in of_laws))
        for number, of_laws in enumerate(zip(*found.values(), strict=True), start=1)
    ]
    return ReportTable.of((" / ".join(SPANS), *found), rows)
