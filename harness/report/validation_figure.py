"""The figure above the table of accepted distances: metres by controller, with ranges and the published distances."""

import textwrap
from collections.abc import Sequence
from math import isfinite
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from railgrip.report import palette, style
from railgrip.report.baseline import Baseline
from railgrip.report.reference import label
from railgrip.report.validation import Cell, cells_of
from railgrip.scenario.campaign import Campaign

BASELINE: Final = "table1"
"""Baseline whose distances are drawn."""
FILE: Final = "distances.svg"
"""Name of the figure in the folder of the pages."""

# Shape and filling distinguish equipment in print, too.
_MARKS: Final[tuple[dict[str, Any], ...]] = (
    {"marker": "o", "markerfacecolor": "white", "color": palette.BLUE, "markersize": 6},
    {"marker": "s", "markerfacecolor": palette.VERMILION, "color": palette.VERMILION, "markersize": 5},
    {"marker": "^", "markerfacecolor": palette.GREEN, "color": palette.GREEN, "markersize": 6},
)
_COLUMN: Final = 32.0
"""Width of a column of numbers [pt]."""
_BEYOND: Final = "full_brake"
"""Kind of controller that does not extend the scale: a train that slides stops far behind the others."""


def distances_figure(campaign: Campaign, baseline: Baseline) -> tuple[Figure, str]:
    """Return the figure of a campaign with scenarios, equipment and controllers, and its numbers as text.

    A panel for each scenario has a row for each controller and a mark for each equipment, with the range over lots of
    sensors, or over perturbed plants. Without repeats with other lots the accepted distance is drawn. Published
    distances are vertical lines.
    """
    cells = [cell for cell in cells_of(campaign, baseline) if cell.distance is not None]
    scenarios = list(dict.fromkeys(cell.column for cell in cells))
    controllers = list(dict.fromkeys(_name(cell) for cell in cells))
    equipment = list(dict.fromkeys(cell.line[0] for cell in cells))
    drawing, panels = style.panels(12, 0.37 * len(controllers) + 1.3, 1, len(scenarios), sharey=True, squeeze=False)
    drawing.set_layout_engine("constrained", rect=(0.0, 0.0, 0.985, 1.0), w_pad=0.12)
    for panel, scenario in zip(panels[0], scenarios, strict=True):
        here = [cell for cell in cells if cell.column == scenario]
        style.dress(panel, x="braking distance [m]")
        panel.set_title(scenario, loc="left", fontsize=11, fontweight="bold", pad=36)
        panel.grid(visible=False, axis="y")
        for row in range(0, len(controllers), 2):
            panel.axhspan(row - 0.5, row + 0.5, color="#F1F1F1", linewidth=0, zorder=0)
        low, high = _scale(here)
        panel.set_xlim(low, high)
        _draw_published(panel, here)
        for cell in here:
            _draw(panel, cell, controllers.index(_name(cell)), equipment.index(cell.line[0]), len(equipment), high)
        for number, name in enumerate(equipment):
            _write(panel, number, name, (1.0, 1.01), "axes fraction", va="bottom")
    panels[0, 0].set_yticks(range(len(controllers)), [textwrap.fill(name, 26) for name in controllers], fontsize=8.5)
    panels[0, 0].set_ylim(len(controllers) - 0.5, -0.5)
    for panel in panels[0]:
        panel.tick_params(axis="y", length=0)
    handles = [panels[0, 0].plot([], [], linestyle="-", **_mark(number))[0] for number in range(len(equipment))]
    drawing.legend(
        handles,
        [f"{name} equipment, line: range" for name in equipment],
        loc="outside lower center",
        ncols=len(equipment),
        fontsize=9,
        frameon=False,
    )
    return drawing, "\n".join(_words(cell) for cell in cells)


def _name(cell: Cell) -> str:
    return label(cell.scenario)


def _mark(number: int) -> dict[str, Any]:
    return {"markeredgewidth": 1.5, "linewidth": 1.6, **_MARKS[number % len(_MARKS)]}


def _write(panel: Axes, number: int, text: str, place: tuple[float, float], coordinates: Any, **options: Any) -> None:
    """Write into a column to the right of a panel, at the height of a place on the panel's edge."""
    panel.annotate(
        text,
        place,
        xycoords=coordinates,
        xytext=(_COLUMN * (number + 1), 0),
        textcoords="offset points",
        ha="right",
        fontsize=8,
        color=_MARKS[number % len(_MARKS)]["color"],
        annotation_clip=False,
        **options,
    )


def _scale(cells: Sequence[Cell]) -> tuple[float, float]:
    """Return the ends of the scale [m], which holds all distances but those of `_BEYOND`."""
    shown = [cell for cell in cells if cell.scenario["controller"]["kind"] != _BEYOND] or cells
    ends = [end for cell in shown for end in (*cell.ends, cell.paper) if end is not None and isfinite(end)]
    margin = 0.06 * (max(ends) - min(ends)) or 1.0
    return min(ends) - margin, max(ends) + margin


def _draw(panel: Axes, cell: Cell, row: int, number: int, count: int, high: float) -> None:
    """Draw a distance, its range and its number of metres; a distance beyond the scale is an arrow at its end."""
    distance = cell.distance or 0.0
    y = row + 0.3 * (number - (count - 1) / 2)
    mark = _mark(number)
    if distance > high:
        mark.update(marker=">", clip_on=False)
    else:
        panel.plot(cell.ends, [y, y], "-|", color=mark["color"], linewidth=1.6, markersize=5, zorder=3)
    panel.plot([min(distance, high)], [y], zorder=4, **mark)
    _write(panel, number, f"{distance:.0f}", (1.0, row), panel.get_yaxis_transform(), va="center")


def _draw_published(panel: Axes, cells: Sequence[Cell]) -> None:
    for cell in cells:
        if cell.paper is not None:
            panel.axvline(cell.paper, color=palette.BLACK, linestyle=(0, (4, 3)), linewidth=1.0, zorder=1)
            panel.text(
                *(cell.paper, 1.01),
                f"published,\n{_name(cell).partition(',')[0]}\n{cell.paper:.1f}",
                transform=panel.get_xaxis_transform(),
                ha="center",
                va="bottom",
                fontsize=7.5,
            )


def _words(cell: Cell) -> str:
    """Return the numbers of a cell as text, so that a figure in a file can be compared with the accepted distances."""
    low, high = cell.ends
    paper = "" if cell.paper is None else f", paper {cell.paper:.1f} m"
    return f"{cell.stop.name}: {cell.distance:.1f} m, {low:.1f} to {high:.1f} m{paper}"
