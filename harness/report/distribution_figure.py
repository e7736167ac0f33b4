"""Figure of the distances of many draws: a point per draw for each controller, and its change against SBC."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from railgrip.report import palette, style
from railgrip.report.frame import PLACE, Frame, groups_of
from railgrip.trace.metrics import FIGURES

_MAX_BINS = 60

_JITTER = 0.26  # of the height of a row, to either side


def distribution_figure(distributions: Frame, *, of: str = "draw") -> Figure:
    """Return a row of panels for each set of conditions, a line for each controller.

    On the left the distances, with median and the range from 5 to 95 %; to their right the change draw by draw against
    the published slip-based control and against the best tuned one, if they exist, with the median and its interval.
    Draws without standstill are counted in the name of the line; they have no point. `of` is the noun for a draw.
    """
    settings = [list(here.itertuples()) for _, here in groups_of(distributions, PLACE)]
    sides = [
        (f"change against the {title} SBC [%]", against)
        for title, against in (("published", "vs_sbc"), ("best tuned", "vs_tuned"))
        if distributions[against].notna().any()
    ]
    most = max(map(len, settings))
    drawing = style.figure(6.5 + 4 * len(sides), (0.42 * most + 1.2) * len(settings))
    grid = drawing.subplots(len(settings), 1 + len(sides), sharex="col", squeeze=False)
    for panels, here in zip(grid, settings, strict=True):
        for panel, _ in zip(panels, range(1 + len(sides)), strict=True):
            panel.set_ylim(len(here) - 0.5, -0.5)
            panel.set_yticks([])
        style.dress(
            panels[0],
            x=FIGURES["distance"].axis,
            title=f"{here[0].label.replace('_', ' ')}, actuation {here[0].actuation}, sensors {here[0].sensors}, "
            f"creep curve {here[0].polach}",
        )
        panels[0].set_yticks(range(len(here)), [_name(one, of) for one in here])
        for line, one in enumerate(here):
            _points(panels[0], line, one.distances[np.isfinite(one.distances)].tolist())
            _range(panels[0], line, one.low, one.median, one.high)
        for panel, (title, against) in zip(panels[1:], sides, strict=True):
            style.dress(panel, x=title)
            panel.axvline(0.0, color=palette.BLACK, linewidth=0.9)
            for line, one in enumerate(here):
                paired = getattr(one, against)
                if paired is not None:
                    _points(panel, line, [100 * change for change in paired.changes if math.isfinite(change)])
                    low, high = paired.change_interval or (math.nan, math.nan)
                    _range(panel, line, 100 * low, 100 * paired.change, 100 * high)
        for panel in panels:
            panel.grid(visible=False, axis="y")
    for panel in grid[:-1].flat:
        panel.set_xlabel("")
    keys = [
        (f"a {of}", palette.SKY, "."),
        ("median", palette.VERMILION, "|"),
        (f"5 to 95 % of the {of}s", palette.BLUE, "_"),
    ]
    keys += [("right: 95 % interval of the median", palette.BLUE, "_")] if sides else []
    marks = [Line2D([], [], color=colour, marker=mark, markersize=9, linestyle="") for _, colour, mark in keys]
    drawing.legend(marks, [name for name, _, _ in keys], ncols=4, fontsize=8, loc="outside lower right", frameon=False)
    return drawing


def exceedance_figure(distributions: Frame, permitted: float | None) -> Figure:
    """Return a figure of histogram and exceedance share, in a row of panels for each set of conditions.

    Args:
        distributions: A line for each; draws without standstill remain in the share up to the right end.
        permitted: Maximum permitted distance of a stop [m], drawn as a line.
    """
    settings = [list(here.itertuples()) for _, here in groups_of(distributions, PLACE)]
    drawing = style.figure(11, 3.6 * len(settings))
    grid = drawing.subplots(len(settings), 2, squeeze=False, sharex="row")
    for (counts, shares), here in zip(grid, settings, strict=True):
        ends = np.concatenate([one.distances[np.isfinite(one.distances)] for one in here])
        # The same bins for all, so that the bars of two controllers can be compared (Freedman and Diaconis, 1981).
        edges = np.histogram_bin_edges(ends, "fd" if ends.size > 1 else 1) if ends.size else np.array([0.0, 1.0])
        edges = np.linspace(edges[0], edges[-1], min(edges.size, _MAX_BINS))
        for number, one in enumerate(here):
            values = np.sort(one.distances.to_numpy())
            colour = palette.LINES[number % len(palette.LINES)]
            height = np.histogram(values[np.isfinite(values)], edges)[0] / values.size
            look: dict[str, Any] = {"drawstyle": "steps-post", "color": colour, "label": one.controller_label}
            counts.plot(edges, [*(100 * height), 0.0], **look)
            stood = np.isfinite(values)
            above = 100 * (1 - np.arange(1, values.size + 1) / values.size)
            shares.plot(values[stood], above[stood], **look)
        for panel in (counts, shares):
            if permitted is not None:
                panel.axvline(permitted, color=palette.GREY, linestyle="--", label=f"permitted, {permitted:g} m")
        axis, setting = FIGURES["distance"].axis, f"{here[0].actuation}, {here[0].sensors}, {here[0].polach}"
        style.dress(counts, x=axis, y="share of the draws [%]", title=here[0].label.replace("_", " "))
        style.dress(shares, x=axis, y="draws that go further [%]", title=setting)
        shares.set_yscale("log")
        shares.set_ylim(max(50 / max(one.draws for one in here), 0.01), 100)
        shares.set_yticks(
            [percentage for percentage in (0.1, 1, 5, 50, 100) if percentage >= shares.get_ylim()[0]], minor=False
        )
        shares.yaxis.set_major_formatter("{x:g}")
        shares.yaxis.set_minor_locator(NullLocator())
    style.legend(grid[0, 1], loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return drawing


def _points(panel: style.Axes, line: int, values: Sequence[float]) -> None:
    # Spread over the height of the row by a golden ratio, so that equal values do not hide each other.
    offsets = _JITTER * (2 * ((np.arange(len(values)) * 0.6180339887) % 1.0) - 1)
    panel.plot(values, line + offsets, ".", color=palette.SKY, markersize=3.5, zorder=1)


def _range(panel: style.Axes, line: int, low: float, middle: float, high: float) -> None:
    if math.isfinite(low) and math.isfinite(high):
        panel.plot([low, high], [line, line], color=palette.BLUE, linewidth=2.2, zorder=2, solid_capstyle="butt")
    if math.isfinite(middle):
        panel.plot([middle, middle], [line - 0.32, line + 0.32], color=palette.VERMILION, linewidth=2.2, zorder=3)


def _name(one: Any, of: str) -> str:
    missing = one.draws - one.stood
    return one.controller_label + (
        f"\n{missing} {of}{'s' if missing > 1 else ''} without standstill" if missing else ""
    )
