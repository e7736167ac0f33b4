"""Defects that make a figure unreadable: texts or legends that overlap or are cut off, and panels without data."""

from collections.abc import Iterator
from itertools import chain

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Text

TOUCHING = 2.0
"""Pixels by which boxes of texts may overlap: they enclose ascenders and descenders that a text may lack."""


def defects_of(drawing: Figure) -> list[str]:
    """Return a sentence for each overlap of texts or legends, each of them cut off, and each panel without data."""
    if drawing.stale:  # otherwise it was just drawn to be saved
        drawing.draw_without_rendering()
    panels = [axes for axes in drawing.axes if axes.get_visible()]
    artists = [artist for artist in chain(drawing.get_children(), *map(_artists, panels)) if _is_shown(artist)]
    names = [_name(artist) for artist in artists]
    boxes = np.array([artist.get_window_extent().extents for artist in artists]).reshape(-1, 4)
    low, high = boxes[:, :2], boxes[:, 2:]
    common = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    pairs = np.argwhere(np.triu((common > TOUCHING).all(axis=2), 1))
    is_cut = ((low < -TOUCHING) | (high > drawing.bbox.max + TOUCHING)).any(axis=1)
    return [
        *(f"{names[one]} overlaps {names[other]}" for one, other in pairs),
        *(f"{names[one]} is cut off" for one in np.flatnonzero(is_cut)),
        *(f"panel {number} is empty" for number, axes in enumerate(panels, 1) if axes.axison and not _has_data(axes)),
    ]


def _artists(axes: Axes) -> Iterator[object]:
    """Yield titles, texts and legend of a panel, and the labels of its axes and ticks."""
    yield from axes.get_children()
    for axis in (axes.xaxis, axes.yaxis) if axes.axison else ():
        if axis.get_visible():
            yield from (axis.label, axis.offsetText, *_tick_labels(axis))


def _tick_labels(axis: Axis) -> Iterator[Text]:
    low, high = sorted(axis.get_view_interval())
    for is_minor in (False, True):
        places, labels = axis.get_ticklocs(minor=is_minor), axis.get_ticklabels(minor=is_minor)
        yield from (label for place, label in zip(places, labels, strict=False) if low <= place <= high)


def _is_shown(artist: object) -> bool:
    return isinstance(artist, Legend) or (
        isinstance(artist, Text) and artist.get_visible() and bool(artist.get_text().strip())
    )


def _name(artist: Text | Legend) -> str:
    return f"'{artist.get_text()}'" if isinstance(artist, Text) else f"the legend of {_first(artist)}"


def _first(legend: Legend) -> str:
    return ", ".join(f"'{text.get_text()}'" for text in legend.get_texts()[:1])


def _has_data(axes: Axes) -> bool:
    """Return whether a panel contains more than lines and bands across its whole width."""
    low, high = axes.viewLim.min, axes.viewLim.max
    lines = [line.get_xydata() for line in axes.lines if line.get_transform() == axes.transData]
    areas = [area.get_datalim(axes.transData).get_points() for area in axes.collections]
    bars = [bar for bar in axes.patches if bar.get_data_transform() == axes.transData]
    return (
        bool(axes.images or axes.texts or bars)
        or any(((low <= points) & (points <= high)).all(axis=1).any() for points in lines)
        or any(np.isfinite(points).all() for points in areas)
    )
