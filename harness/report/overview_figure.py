"""The figure of the overview: metres of each law on each rail, with ranges and the published distances."""

import textwrap
from math import isfinite, nan
from typing import Final

from matplotlib.figure import Figure

from railgrip.report import palette, style
from railgrip.report.overview import Overview, OverviewLine
from railgrip.trace.metrics import FIGURES

_TICK: Final = 50
"""Distance of ticks [m]."""
_BAR: Final = 0.34
"""Height of a row [inches]."""
_LEAST: Final = 1.7
"""Height of the rows of a panel below which a page would draw it lower than 150 pixels [inches]."""

FIGURE_MEANING: Final = (
    "In the figure, dots are simulated distances, solid lines ranges of repeated stops, and dashed lines published "
    "distances; the further left, the shorter the stop."
)


def overview_figure(overview: Overview, *, is_narrow: bool = False) -> Figure:
    """Return a figure with a panel for each case, and in it a row for each law.

    A dot is the distance, a line the range of repeats, a dashed line the published distance of the row's law.

    Args:
        is_narrow: Whether panels are below each other, for a screen of the width of a hand.
    """
    own = [line for line in overview.lines if not line.is_published]
    published = {line.kind: line for line in overview.lines if line.is_published}
    count = len(overview.cases)
    height = max(_LEAST, _BAR * len(own))
    if is_narrow:
        drawing, grid = style.panels(3.2, count * (height + 0.85), count, 1, squeeze=False)
    else:
        drawing, grid = style.panels(10.9, height + 0.85, 1, count, sharey=True, squeeze=False)
    low, high = _limits(overview)
    for panel, case in zip(grid.flat, overview.cases, strict=True):
        style.dress(
            panel, title=case, x=FIGURES["distance"].axis if not is_narrow or case == overview.cases[-1] else ""
        )
        panel.grid(visible=False, axis="y")
        panel.set_xlim(low, high)
        # Round numbers that are not cut off at the right edge.
        ticks = [tick for tick in range(0, int(high), _TICK) if low <= tick <= high - 0.1 * (high - low)]
        panel.set_xticks(ticks, [f"{tick}" for tick in ticks])
        panel.set_ylim(len(own) - 0.5, -0.5)
        panel.tick_params(axis="y", length=0)
        for row, line in enumerate(own):
            distance = line.distances.get(case, nan)
            reference = published.get(line.kind)
            metres = nan if reference is None else reference.distances.get(case, nan)
            if isfinite(metres):
                panel.plot([metres, metres], [row - 0.42, row + 0.42], "--", color=palette.BLACK, linewidth=1.4)
            if not isfinite(distance):
                continue
            ends = line.ranges.get(case)
            if ends is not None:
                panel.plot(ends, [row, row], "-", color=palette.BLUE, linewidth=1.6)
            panel.plot([distance], [row], "o", color=palette.BLUE, markersize=5.5)
            panel.annotate(
                f"{distance:.0f}", (max(ends or (distance,)), row), ha="left", va="center", fontsize=8, xytext=(7, 0),
                textcoords="offset points", color=palette.BLUE,
            )  # fmt: skip
        if is_narrow or panel is grid.flat[0]:
            panel.set_yticks(range(len(own)), [_name(line) for line in own], fontsize=8.5)
    return drawing


def _name(line: OverviewLine) -> str:
    return textwrap.fill(line.name.removesuffix(", simulated"), 18)


def _limits(overview: Overview) -> tuple[float, float]:
    distances = [metres for line in overview.lines for metres in line.distances.values()]
    ends = [end for line in overview.lines for pair in line.ranges.values() for end in pair]
    values = [value for value in (*distances, *ends) if isfinite(value)]
    margin = 0.08 * (max(values) - min(values)) or 1.0
    return min(values) - margin, max(values) + 2.5 * margin  # room for a number behind the last dot
