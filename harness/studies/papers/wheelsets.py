"""Figure 4 of Schwarz, Posielek and Goetjes (2021) for the wheelsets that the paper leaves out."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from railgrip.report import style
from railgrip.report.figures import draw_adhesion
from railgrip.report.stop import Stop
from railgrip.report.table import ReportTable

SPANS: Mapping[str, tuple[float, float]] = {
    "before 9 s": (0.0, 9.0),
    "9 to 16 s": (9.0, 16.0),
    "16 to 25 s": (16.0, 25.0),
}
"""Spans that the text of the paper distinguishes [s]."""


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
