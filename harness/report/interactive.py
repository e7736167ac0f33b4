"""Convert a matplotlib figure to Plotly, so that one drawing serves paper and interactive pages.

Plotly's own converter, `plotly.tools.mpl_to_plotly`, drops shaded bands, bars, annotations and shared axes.
"""

import re
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection, LineCollection, PolyCollection
from matplotlib.colors import to_hex, to_rgba
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.text import Annotation, Text
from matplotlib.ticker import LogFormatter, NullFormatter, ScalarFormatter
from matplotlib.transforms import Bbox

from railgrip.report.signals import TICKS, array

Plot = dict[str, Any]
"""`data` and `layout` of plotly.js."""

_PIXELS = 105.0
"""Pixels per inch of a figure, so that letters of 8 to 11 points are as large as the text of a page."""

_BAR = 26
"""Height above the figure for the buttons of plotly.js."""

_LOWEST = 155.0
"""Height of the lowest panel of a figure [pixels]; a figure with lower ones is stretched."""

_NARROWEST = 900.0
"""Width down to which page.js draws a figure narrower, with its letters [pixels]."""

_LETTERS = 11.0
"""Size of the letters in a legend [pixels]."""

_LEGEND_LINE, _LEGEND_EDGE = 20.0, 14.0
"""Height of a line of a legend, and of its margins [pixels]."""

_KEY = 50.0
"""Width of the symbol of an entry and of the space around it [pixels]."""

_DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot"}
_SHAPES = {"steps-post": "hv", "steps": "vh", "steps-pre": "vh", "steps-mid": "hvh"}
_MARKERS = {".": "circle", "o": "circle", "x": "x-thin", "|": "line-ns", "_": "line-ew", "s": "square", "D": "diamond",
            "^": "triangle-up", "v": "triangle-down", "+": "cross-thin", "*": "star"}  # fmt: skip
_SYMBOLS = {r"\mu": "μ", r"\ddot x": "ẍ", r"\tanh": "tanh"}
_NUMBERS = (ScalarFormatter, LogFormatter, NullFormatter)
"""Formatters of scales whose ticks plotly.js sets itself; others have names."""
_ANCHORS = {"center": "middle", "baseline": "bottom", "center_baseline": "middle"}


def interactive(drawing: Figure) -> Plot:
    """Return lines, areas, bars, images, texts, scales and legends of a figure for plotly.js.

    Raises:
        TypeError: The figure has an artist or a formula that cannot be converted; the page would lack it.
    """
    drawing.draw_without_rendering()  # lays out panels, ticks and legends
    plot = _Plot()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph")  # a browser has more letters than the font of figures
        for axes in drawing.axes:
            plot.add(axes)
        for legend in drawing.legends:
            plot.add_legend(legend, {})
    plot.annotations += [_note(text, text.get_position()) for text in drawing.texts if text.get_text()]
    width, height = drawing.get_size_inches()
    lowest = min((panel.get_position().height for panel in drawing.axes), default=1.0)
    top, bottom, right = (round(plot.spaces[side]) for side in "tbr")
    inner = round(max(_PIXELS * height, _LOWEST / lowest))
    layout = {
        "annotations": plot.annotations,
        "barmode": "overlay",
        "height": inner + _BAR + top + bottom,
        "meta": {"width": round(_PIXELS * width) + right},
        "margin": {"l": 0, "r": right, "t": _BAR + top, "b": bottom},
        "hovermode": "closest",
        "showlegend": True,
    }
    return {"data": plot.data, "layout": layout | plot.layout}


@dataclass(slots=True)
class _Plot:
    """The converted part of a figure."""

    data: list[Plot] = field(default_factory=list[Plot])
    layout: Plot = field(default_factory=dict[str, Any])
    annotations: list[Plot] = field(default_factory=list[Plot])
    panels: list[Axes] = field(default_factory=list[Axes])
    spaces: dict[str, float] = field(default_factory=lambda: dict.fromkeys("tbr", 0.0))
    """Further space above (t), below (b) and at the right (r) of the figure, for legends [pixels]."""

    def add(self, axes: Axes) -> None:
        self.panels.append(axes)
        number = len(self.panels)
        box = axes.get_position()
        below = next(
            (k for k, panel in enumerate(self.panels[:-1], 1) if panel.get_position().bounds == box.bounds), None
        )
        for letter, domain in (("x", (box.x0, box.x1)), ("y", (box.y0, box.y1))):
            axis = _axis(axes, letter, domain) | {"anchor": f"{'y' if letter == 'x' else 'x'}{_index(number)}"}
            siblings = getattr(axes, f"get_shared_{letter}_axes")().get_siblings(axes)
            first = next(k for k, panel in enumerate(self.panels, 1) if panel in siblings)
            axis |= {"matches": f"{letter}{_index(first)}"} if first < number else {}
            if below is not None:
                # Separate ticks: Plotly would place them at the ticks below, which are not round numbers here.
                axis |= {"overlaying": f"{letter}{_index(below)}", "showgrid": False}
                axis |= {"side": "right", "tickmode": axis.get("tickmode", "auto")} if letter == "y" else {}
            self.layout[f"{letter}axis{_index(number)}"] = axis
        place = {"xaxis": f"x{_index(number)}", "yaxis": f"y{_index(number)}"}
        names: dict[str, Plot] = {}
        for trace in _traces(axes):
            label = str(trace.pop("label", ""))
            trace |= place | {"name": label if label and not label.startswith("_") else "", "showlegend": False}
            if trace["name"]:
                names.setdefault(trace["name"], trace)
            self.data.append(trace)
        texts = [text for text in axes.get_children() if isinstance(text, Text)]  # the titles, too
        self.annotations += [_text(text, axes, place) for text in texts if text.get_text()]
        legend = axes.get_legend()
        if legend is not None:
            self.add_legend(legend, names)

    def add_legend(self, legend: Legend, names: dict[str, Plot]) -> None:
        number = 1 + sum(key.startswith("legend") for key in self.layout)
        key = f"legend{_index(number)}"
        self.layout[key] = self._place(legend) | {
            "bgcolor": "rgba(255,255,255,0.7)", "font": {"size": _LETTERS}, "xref": "paper", "yref": "paper"
        }  # fmt: skip
        for text, handle in zip(legend.get_texts(), legend.legend_handles, strict=True):
            name = text.get_text()
            if name in names:
                names[name] |= {"name": _plain(text), "legend": key, "showlegend": True}
                continue
            proxy = {"type": "scatter", "x": [None], "y": [None], "mode": "lines"}
            if isinstance(handle, Line2D):
                proxy |= _style(handle)
            elif isinstance(handle, Patch):
                proxy |= {"mode": "markers", "marker": {"symbol": "square", "color": to_hex(handle.get_facecolor())}}
            self.data.append({**proxy, "name": _plain(text), "legend": key, "showlegend": True})

    def _place(self, legend: Legend) -> Plot:
        """Return position and direction of a legend for plotly.js, whose legends are larger than those of the figure.

        One outside of the panels grows away from them. One that would cover lines or bars of its panel is moved to the
        right of the figure, or above it if the panel has another one at its right.
        """
        figure = cast(Figure, legend.get_figure(root=True))
        box = legend.get_window_extent().transformed(figure.transFigure.inverted())
        width, height = (_PIXELS * size for size in figure.get_size_inches())
        texts = legend.get_texts()
        extents = [text.get_window_extent() for text in texts]
        lines = len({round(extent.y0) for extent in extents})
        letters = _LETTERS / (_PIXELS / 72 * float(texts[0].get_fontsize()))
        entry = max(extent.width for extent in extents) / figure.dpi * _PIXELS * letters + 4
        narrow = min(1.0, _NARROWEST / width)
        columns = max(1, int(narrow * width / (narrow * entry + _KEY)))
        flat: Plot = {"orientation": "h", "x": 0.0, "xanchor": "left", "entrywidth": round(entry)}
        flat_height = _LEGEND_LINE * -(-len(texts) // columns) + _LEGEND_EDGE
        place: Plot = {"x": min(box.x0, 0.98), "xanchor": "left", "orientation": "v"}
        needed = _LEGEND_LINE * len(texts) + _LEGEND_EDGE
        # Plotly breaks a horizontal legend by the width of the figure, not of its panel.
        if lines < len(texts) and (lines == 1 or box.width > 0.5):
            place, needed = flat, flat_height
        panels = [panel.get_position() for panel in figure.axes]
        top, right = (max(getattr(panel, edge) for panel in panels) for edge in ("y1", "x1"))
        if box.y0 >= top - 0.001:
            self.spaces["t"] = max(self.spaces["t"], needed - (1 - box.y0) * height)
            return place | {"y": box.y0, "yanchor": "bottom"}
        if box.y1 <= min(panel.y0 for panel in panels) + 0.001:
            self.spaces["b"] = max(self.spaces["b"], needed - box.y1 * height)
            return place | {"y": box.y1, "yanchor": "top"}
        # It may be taller than in the figure, so it grows away from the nearest side of its panel, or of the figure.
        middle, panel = (box.y0 + box.y1) / 2, legend.axes.get_position() if legend.axes else Bbox.unit()
        low, high = (panel.y0, panel.y1) if panel.y0 < middle < panel.y1 else (0.0, 1.0)
        edge, y = ("bottom", box.y0) if middle < (low + high) / 2 else ("top", box.y1)
        if not legend.axes or place is flat:
            return place | {"y": y, "yanchor": edge}
        wide, tall = (entry + _KEY / narrow) / width, needed / height
        x = min(box.x0, max(panel.x1 - wide, panel.x0))
        bottom = y if edge == "bottom" else y - tall
        covered = Bbox.from_bounds(x, bottom, wide, tall).transformed(figure.transFigure)
        if box.x0 >= panel.x1 - 0.001:  # at its right already
            self.spaces["r"] = max(self.spaces["r"], (box.x0 + wide - 1) * width)
            return place | {"y": y, "yanchor": edge}
        if bottom >= panel.y0 and bottom + tall <= panel.y1 and not _covers(covered, legend.axes):
            return place | {"x": x, "y": y, "yanchor": edge}
        if panel.x1 >= right - 0.001:
            self.spaces["r"] = max(self.spaces["r"], (1.01 - 1 + wide) * width)
            return place | {"x": 1.01, "y": panel.y1, "yanchor": "top"}
        self.spaces["t"] += flat_height
        return flat | {"y": 1 + (self.spaces["t"] - flat_height) / height, "yanchor": "bottom"}


def _covers(box: Bbox, axes: Axes) -> bool:
    """Return whether a box, in display units, lies over a line, area or bar of axes or of others at the same place."""
    at_the_place = [
        one
        for one in cast(Figure, axes.get_figure(root=True)).axes
        if one.get_position().bounds == axes.get_position().bounds
    ]
    for one in at_the_place:
        for line in one.lines:
            path = line.get_transform().transform_path(line.get_path())
            points = np.asarray(path.vertices, float)
            if len(points) and (path.intersects_bbox(box, filled=False) or path.contains_point(box.min)):
                return True
            if any(box.contains(*point) for point in points):
                return True
        for patch in one.patches:
            if patch.get_transform().transform_path(patch.get_path()).intersects_bbox(box, filled=True):
                return True
        for collection in one.collections:
            transform = collection.get_transform()
            if any(transform.transform_path(path).intersects_bbox(box, filled=True) for path in collection.get_paths()):
                return True
        if one.images:
            return True
    return False


def _index(number: int) -> str:
    return "" if number == 1 else str(number)


def _plain(text: Text) -> str:
    # plotly.js interprets some HTML in texts, such as links.
    safe = text.get_text().replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace("\n", "<br>")
    return re.sub(r"\$([^$]*)\$", _formula, safe) if text.get_parse_math() else safe


def _formula(match: re.Match[str]) -> str:
    """Return a TeX formula as HTML, as far as the figures require: symbols, indices, exponents, a fraction."""
    formula = re.sub(r"\\frac\{(.*?)\}\{(.*)\}", r"\1 / (\2)", match[1])
    for name, symbol in _SYMBOLS.items():
        formula = formula.replace(name, symbol)
    formula = re.sub(r"_(?:\{([^{}]*)\}|(\w))", r"<sub>\1\2</sub>", formula)
    formula = re.sub(r"\^(?:\{([^{}]*)\}|(\w))", r"<sup>\1\2</sup>", formula)
    if "\\" in formula:
        raise TypeError(f"{match[0]}: has no form on a page; give it one in railgrip.report.interactive")
    return formula


def _note(text: Text, place: tuple[float, float]) -> Plot:
    across, along = text.get_horizontalalignment(), text.get_verticalalignment()
    return {"text": _plain(text), "x": place[0], "y": place[1], "xref": "paper", "yref": "paper",
            "showarrow": False, "align": across, "xanchor": across, "yanchor": _ANCHORS.get(along, along),
            "font": {"size": 1.2 * float(text.get_fontsize()), "color": to_hex(text.get_color())}}  # fmt: skip


def _axis(axes: Axes, letter: str, domain: Sequence[float]) -> Plot:
    axis = axes.xaxis if letter == "x" else axes.yaxis
    is_log = axis.get_scale() == "log"
    limits = axes.get_xlim() if letter == "x" else axes.get_ylim()
    ticks = axis.get_tick_params(which="major")
    labelled = ticks.get("labelbottom" if letter == "x" else "labelleft", True) or ticks.get("labelright", False)
    labelled = labelled and axis.get_visible()
    texts = axis.get_ticklabels()
    places = axis.get_majorticklocs()
    plot: Plot = {
        "domain": [max(domain[0], 0.0), min(domain[1], 1.0)],
        "type": "log" if is_log else "linear",
        "range": [float(limit) for limit in (np.log10(limits) if is_log else limits)],
        "title": {"text": _plain(axis.label), "standoff": 6},
        "showticklabels": bool(labelled and any(text.get_text() for text in texts)),
        "showgrid": bool(ticks.get("gridOn", False)),
        "exponentformat": "power",
        **TICKS,
        "zeroline": False,
        "visible": bool(axes.axison),
    }
    if len(places) == len(texts) and not isinstance(axis.get_major_formatter(), _NUMBERS):
        plot |= {"tickvals": [float(place) for place in places], "ticktext": [_plain(text) for text in texts]}
        plot["tickangle"] = 0  # as in the figure, which has no room for other angles
    if letter == "y" and axes.get_aspect() == 1.0:
        plot |= {"scaleanchor": "x", "scaleratio": 1}
    return plot


def _traces(axes: Axes) -> Iterator[Plot]:
    bars = [container for container in axes.containers if isinstance(container, BarContainer)]
    in_bars = {id(patch) for container in bars for patch in container.patches}
    for image in axes.images:
        yield _image(image)
    for collection in axes.collections:
        yield _collection(collection, axes)
    for container in bars:
        yield _bars(container)
    for patch in axes.patches:
        if id(patch) not in in_bars:
            corners = _in_data(patch.get_transform().transform_path(patch.get_path()).to_polygons(), axes)
            yield {**_area(corners, patch.get_facecolor(), patch.get_edgecolor(), patch.get_linewidth()),
                   "label": patch.get_label()}  # fmt: skip
    for line in sorted(axes.lines, key=lambda line: line.get_zorder()):  # later ones cover earlier ones
        points = np.column_stack([np.asarray(line.get_xdata(orig=False), float), line.get_ydata(orig=False)])
        if not len(points):  # a name for the legend, which draws it itself
            continue
        if line.get_transform() != axes.transData:
            (points,) = _in_data([line.get_transform().transform(points)], axes)
        yield {"type": "scatter", "x": array(points[:, 0]), "y": array(points[:, 1]), **_style(line),
               "label": line.get_label()}  # fmt: skip


def _in_data(shapes: Sequence[Any], axes: Axes) -> list[np.ndarray]:
    """Convert display points, shape (n, 2) each, to the units of the axes."""
    return [axes.transData.inverted().transform(np.asarray(points, float)) for points in shapes if len(points)]


def _style(line: Line2D) -> Plot:
    has_line, marker = line.get_linestyle() not in ("None", "", " "), line.get_marker()
    has_marker = marker not in ("None", "", " ", None)
    mode = "+".join([*(["lines"] if has_line else []), *(["markers"] if has_marker else [])])
    style: Plot = {"mode": mode or "none", "opacity": line.get_alpha() or 1.0}
    color = to_hex(line.get_color())
    if has_line:
        style["line"] = {
            "color": color,
            "width": 1.3 * line.get_linewidth(),
            "dash": _DASHES.get(str(line.get_linestyle()), "dash"),
            "shape": _SHAPES.get(line.get_drawstyle(), "linear"),
        }
    if has_marker:
        size = line.get_markersize() * (0.8 if marker == "." else 1.3)
        style["marker"] = {"symbol": _MARKERS.get(str(marker), "circle"), "size": size,
                           "color": to_hex(line.get_markerfacecolor() if marker in ("o", ".", "s") else color),
                           "line": {"width": 1.5 if marker in ("x", "|", "_", "+") else 0, "color": color}}  # fmt: skip
    return style


def _area(corners: Sequence[np.ndarray], face: Any, edge: Any, width: float) -> Plot:
    gap = np.full((1, 2), np.nan)
    points = np.vstack([part for corner in corners for part in (corner, gap)]) if corners else gap
    return {"type": "scatter", "mode": "lines", "fill": "toself", "x": array(points[:, 0]), "y": array(points[:, 1]),
            "fillcolor": _rgba(face), "hoverinfo": "skip",
            "line": {"width": width if to_rgba(edge)[3] else 0, "color": _rgba(edge)}}  # fmt: skip


def _rgba(color: Any) -> str:
    red, green, blue, alpha = to_rgba(color)
    return f"rgba({round(255 * red)},{round(255 * green)},{round(255 * blue)},{alpha:.3g})"


def _collection(collection: Collection, axes: Axes) -> Plot:
    transform = collection.get_transform()
    corners = _in_data([transform.transform(path.vertices) for path in collection.get_paths()], axes)
    label, widths = collection.get_label(), np.ravel(np.asarray(collection.get_linewidth()))
    if isinstance(collection, LineCollection):
        return {**_area(corners, "none", collection.get_colors()[0], 1.3 * float(widths[0])), "fill": "none",
                "label": label}  # fmt: skip
    if isinstance(collection, PolyCollection):
        edges = cast(Any, collection.get_edgecolor())
        return {**_area(corners, cast(Any, collection.get_facecolor())[0], edges[0] if len(edges) else "none",
                        float(widths[0])), "label": label}  # fmt: skip
    raise TypeError(f"{collection}: has no form on a page; give it one in railgrip.report.interactive")


def _bars(container: BarContainer) -> Plot:
    bars = cast(Sequence[Rectangle], container.patches)
    is_upright = container.orientation == "vertical"
    along = [(bar.get_y(), bar.get_height()) if is_upright else (bar.get_x(), bar.get_width()) for bar in bars]
    across = [(bar.get_x(), bar.get_width()) if is_upright else (bar.get_y(), bar.get_height()) for bar in bars]
    middles, lengths = array([start + size / 2 for start, size in across]), array([size for _, size in along])
    return {
        "type": "bar",
        "orientation": "v" if is_upright else "h",
        "x": middles if is_upright else lengths,
        "y": lengths if is_upright else middles,
        "base": array([start for start, _ in along]),
        "width": array([size for _, size in across]),
        "marker": {"color": [_rgba(bar.get_facecolor()) for bar in bars],
                   "line": {"width": bars[0].get_linewidth() if bars else 0,
                            "color": [_rgba(bar.get_edgecolor()) for bar in bars]}},
        "label": str(container.get_label()),
    }  # fmt: skip


def _image(image: Any) -> Plot:
    values, (left, right, bottom, top) = np.ma.filled(image.get_array(), np.nan), image.get_extent()
    rows, columns = values.shape
    low, high = image.get_clim()
    shades = [[share, to_hex(image.get_cmap()(share))] for share in np.linspace(0, 1, 16).tolist()]
    dx, dy = (right - left) / columns, (bottom - top) / rows
    return {"type": "heatmap", "z": [[None if np.isnan(value) else float(value) for value in row] for row in values],
            "x0": left + dx / 2, "dx": dx, "y0": top + dy / 2, "dy": dy, "zmin": low, "zmax": high,
            "colorscale": shades, "showscale": False, "label": ""}  # fmt: skip


def _text(text: Text, axes: Axes, place: Plot) -> Plot:
    shift = (0.0, 0.0)
    if isinstance(text, Annotation):
        point = axes.transData.transform(cast(Any, text.xy))
        shift = text.xyann if text.anncoords == "offset points" else shift
    else:
        point = text.get_transform().transform(text.get_position())
    (x, y), transform = axes.transAxes.inverted().transform(point), axes.transData.inverted()
    is_inside = -0.001 <= x <= 1.001 and -0.001 <= y <= 1.001
    note = _note(text, (x, y)) | {"xref": f"{place['xaxis']} domain", "yref": f"{place['yaxis']} domain"}
    if is_inside and text.get_transform() != axes.transAxes:  # moves with the point that it names
        x, y = transform.transform(point)
        note |= {"xref": place["xaxis"], "yref": place["yaxis"]}
        note |= {"x": float(np.log10(x) if axes.get_xscale() == "log" else x)}
        note |= {"y": float(np.log10(y) if axes.get_yscale() == "log" else y)}
    return note | {"xshift": shift[0], "yshift": shift[1]}
