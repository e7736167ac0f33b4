"""The figure of a sweep: braking distances over its longest axis."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from railgrip.report import palette, style

_COLOURS = palette.LINES
_MAX_TICKS = 20


def sweep_figure(axes: Mapping[str, Sequence[Any]], distances: NDArray[np.float64]) -> Figure:
    """Return a figure of distances over the longest axis, with a line for each combination of the others, or their
    median.

    Args:
        axes: Key → values.
        distances: Distances in the shape of the axes [m]; NaN without a standstill.
    """
    names = list(axes)
    longest = max(names, key=lambda name: len(axes[name]))
    others = [name for name in names if name != longest and len(axes[name]) > 1]
    lines = np.moveaxis(distances, names.index(longest), -1).reshape(-1, len(axes[longest]))
    drawing, panel = style.panels(9, 4.5)
    places = np.arange(lines.shape[1])
    if len(lines) > len(_COLOURS):
        for line in lines:
            panel.plot(places, line, ".", color=palette.GREY, ms=3)
        with np.errstate(all="ignore"):
            median = np.nanmedian(lines, axis=0)
        panel.plot(places, median, "o-", color=palette.BLUE, label=f"median over {', '.join(others)}")
    else:
        labels = _labels([(name, axes[name]) for name in names if name != longest])
        for line, label, colour in zip(lines, labels, _COLOURS, strict=False):
            panel.plot(places, line, "o-", color=colour, ms=4, linewidth=1.2, label=label or None)
    shown = places[:: 1 + (len(places) - 1) // _MAX_TICKS]
    texts = [_text(axes[longest][place]) for place in shown]
    panel.set_xticks(shown, texts, rotation=30 if max(map(len, texts)) > 8 else 0)
    style.dress(panel, x=longest, y="braking distance [m]")
    if others:
        style.legend(panel)
    return drawing


def _labels(axes: Sequence[tuple[str, Sequence[Any]]]) -> list[str]:
    labels = [""]
    for name, values in axes:
        more = [f"{name} {_text(value)}" if len(values) > 1 else "" for value in values]
        labels = [", ".join(filter(None, (label, axis))) for label in labels for axis in more]
    return labels


def _text(value: Any) -> str:
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= 24 else f"{text[:23]}…"
