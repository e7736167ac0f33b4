"""Figures of campaigns and sweeps: friction of scenarios, used adhesion, distances."""

import json
from collections.abc import Mapping, Sequence
from itertools import cycle
from math import isfinite, isnan
from typing import Any

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from railgrip.report import palette, style
from railgrip.report.distribution import distributions_of, over_cases
from railgrip.report.distribution_figure import distribution_figure
from railgrip.report.frame import SETTING, Frame, groups_of, short_names
from railgrip.report.stop import Stop
from railgrip.trace.metrics import FIGURES

_CONTROLLER_COLOURS = {
    "full_brake": palette.GREY,
    "slip_two_state": palette.BLUE,
    "slip_three_state": palette.SKY,
    "slip_two_state_read": palette.GREEN,
    "slip_three_state_read": palette.lighter(palette.GREEN, 2),
    "slip_two_state_estimated": palette.VERMILION,
    "slip_three_state_estimated": palette.lighter(palette.VERMILION, 2),
    "adhesion_based": palette.ORANGE,
    "adhesion_literal": palette.PURPLE,
    "slope_seeking": palette.lighter(palette.ORANGE, 2),
    "ideal_bound": palette.BLACK,
}


_RAIL_COLOURS = (*palette.LINES, palette.GREY)

_SEEKING = "peak seeking"

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
        style.dress(panel, y="maximum friction $\\mu_0$", title=", ".join(sorted(titles)))
        panel.set_ylim(bottom=0)
        panel.set_xlim(0, None)
        if len(rails) > 1:
            style.legend(panel, loc="center left", bbox_to_anchor=(1.0, 0.5))
    if all(len(rails) == 1 for rails in scenarios.values()):
        panels[0].legend(ncols=3, fontsize=8, loc="lower right", framealpha=0.9)
    panels[-1].set_xlabel("time since the brake demand [s]")
    return drawing


def draw_wheelsets(panel: Axes, time: np.ndarray, mu0: np.ndarray) -> None:
    """Draw maximum friction over time, shape (samples, wheelsets), from blue, the first wheelset, to purple."""
    colours = palette.lead_to_trail(mu0.shape[1])
    for wheelsets in style.alike(list(mu0.T)):
        axles = f"wheelset{'s' if len(wheelsets) > 1 else ''} {style.one_based(wheelsets)}"
        panel.plot(time, mu0[:, wheelsets[0]], color=colours[wheelsets[0]], linewidth=1.4, label=axles)


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


def draw_adhesion(panel: Axes, traces: Mapping[str, xarray.Dataset], limit: float, wheelset: int = 0) -> None:
    """Draw adhesion of a wheelset and the greatest possible in a stop with SBC and one with another law, and the limit.

    The greatest possible is that of the rail at the speed of each stop, before the operator's limit.

    Args:
        wheelset: Zero-based number.
    """
    colours = ((palette.BLUE, palette.GREY), (palette.ORANGE, palette.BLACK))
    for (name, trace), (colour, _) in zip(traces.items(), colours, strict=True):
        panel.plot(trace["time"].values, trace["adhesion"].values[:, wheelset], color=colour, linewidth=0.9, label=name)
    for (name, trace), (_, colour) in zip(traces.items(), colours, strict=True):
        if "peak_adhesion" not in trace:
            continue  # a plant that does not output its brakes has no bound
        greatest = trace["peak_adhesion"].values[:, int(trace["group_of_wheelset"].values[wheelset]) - 1]
        name = f"greatest possible, {name.partition(',')[0]}"
        # Wide and in the background, so that adhesion that has reached it stays visible.
        panel.plot(trace["time"].values, greatest, color=colour, linewidth=2.6, label=name, zorder=1.5)
    panel.axhline(limit, color=palette.VERMILION, linewidth=1.0, linestyle="--", label=f"limit {limit:g}")
    panel.set_xlim(0, max(float(trace["time"].values[-1]) for trace in traces.values()))


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
        alike: dict[frozenset[str], dict[str, Frame]] = {}
        for (label,), stops in groups_of(of_setting, ("label",)):
            alike.setdefault(frozenset(stops["controller_label"]), {})[label] = stops
        for controllers, of_line in alike.items():
            order = [name for name in colours if name in controllers]
            labels = list(of_line)
            for first in range(0, len(labels), _COLUMNS):
                lines.append((title, order, {label: of_line[label] for label in labels[first : first + _COLUMNS]}))
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
            name = _case_name(row.case if has_one_scenario and row.case else row.label, row.friction)
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


def _case_name(case: str, friction: str) -> str:
    name = case.replace("_", " ")
    return f"{name}, $\\mu_0$ {friction}" if friction else name


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
        with np.errstate(all="ignore"):
            median = np.nanmedian(lines, axis=0)
        panel.plot(places, median, "o-", color=palette.BLUE, label=f"median over {', '.join(others)}")
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
