"""Figures of campaigns and sweeps: friction, adhesion, and distances over cases and draws and next to others."""

import json
import math
import textwrap
from collections.abc import Mapping, Sequence
from itertools import cycle
from math import isfinite, isnan
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, NullLocator
from numpy.typing import NDArray

from railgrip.base.groups import gather
from railgrip.report import palette, style
from railgrip.report.distribution import distributions_of, over_cases
from railgrip.report.figures import draw_adhesion, draw_wheelsets
from railgrip.report.frame import PLACE, SETTING, Frame, groups_of, short_names
from railgrip.report.reference import CONTROLLERS
from railgrip.report.stop import Stop
from railgrip.trace.metrics import FIGURES

_RAIL_COLOURS = (*palette.LINES, palette.GREY)


_SEEKING = "peak seeking"


def friction_figure(stops: Sequence[Stop]) -> Figure:
    """Return a figure of the maximum friction over time, with a panel for each scenario.

    For a scenario with one rail every wheelset is drawn, with several rails the leading wheelset on each of them.
    Source of the layout: Schwarz, Posielek and Goetjes, Fig. 3.

    Args:
        stops: Stops, of which the longest on each rail is drawn.
    """
    scenarios = _rails(stops)
    drawing = style.figure(9, sum(2.4 if len(rails) == 1 else 3.4 for rails in scenarios.values()))
    panels = drawing.subplots(len(scenarios), 1, sharex=True, squeeze=False)[:, 0]
    for panel, rails in zip(panels, scenarios.values(), strict=True):
        for colour, (name, stop) in zip(cycle(_RAIL_COLOURS), rails.items(), strict=False):
            trace = stop.trace
            mu0, time = trace["mu0"].values, trace["time"].values
            if len(rails) == 1:
                draw_wheelsets(panel, time, mu0)
            else:
                panel.plot(time, mu0[:, 0], color=colour, linewidth=1.2, label=name)
        titles = {stop.title for stop in rails.values()}
        style.dress(panel, y="maximum friction μ₀", title=", ".join(sorted(titles)))
        panel.set_ylim(bottom=0)
        panel.set_xlim(0, None)
        if len(rails) > 1:
            style.legend(panel, loc="center left", bbox_to_anchor=(1.0, 0.5))
    if all(len(rails) == 1 for rails in scenarios.values()):
        panels[0].legend(ncols=3, fontsize=8, loc="lower right", framealpha=0.9)
    panels[-1].set_xlabel("time since the brake demand [s]")
    return drawing


def _rails(stops: Sequence[Stop]) -> dict[str, dict[str, Stop]]:
    """Return scenario → name of the rail → longest stop on it; rails are named by the variants that only they have."""
    rails: dict[str, dict[str, list[Stop]]] = {}
    for stop in stops:
        scenario = stop.inputs
        rails.setdefault(scenario["name"], {}).setdefault(_rail(scenario["adhesion"]), []).append(stop)
    return {
        name: {
            _variants(here, list(of_rail.values())): max(here, key=lambda stop: stop.metrics.duration)
            for here in of_rail.values()
        }
        for name, of_rail in rails.items()
    }


def _rail(adhesion: Mapping[str, Any]) -> str:
    """Return the keys that determine friction, as text.

    Creep curves are omitted; the level that was calibrated for one of them is included.
    """
    level = adhesion.get("calibrated", {}).get(adhesion["polach"].get("name"), 1.0)
    patches = [{key: patch[key] for key in patch if key != "polach"} for patch in adhesion.get("patch", ())]
    rest = {key: adhesion[key] for key in adhesion if not key.startswith(("polach", "calibrated"))}
    return json.dumps([level, rest | {"patch": patches}], sort_keys=True)


def _variants(here: Sequence[Stop], rails: Sequence[Sequence[Stop]]) -> str:
    parts: list[str] = []
    for axis in here[0].variants:
        here_only = list(dict.fromkeys(stop.variants.get(axis, "") for stop in here))
        others = {stop.variants.get(axis, "") for rail in rails if rail is not here for stop in rail}
        if others and others.isdisjoint(here_only):
            more = f" and {len(here_only) - 2} more" if len(here_only) > 3 else ""
            parts.append(", ".join(here_only[: 2 if more else 3]).replace("_", " ") + more)
    return "; ".join(parts) or here[0].title


def adhesion_figure(sbc: Stop, seeking: Stop) -> Figure:
    """Return a figure of the adhesion of the first wheelset: with SBC and peak seeking, estimated, and the maximum in
    both stops.

    Source of the layout: Schwarz, Posielek and Goetjes, Fig. 4.
    """
    slide, seek = sbc.trace, seeking.trace
    drawing, panel = style.panels(10, 4.8)
    draw_adhesion(panel, {"SBC, two-state": slide, _SEEKING: seek}, seeking.inputs["limits"]["alpha_max"])
    if "estimate_adhesion" in seek:
        panel.plot(
            seek["time"].values,
            seek["estimate_adhesion"].values[:, 0],
            color=palette.VERMILION,
            linewidth=1.2,
            linestyle=(0, (1, 1.6)),
            label=f"{_SEEKING}, estimated",
        )
    style.dress(
        panel,
        x="time since the brake demand [s]",
        y="adhesion of wheelset 1",
        title=f"{seeking.title}, actuation {seeking.inputs['actuation']['kind']}, "
        f"sensors {seeking.inputs['sensors']['kind']}: "
        f"{sbc.distance_text} with SBC, {seeking.distance_text} with {_SEEKING}",
    )
    panel.set_ylim(0, None)
    style.legend(panel, ncols=6, loc="upper center", bbox_to_anchor=(0.5, -0.12))
    return drawing


_CONTROLLER_COLOURS = {
    kind: palette.lighter(getattr(palette, shown["colour"]), shown.get("lighter", 0))
    for kind, shown in CONTROLLERS.items()
    if "colour" in shown
}

_MAX_BARS = 9
"""Maximum number of cases with a panel each."""


_COLUMNS = 3
"""Maximum number of panels in a line."""


_WIDTHS = (8.0, 10.0, 12.0)
"""Width of a figure by its number of columns [inches]."""


_BAR, _LEAST = 0.22, 1.55
"""Height of a bar with its gap, and of the lowest panel [inches]."""


_MAX_CASES = 60
"""Maximum number of lines in a figure."""


_MARKERS = "osD^v<>P*X"


_EDGE: Mapping[str, Any] = {"markeredgecolor": palette.BLACK, "markeredgewidth": 0.5}


_LINE, _HEADING = 0.27, 0.42  # inches


_FEWEST = 6  # lines


_DISTANCE_TICKS = (100, 150, 200, 300, 500, 700, 1000, 1500, 2000, 3000)  # m


_MAX_TICKS = 20
"""Maximum number of named values along the axis of a sweep."""


def distance_figure(frame: Frame) -> Figure:
    """Return a figure of the braking distances of each scenario and controller, with the published ones as marks.

    A panel of bars for each case if they are few, else a line for each case, else the distribution over the cases of a
    scenario.
    """
    cases = frame["label"].nunique()
    if cases > _MAX_CASES:
        return distribution_figure(distributions_of(over_cases(frame)), of="stop")
    return (_bars_figure if cases <= _MAX_BARS else _cases_figure)(frame, _bar_colours(frame))


def _bars_figure(frame: Frame, colours: Mapping[str, str]) -> Figure:
    """Return a figure with a panel for each case and setting, as high as its bars, each of which has its name.

    Args:
        frame: Stops; one without standstill has no bar.
        colours: Name of a controller → colour.
    """
    settings = list(groups_of(frame, SETTING))
    axis, names = short_names(frame)
    # Lines of panels: cases of one setting and with the same controllers, whose names are at the left of the line.
    lines: list[tuple[str, list[str], dict[str, Frame]]] = []
    for (actuation, sensors, polach), of_setting in settings:
        title = f"actuation {actuation}, sensors {sensors},\ncreep curve {polach}\n" if len(settings) > 1 else ""
        by_label = groups_of(of_setting, ("label",))
        alike = gather((frozenset(stops["controller_label"]), (label, stops)) for (label,), stops in by_label)
        for controllers, of_line in alike.items():
            order = [name for name in colours if name in controllers]
            for first in range(0, len(of_line), _COLUMNS):
                lines.append((title, order, dict(of_line[first : first + _COLUMNS])))
    columns = max(len(cases) for _, _, cases in lines)
    heights = [max(_LEAST, _BAR * len(order)) for _, order, _ in lines]
    heading = 0.45 if len(settings) == 1 else 0.8
    drawing = style.figure(_WIDTHS[columns - 1], sum(heights) + (0.3 + heading) * len(lines))
    grid = drawing.subplots(len(lines), columns, squeeze=False, height_ratios=heights)
    longest = frame["distance"].max()
    for panels, (title, order, cases) in zip(grid, lines, strict=True):
        for panel in panels[len(cases) :]:
            panel.remove()
        for panel, (label, stops) in zip(panels, cases.items(), strict=False):
            case = names[label].replace("\n", ", ")
            case = f"{axis} {case}" if axis and ", " not in axis else case
            style.dress(panel, x=FIGURES["distance"].axis, title=title + case)
            panel.grid(visible=False, axis="y")
            panel.set_xlim(0, 1.02 * longest)
            panel.set_ylim(len(order) - 0.5, -0.5)
            panel.tick_params(axis="y", length=0)
            panel.set_yticks(range(len(order)), order if panel is panels[0] else [""] * len(order), fontsize=8.5)
            for row in stops.itertuples():
                _draw_bar(panel, row, order.index(row.controller_label), colours[row.controller_label])
    return drawing


def _draw_bar(panel: Axes, row: Any, line: int, colour: str) -> None:
    """Draw a distance with its number, and the published distance as a mark."""
    if isfinite(row.distance):
        panel.barh([line], [row.distance], 0.8, color=colour)
        panel.annotate(
            f"{row.distance:.0f}", (row.distance, line), ha="right", va="center", fontsize=8, xytext=(-3, 0),
            textcoords="offset points", color="white" if colour in palette.DARK else palette.BLACK,
        )  # fmt: skip
    if isfinite(row.paper_distance):
        panel.plot([row.paper_distance] * 2, [line - 0.45, line + 0.45], color=palette.BLACK, linewidth=2.2)


def _bar_colours(frame: Frame) -> dict[str, str]:
    """Return name of each controller → colour: that of its kind, lighter for each further one of the same kind."""
    kinds = dict(zip(frame["controller_label"], frame["controller"], strict=True))
    order = [*_CONTROLLER_COLOURS, *dict.fromkeys(kinds.values())]
    colours: dict[str, str] = {}
    for name in sorted(kinds, key=lambda name: order.index(kinds[name])):
        alike = sum(kinds[other] == kinds[name] for other in colours)
        colours[name] = palette.lighter(_CONTROLLER_COLOURS.get(kinds[name], palette.GREEN), alike)
    return colours


def _cases_figure(frame: Frame, colours: Mapping[str, str]) -> Figure:
    """Return a figure of the distances of each case with its friction, and their change against published SBC.

    Args:
        frame: Stops; one without standstill is a cross at the right edge of both panels.
        colours: Name of a controller → colour.
    """
    has_one_scenario = frame["scenario"].nunique() == 1
    families: dict[tuple[str, str, str], dict[str, list[Any]]] = {}
    for setting, stops in groups_of(frame, SETTING):
        for row in stops.itertuples():
            name = (row.case if has_one_scenario and row.case else row.label).replace("_", " ")
            name = f"{name}, μ₀ {row.friction}" if row.friction else name
            families.setdefault(setting, {}).setdefault(name, []).append(row)
    # No panel is so low that a page would stretch the figure.
    heights = [_HEADING / _LINE + max(len(cases), _FEWEST) for cases in families.values()]
    drawing = style.figure(12, 1.4 + _LINE * sum(heights))
    grid = drawing.subplots(len(families), 2, sharex="col", squeeze=False, height_ratios=heights, width_ratios=(3, 2))
    looks: dict[str, dict[str, Any]] = {
        name: {"color": colour, "marker": _MARKERS[number % len(_MARKERS)], "markersize": 6.5, "linestyle": ""}
        for number, (name, colour) in enumerate(colours.items())
    }
    before = ("", "")
    for (metres, changes), ((actuation, sensors, polach), cases) in zip(grid, families.items(), strict=True):
        equipment = f", actuation {actuation}, sensors {sensors}" if before != (actuation, sensors) else ""
        before = (actuation, sensors)
        style.dress(metres, title=f"creep curve {polach.replace('_', ' ')}{equipment}")
        style.dress(changes)
        changes.axvline(0.0, color=palette.BLACK, linewidth=0.9)
        for panel, names in ((metres, list(cases)), (changes, [""] * len(cases))):
            panel.set_ylim(len(cases) - 0.5, -0.5)
            panel.set_yticks(range(len(cases)), names, fontsize=9)
        for line, row in ((line, row) for line, case in enumerate(cases.values()) for row in case):
            _draw_case(row, line, metres, changes, looks[row.controller_label])
    metres, changes = grid[-1]
    metres.set_xscale("log")
    metres.set_xticks(_DISTANCE_TICKS, [f"{tick}" for tick in _DISTANCE_TICKS])
    metres.xaxis.set_minor_locator(NullLocator())
    metres.set_xlim(0.95 * frame["distance"].min(), 1.05 * frame["distance"].max())
    metres.set_xlabel(FIGURES["distance"].axis)
    changes.set_xlabel("change against the published SBC [%]")
    marks = [Line2D([], [], **look, **_EDGE) for look in looks.values()]
    marks.append(Line2D([], [], color=palette.BLACK, marker="x", linestyle=""))
    drawing.legend(marks, [*colours, "no standstill"], ncols=3, fontsize=9, loc="outside upper left", frameon=False)
    return drawing


def _draw_case(row: Any, line: int, metres: Axes, changes: Axes, look: Mapping[str, Any]) -> None:
    if isnan(row.distance):
        for panel in (metres, changes):
            cross: dict[str, Any] = {**look, "transform": panel.get_yaxis_transform(), "marker": "x"}
            panel.plot(1.0, line, clip_on=False, **cross)
        return
    metres.plot(row.distance, line, **look, **_EDGE)
    if isfinite(row.reduction_vs_sbc):
        changes.plot(-100 * row.reduction_vs_sbc, line, **look, **_EDGE)


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
    if len(lines) > len(palette.LINES):
        for line in lines:
            panel.plot(places, line, ".", color=palette.GREY, ms=3)
        common = lines[np.isfinite(lines).all(axis=1)]
        if len(common):
            label = f"median over {', '.join(others)}: {len(common)} of {len(lines)}, with a standstill everywhere"
            panel.plot(places, np.median(common, axis=0), "o-", color=palette.BLUE, label=label)
    else:
        labels = _line_labels([(name, axes[name]) for name in names if name != longest])
        for line, label, colour in zip(lines, labels, palette.LINES, strict=False):
            panel.plot(places, line, "o-", color=colour, ms=4, linewidth=1.2, label=label or None)
    shown = places[:: 1 + (len(places) - 1) // _MAX_TICKS]
    texts = [_value_text(axes[longest][place]) for place in shown]
    panel.set_xticks(shown, texts, rotation=30 if max(map(len, texts)) > 8 else 0)
    style.dress(panel, x=longest, y=FIGURES["distance"].axis)
    if others:
        style.legend(panel)
    return drawing


def _line_labels(axes: Sequence[tuple[str, Sequence[Any]]]) -> list[str]:
    labels = [""]
    for name, values in axes:
        more = [f"{name} {_value_text(value)}" if len(values) > 1 else "" for value in values]
        labels = [", ".join(filter(None, (label, axis))) for label in labels for axis in more]
    return labels


def _value_text(value: Any) -> str:
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= 24 else f"{text[:23]}…"


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
        panels[0].set_yticks(range(len(here)), [_name_of_draws(one, of) for one in here])
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


def _name_of_draws(one: Any, of: str) -> str:
    missing = one.draws - one.stood
    return one.controller_label + (
        f"\n{missing} {of}{'s' if missing > 1 else ''} without standstill" if missing else ""
    )


_ROW: Final = 0.36
"""Height of a row [inches]."""


_LOWEST: Final = 1.7
"""Height of the rows of a panel below which a page would draw it lower than 150 pixels [inches]."""


FIGURE_MEANING: Final = (
    "In the figure, dots are ideal and triangles service equipment, solid lines are ranges of repeated stops, and "
    "dashed lines published distances; the further left, the shorter the stop."
)

# Shape and filling distinguish equipment in print, too.
_MARKS: Final[Mapping[str, Mapping[str, Any]]] = {
    "ideal": {"marker": "o", "color": palette.BLUE},
    "service": {"marker": "^", "color": palette.GREEN},
}
_OFFSETS: Final = {"ideal": -0.14, "service": 0.14}
"""Place of the marks of an equipment in a row, so that neither hides the other [rows]."""


def overview_figure(overview: Frame, *, width: float = 10.9, is_narrow: bool = False) -> Figure:
    """Return a figure with a panel for each case, and in it a row for each controller.

    A mark is the distance with an equipment, a line the range of repeats, a dashed line the published distance.

    Args:
        overview: Rows of `railgrip.report.distances.overview_of`, or of some controllers.
        width: Width [inches].
        is_narrow: Whether panels are below each other, for a screen of the width of a hand.
    """
    cases = [case for case in overview["place"].cat.categories if (overview["place"] == case).any()]
    labels = [str(label) for label in overview["controller_label"].unique()]
    count, height = len(cases), max(_LOWEST, _ROW * len(labels))
    if is_narrow:
        drawing, grid = style.panels(3.2, count * (height + 0.85), count, 1, squeeze=False)
    else:
        drawing, grid = style.panels(width, height + 1.15, 1, count, sharey=True, squeeze=False)
    low, high = _ends(overview)
    for panel, case in zip(grid.flat, cases, strict=True):
        style.dress(panel, title=case, x=FIGURES["distance"].axis if not is_narrow or case == cases[-1] else "")
        panel.grid(visible=False, axis="y")
        panel.set_xlim(low, high)
        # Round numbers that are not cut off at the right edge.
        ticks = MaxNLocator(4, steps=[1, 2, 5, 10]).tick_values(low, high)
        panel.set_xticks([tick for tick in ticks if low <= tick <= high - 0.1 * (high - low)])
        panel.set_ylim(len(labels) - 0.5, -0.5)
        panel.tick_params(axis="y", length=0)
        for one in overview[overview["place"] == case].itertuples():
            _draw_stated(panel, labels.index(str(one.controller_label)), one)
        if is_narrow or panel is grid.flat[0]:
            texts = [textwrap.fill(label, 22) for label in labels]
            panel.set_yticks(range(len(labels)), texts, fontsize=8.5)
    keys: dict[str, dict[str, Any]] = {"published": {"color": palette.BLACK, "linestyle": "--"}} | {
        f"{origin} equipment": {**mark, "linestyle": "-"} for origin, mark in _MARKS.items()
    }
    handles = [Line2D([], [], **look) for look in keys.values()]
    columns = 1 if is_narrow else len(keys)
    drawing.legend(handles, list(keys), loc="outside lower center", ncols=columns, fontsize=9, frameon=False)
    return drawing


def _draw_stated(panel: Axes, row: int, one: Any) -> None:
    """Draw a distance of an overview into its row."""
    if one.origin == "published":
        panel.plot([one.distance] * 2, [row - 0.42, row + 0.42], "--", color=palette.BLACK, linewidth=1.4)
    elif isfinite(one.distance):
        y, mark = row + _OFFSETS[one.origin], _MARKS[one.origin]
        if one.stated.ends is not None:
            panel.plot(one.stated.ends, [y, y], "-", color=mark["color"], linewidth=1.6)
        panel.plot([one.distance], [y], markersize=5.5, **mark)


def _ends(overview: Frame) -> tuple[float, float]:
    ends = (end for stated in overview["stated"] for end in stated.ends or ())
    values = [value for value in (*overview["distance"], *ends) if isfinite(value)]
    margin = 0.06 * (max(values) - min(values)) or 1.0
    return min(values) - margin, max(values) + margin


_MAX_STOPS = 40
"""Maximum number of stops of two campaigns that are compared in a figure."""


def stops_figure(distances: Frame) -> Figure:
    """Return a figure of the stops of campaigns: distances, and the paired differences from those of the first.

    Args:
        distances: Distances [m] with a column for each campaign and a row for each stop; NaN without standstill. Only
            the stops with the largest differences are drawn if there are many.
    """
    first, *others = distances.columns
    differences = distances[others].sub(distances[first], axis=0).dropna(how="all")
    largest = differences.abs().max(axis=1).sort_values(ascending=False, kind="stable").index[:_MAX_STOPS]
    drawn = differences[differences.index.isin(largest)]
    drawing, (metres, changes) = style.panels(10, 1.4 + 0.24 * len(drawn), columns=2, sharey=True)
    places = np.arange(len(drawn))
    for number, letter in enumerate(distances):
        look = {"color": palette.LINES[number % len(palette.LINES)], "linestyle": "", "markersize": 5}
        marker = "o" if letter == first else "D"
        metres.plot(distances.loc[drawn.index, letter], places, marker=marker, label=letter, **look)
        if letter != first:
            changes.plot(drawn[letter], places, marker=marker, label=f"{letter} − {first}", **look)
    metres.set_yticks(places, drawn.index, fontsize=8)
    metres.invert_yaxis()
    changes.axvline(0.0, color=palette.BLACK, linewidth=0.8)
    few = f" (the {len(drawn)} largest of {len(differences)})" if len(drawn) < len(differences) else ""
    style.dress(metres, x="braking distance [m]", title="Each stop")
    style.dress(changes, x=f"longer than {first} [m]", title=f"Difference of each stop{few}")
    drawing.legend(*metres.get_legend_handles_labels(), loc="outside upper right", ncols=9, fontsize=8, frameon=False)
    return drawing
