"""Results of the monitor as a figure and as rows of a table."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from railgrip.report import palette, style
from railgrip.report.table import ReportTable
from railgrip.studies.pad_monitor.evidence import formation
from railgrip.studies.pad_monitor.watch import History, MonitorDesign


def group_names() -> list[str]:
    """Return the names of the groups, by their wheelsets, counted from the leading one."""
    return [
        f"wheelset {members.stop}"
        if members.stop - members.start == 1
        else f"wheelsets {members.start + 1} to {members.stop}"
        for members in formation().members()
    ]


def health_table(history: History, names: Sequence[str]) -> ReportTable:
    """Return one row for each group: index, trend, alarm."""
    alarms = {alarm.group: alarm for alarm in reversed(history.alarms)}
    rows = [
        {
            "group": f"{g + 1} {name}",
            "health": f"{history.index[-1, g]:.3f} ± {history.index_sd[-1, g]:.3f}",
            "trend per 100 stops": f"{1e4 * history.trend[g]:+.1f} % ± {1e4 * history.trend_sd[g]:.1f} %"
            if np.isfinite(history.trend_sd[g])
            else "too few stops",
            "alarm": f"{alarm.kind} by {names[alarm.stop]}, {100 * alarm.loss:.0f} % below its reference"
            if (alarm := alarms.get(g))
            else "none",
        }
        for g, name in enumerate(group_names())
    ]
    return ReportTable(rows, left=rows[0])


def summary_of(history: History, design: MonitorDesign) -> str:
    """Return a sentence on the evidence of the stops, and on further evidence that is needed."""
    count = len(history.index)
    opening = f"Stops that distinguish the groups: {history.chart_points} of {count}"
    if history.chart_points == 0:
        return (
            f"{opening}; the pressures never differed enough, so that only the brakes as a whole are judged; make "
            "testing stops that release one group after the other for two seconds, or stops with wheel-slide "
            "protection at work."
        )
    if history.chart_points <= design.reference:
        return f"{opening}; alarms need more than {design.reference}, the reference."
    return f"{opening}; the first {design.reference} of those are the reference."


def draw(history: History, design: MonitorDesign) -> Figure:
    """Draw health and chart of each group over the stops."""
    called = group_names()
    drawing, axes = style.panels(11.0, 2.0 * len(called), len(called), 2, sharex=True, width_ratios=(3, 2))
    number = np.arange(len(history.index)) + 1
    for g, name in enumerate(called):
        left, right = axes[g]
        distinct = history.deviation[:, g] < design.largest_deviation
        left.plot(
            number[distinct], history.evidence[distinct, g], ".", color=palette.GREY, markersize=3, label="one stop"
        )
        left.plot(number, history.index[:, g], color=palette.BLUE, label="index")
        reach = 2.0 * history.index_sd[:, g]
        style.band(left, number, history.index[:, g] - reach, history.index[:, g] + reach, palette.BLUE, 0.2)
        right.plot(number, history.chart[:, g], color=palette.BLUE)
        right.axhline(history.threshold[g], color=palette.VERMILION, lw=1.0, label="threshold")
        for alarm in history.alarms:
            if alarm.group == g:
                for part in (left, right):
                    part.axvline(alarm.stop + 1, color=palette.VERMILION, lw=1.0, ls="--")
                left.annotate(alarm.kind, (alarm.stop + 1, 0.36), color=palette.VERMILION, fontsize=8, ha="right")
        left.set_ylim(0.3, 1.4)
        # The chart continues after an alarm; only its course before the alarm is relevant.
        right.set_ylim(0.0, 2.5 * history.threshold[g] if np.isfinite(history.threshold[g]) else 1.0)
        style.dress(left, y="friction over nominal", title=f"group {g + 1}: {name}")
        style.dress(right, y="cumulated sum [σ]")
    style.legend(axes[0, 0], loc="upper right", ncols=2)
    for part in axes[-1]:
        part.set_xlabel("stop")
    return drawing
