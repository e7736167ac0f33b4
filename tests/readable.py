"""Defects that make a figure unreadable: texts or legends that overlap, are cut off or missing, and empty panels."""

import html
import re
from collections import Counter
from collections.abc import Iterator
from itertools import chain

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.category import UnitData
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Text
from matplotlib.ticker import ScalarFormatter

TOUCHING = 2.0
"""Pixels by which boxes of texts may overlap: they enclose ascenders and descenders that a text may lack."""


def defects_of(drawing: Figure) -> list[str]:
    """Return a sentence for each overlap of texts or legends, each of them cut off, and each panel without data.

    Likewise for bars without names: they are at numbers, or at texts, where bars of equal names are in one place.
    """
    if drawing.stale:  # otherwise it was just drawn to be saved
        drawing.draw_without_rendering()
    panels = [axes for axes in drawing.axes if axes.get_visible()]
    artists = _shown(drawing)
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
        *(f"bars of panel {number} have no names" for number, axes in enumerate(panels, 1) if not _has_names(axes)),
    ]


def missing_in(svg: bytes, drawing: Figure) -> list[str]:
    """Return the lines of the texts of a figure that its SVG with texts does not have; formulas are left out."""
    found = Counter(html.unescape(line) for line in re.findall(r"<text[^>]*>([^<]*)</text>", svg.decode()))
    texts = chain(*(each.get_texts() if isinstance(each, Legend) else [each] for each in _shown(drawing)))
    plain = (text.get_text() for text in texts if "$" not in text.get_text() or not text.get_parse_math())
    lines = Counter(line for text in plain for line in text.split("\n") if line.strip())
    return [*(lines - found)]


def _shown(drawing: Figure) -> list[Text | Legend]:
    """Return the visible texts and legends of a figure that has been drawn, the former without those in legends."""
    panels = (axes for axes in drawing.axes if axes.get_visible())
    return [artist for artist in chain(drawing.get_children(), *map(_artists, panels)) if _is_shown(artist)]


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


def _has_names(axes: Axes) -> bool:
    """Return whether bars that are counted have names, and no names are coordinates."""
    for bars in axes.containers:
        if not isinstance(bars, BarContainer):
            continue
        is_high = bars.orientation == "vertical"
        axis = axes.xaxis if is_high else axes.yaxis
        boxes = [bar.get_bbox().get_points()[:, 0 if is_high else 1] for bar in bars]
        is_counted = all(abs(high - low) <= 1 and (low + high) / 2 == round((low + high) / 2) for low, high in boxes)
        has_numbers = isinstance(axis.get_major_formatter(), ScalarFormatter)
        if isinstance(axis.units, UnitData) or (is_counted and has_numbers):
            return False
    return True
