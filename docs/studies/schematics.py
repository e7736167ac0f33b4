"""Schematic drawings: bodies with their forces."""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from railgrip.report import palette, style

Point = tuple[float, float]


def canvas(width: float, height: float, label: str) -> tuple[Figure, Axes]:
    """Return a figure with formulas and without axes, whose coordinates are inches from the lower left corner."""
    drawing = style.figure(width, height, {"left": 0, "right": 1, "bottom": 0, "top": 1})
    drawing.has_formulas = True
    drawing.set_label(label)
    axes = drawing.subplots()
    axes.set(xlim=(0, width), ylim=(0, height))
    axes.axis("off")
    return drawing, axes


def arrow(axes: Axes, begin: Point, end: Point, label: str = "", at: Point | None = None, color: str = palette.BLACK,
          ha: str = "center", fontsize: float = 9, **shape: Any) -> None:  # fmt: skip
    """Draw an arrow with a label at a point, in the middle unless given; `shape` changes its `arrowprops`."""
    look = {"arrowstyle": "-|>", "color": color, "lw": 1.3, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, begin, arrowprops=look | shape)
    place = at or ((begin[0] + end[0]) / 2, (begin[1] + end[1]) / 2)
    axes.text(*place, label, ha=ha, va="center", fontsize=fontsize, color=color)
