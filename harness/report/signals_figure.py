"""The figure of the signals of one stop."""

from math import ceil, isfinite

import numpy as np
import xarray
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from railgrip.report import palette, style
from railgrip.trace.metrics import Metrics

_STOP_MARGINS = {"left": 0.055, "right": 0.875, "wspace": 0.06, "hspace": 0.1}

_MAX_COLUMNS = 8
"""Maximum number of groups side by side, so that panels stay readable; those of a longer train follow below."""


def signals_figure(trace: xarray.Dataset, metrics: Metrics, title: str) -> Figure:
    """Return the figure of one stop: a column for each group, rows from speed to pressure.

    A train of many groups continues below, in bands with the same axes.

    The rows are speeds of train and wheelset; slip and the slip of maximum adhesion; adhesion with its estimate ±2σ and
    the maximum; the same for the pad friction; cylinder pressure. Signals that a foreign plant does not output, and
    that are not estimated, have no row.
    """
    time = trace["time"].values
    rows = {
        quantity: draw
        for quantity, draw in _ROWS.items()
        if any(_has_values(trace, name) for name in _SIGNALS[quantity])
    }
    outside = {"adhesion": metrics.adhesion_outside, "pad friction": metrics.pad_friction_outside}
    drawing, panels = _columns(trace.sizes["group"], len(rows))
    for row, (quantity, draw) in zip(panels, rows.items(), strict=True):
        for group, panel in enumerate(row):
            draw(panel, time, trace, group)
            shares = outside.get(quantity)
            if shares is not None and isfinite(shares[group]):
                panel.text(0.98, 0.96, f"{100 * shares[group]:.0f} % outside ±2σ", transform=panel.transAxes,
                           ha="right", va="top", fontsize=8)  # fmt: skip
            panel.grid(visible=True, color="#DDDDDD", linewidth=0.6)
            panel.spines[["top", "right"]].set_visible(False)
            if panel.get_subplotspec().is_first_col():
                panel.set_ylabel(quantity)
        if quantity in _FROM_ZERO:
            # Setting the limits of a panel freezes them, so this comes after all lines.
            top = max(panel.get_ylim()[1] for panel in row)
            for panel in row:
                panel.set_ylim(0, top)
        style.legend(row[_wide(len(row)) - 1], loc="center left", bbox_to_anchor=(1.0, 0.5))
    for group in range(trace.sizes["group"]):
        panels[0, group].set_title(f"group {group + 1}", fontsize=10)
        panels[-1, group].set_xlabel("time [s]")
        panels[0, group].set_xlim(0, time[-1])
    drawing.suptitle(title, x=0.01, y=1 - 0.22 / drawing.get_figheight(), ha="left", fontsize=11)
    return drawing


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


def _has_values(trace: xarray.Dataset, name: str) -> bool:
    return name in trace and bool(np.isfinite(trace[name].values).any())


def _draw_speed(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, group: int) -> None:
    train = style.KMH * trace["speed"].values
    panel.plot(time, train, color=palette.BLACK, linewidth=1.4, label="train")
    if _has_values(trace, "slip"):
        wheelset = train * (1 - trace["slip"].values[:, group])
        panel.plot(time, wheelset, color=palette.BLUE, linewidth=0.9, label="wheelset")


def _draw_slip(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, group: int) -> None:
    panel.plot(time, 100 * trace["slip"].values[:, group], color=palette.BLUE, linewidth=0.9, label="slip")
    if _has_values(trace, "peak_slip"):
        best = 100 * trace["peak_slip"].values[:, group]
        panel.plot(time, best, color=palette.BLACK, linewidth=1.2, label="of greatest adhesion")
    # The optimum slip is 1 to 10 %, a locked wheel 100 %: only a logarithmic axis resolves both.
    panel.set_yscale("log")
    panel.set_ylim(0.1, 120)
    panel.set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
    panel.yaxis.set_minor_locator(NullLocator())


def _draw_adhesion(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, group: int) -> None:
    # A plant that does not output its brakes has no bound.
    if _has_values(trace, "peak_adhesion"):
        best = trace["peak_adhesion"].values[:, group]
        panel.plot(time, best, color=palette.BLACK, linewidth=1.2, label="greatest possible")
    _draw_truth_and_estimate(panel, time, trace, "group_adhesion", "estimate_adhesion", group)


def _draw_friction(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, group: int) -> None:
    _draw_truth_and_estimate(panel, time, trace, "pad_friction", "estimate_pad_friction", group)
    # The estimate before the first brake application may be very uncertain; it must not determine the scale.
    panel.set_ylim(0.2, 0.6)


def _draw_pressure(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, group: int) -> None:
    pressure = trace["cylinder_pressure"].values[:, group] / 1e5
    panel.plot(time, pressure, color=palette.BLUE, linewidth=0.9, label="cylinder")


def _draw_truth_and_estimate(
    panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, truth: str, belief: str, group: int
) -> None:
    if _has_values(trace, truth):
        panel.plot(time, trace[truth].values[:, group], color=palette.BLUE, linewidth=1.0, label="true")
    if _has_values(trace, belief):
        _draw_estimate(panel, time, trace, belief, group)


_ROWS = {
    "speed [km/h]": _draw_speed,
    "slip [%]": _draw_slip,
    "adhesion": _draw_adhesion,
    "pad friction": _draw_friction,
    "cylinder pressure [bar]": _draw_pressure,
}

_FROM_ZERO = {"adhesion", "cylinder pressure [bar]"}

_SIGNALS = {
    "speed [km/h]": ("speed",),
    "slip [%]": ("slip",),
    "adhesion": ("group_adhesion", "estimate_adhesion"),
    "pad friction": ("pad_friction", "estimate_pad_friction"),
    "cylinder pressure [bar]": ("cylinder_pressure",),
}


def _draw_estimate(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, name: str, group: int) -> None:
    mean = trace[name].values[:, group]
    if f"{name}_sd" in trace:
        half_width = 2 * trace[f"{name}_sd"].values[:, group]
        style.band(panel, time, mean - half_width, mean + half_width, palette.ORANGE, 0.3, label="±2σ")
    panel.plot(time, mean, color=palette.VERMILION, linewidth=1.0, linestyle=(0, (2, 1.2)), label="estimated")
