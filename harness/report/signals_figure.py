"""The figure of the signals of one stop."""

from math import ceil, isfinite
from typing import Any

import numpy as np
import xarray
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from railgrip.report import palette, style
from railgrip.report.signals import SignalLine, SignalPanel, signal_panels
from railgrip.trace.metrics import Metrics

_STOP_MARGINS = {"left": 0.055, "right": 0.875, "wspace": 0.06, "hspace": 0.1}

_MAX_COLUMNS = 8
"""Maximum number of groups side by side, so that panels stay readable; those of a longer train follow below."""

_LINES: dict[str, dict[str, Any]] = {
    "train": {"color": palette.BLACK, "linewidth": 1.4},
    "optimum": {"color": palette.BLACK, "linewidth": 1.2},
    "group": {"color": palette.BLUE, "linewidth": 0.9},
    "estimate": {"color": palette.VERMILION, "linewidth": 1.0, "linestyle": (0, (2, 1.2))},
}
"""Role of a line → its style; lines of other roles are not drawn."""


def signals_figure(trace: xarray.Dataset, metrics: Metrics, title: str) -> Figure:
    """Return the figure of one stop: a column for each group, rows from speed to pressure.

    A train of many groups continues below, in bands with the same axes. Signals that a foreign plant does not output,
    and that are not estimated, have no row.
    """
    time = trace["time"].values
    quantities = [panel for panel in signal_panels(trace) if any(line.role in _LINES for line in panel.lines)]
    outside = {"adhesion": metrics.adhesion_outside, "pad friction": metrics.pad_friction_outside}
    drawing, panels = _columns(trace.sizes["group"], len(quantities))
    for row, quantity in zip(panels, quantities, strict=True):
        shares = outside.get(quantity.label)
        for group, panel in enumerate(row):
            for line in quantity.lines:
                if line.role in _LINES:
                    _draw(panel, time, line, group)
            if shares is not None and isfinite(shares[group]):
                panel.text(0.98, 0.96, f"{100 * shares[group]:.0f} % outside ±2σ", transform=panel.transAxes,
                           ha="right", va="top", fontsize=8)  # fmt: skip
            style.dress(panel, y=quantity.label if panel.get_subplotspec().is_first_col() else "")
        _scale(row, quantity)
        style.legend(row[_wide(len(row)) - 1], loc="center left", bbox_to_anchor=(1.0, 0.5))
    for group in range(trace.sizes["group"]):
        panels[0, group].set_title(f"group {group + 1}", fontsize=10)
        panels[-1, group].set_xlabel("time [s]")
        panels[0, group].set_xlim(0, time[-1])
    # Smaller letters for a long title, such as that of a user's class: 150 of eleven points fill the width.
    size = min(11.0, 1650.0 / max(len(title), 1))
    drawing.suptitle(title, x=0.01, y=1 - 0.22 / drawing.get_figheight(), ha="left", fontsize=size)
    return drawing


def _draw(panel: style.Axes, time: np.ndarray, line: SignalLine, group: int) -> None:
    values = line.values if line.role == "train" else line.values[:, group]
    if line.deviation is not None:
        half_width = 2 * line.deviation[:, group]
        style.band(panel, time, values - half_width, values + half_width, palette.ORANGE, 0.3, label="±2σ")
    panel.plot(time, values, label=line.label, **_LINES[line.role])


def _scale(row: np.ndarray, quantity: SignalPanel) -> None:
    # Setting the limits of a panel freezes them, so this comes after all lines.
    low, high = quantity.limits or (0, max(panel.get_ylim()[1] for panel in row))
    for panel in row:
        if quantity.log_ticks:
            panel.set_yscale("log")
            panel.set_yticks(quantity.log_ticks, [f"{tick:g}" for tick in quantity.log_ticks])
            panel.yaxis.set_minor_locator(NullLocator())
        panel.set_ylim(low, high)


def _wide(groups: int) -> int:
    return ceil(groups / ceil(groups / _MAX_COLUMNS))


def _columns(groups: int, rows: int) -> tuple[Figure, np.ndarray]:
    """Return a figure and its panels, shape (rows, groups), in as many bands as their width requires."""
    bands = ceil(groups / _MAX_COLUMNS)
    wide = _wide(groups)
    above, below, between, block = 0.77, 0.5, 0.85, 0.03 + 1.94 * rows  # inches
    height = above + bands * block + (bands - 1) * between + below
    drawing = style.figure(14, height, _STOP_MARGINS)
    parts: list[np.ndarray] = []
    for band in range(bands):
        top = above + band * (block + between)
        grid = drawing.add_gridspec(
            rows, wide, top=1 - top / height, bottom=1 - (top + block) / height, **_STOP_MARGINS
        )
        panels = grid.subplots(sharex=True, sharey="row", squeeze=False)
        for spare in panels[:, groups - band * wide :].flat:
            spare.remove()
        parts.append(panels[:, : groups - band * wide])
    return drawing, np.hstack(parts)
