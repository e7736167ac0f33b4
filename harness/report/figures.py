"""Figures of a campaign: the friction of its scenarios, the used adhesion, the distances."""

import json
from collections.abc import Mapping, Sequence
from itertools import cycle
from math import ceil, isfinite
from typing import Any

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from railgrip.report import palette, style
from railgrip.report.cases_figure import MAX_CASES, cases_figure
from railgrip.report.distribution import distributions_of, over_cases
from railgrip.report.distribution_figure import distribution_figure
from railgrip.report.reference import label
from railgrip.report.results import Result
from railgrip.report.row import Row, short_names
from railgrip.trace.stop import StopRecord

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

_STOP_MARGINS = {"left": 0.055, "right": 0.875, "wspace": 0.06, "hspace": 0.1}

_MAX_COLUMNS = 8
"""Maximum number of groups side by side, so that panels stay readable; those of a longer train follow below."""

_MAX_BARS = 9
"""Maximum number of scenarios side by side, so that a number fits on each bar."""


def friction_figure(stops: Sequence[Result]) -> Figure:
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
            trace = stop.record.trace()
            mu0, time = trace["mu0"].values, trace["time"].values
            if len(rails) == 1:
                draw_wheelsets(panel, time, mu0)
            else:
                panel.plot(time, mu0[:, 0], color=colour, linewidth=1.2, label=name)
        titles = {_title(stop) for stop in rails.values()}
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


def _rails(stops: Sequence[Result]) -> dict[str, dict[str, Result]]:
    """Return scenario → name of the rail → longest stop on it; rails are named by the variants that only they have."""
    rails: dict[str, dict[str, list[Result]]] = {}
    for stop in stops:
        scenario = stop.record.scenario
        rails.setdefault(scenario["name"], {}).setdefault(_rail(scenario["adhesion"]), []).append(stop)
    return {
        name: {
            _variants(here, list(of_rail.values())): max(here, key=lambda stop: stop.record.metrics.duration)
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


def _variants(here: Sequence[Result], rails: Sequence[Sequence[Result]]) -> str:
    parts: list[str] = []
    for axis in here[0].variants:
        here_only = list(dict.fromkeys(stop.variants.get(axis, "") for stop in here))
        others = {stop.variants.get(axis, "") for rail in rails if rail is not here for stop in rail}
        if others and others.isdisjoint(here_only):
            more = f" and {len(here_only) - 2} more" if len(here_only) > 3 else ""
            parts.append(", ".join(here_only[: 2 if more else 3]).replace("_", " ") + more)
    return "; ".join(parts) or _title(here[0])


def adhesion_figure(sbc: Result, abc: Result) -> Figure:
    """Return a figure of the adhesion of the first wheelset: with SBC and ABC, estimated, and the maximum in both
    stops.

    Source of the layout: Schwarz, Posielek and Goetjes, Fig. 4.
    """
    slide, seek = sbc.record.trace(), abc.record.trace()
    drawing, panel = style.panels(10, 4.8)
    draw_adhesion(panel, {"SBC, two-state": slide, "ABC": seek}, abc.record.scenario["limits"]["alpha_max"])
    if "estimate_adhesion" in seek:
        panel.plot(
            seek["time"].values,
            seek["estimate_adhesion"].values[:, 0],
            color=palette.VERMILION,
            linewidth=1.2,
            linestyle=(0, (1, 1.6)),
            label="ABC, estimated",
        )
    style.dress(
        panel,
        x="time since the brake demand [s]",
        y="adhesion of wheelset 1",
        title=f"{_title(abc)}, actuation {abc.record.scenario['actuation']['kind']}, "
        f"sensors {abc.record.scenario['sensors']['kind']}: "
        f"{_distance(sbc.record)} with SBC, {_distance(abc.record)} with ABC",
    )
    panel.set_ylim(0, None)
    style.legend(panel, ncols=6, loc="upper center", bbox_to_anchor=(0.5, -0.12))
    return drawing


def draw_adhesion(panel: Axes, traces: Mapping[str, xarray.Dataset], limit: float, wheelset: int = 0) -> None:
    """Draw adhesion of a wheelset and the greatest possible in a stop with SBC and one with ABC, and the limit.

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


def distance_figure(rows: Sequence[Row]) -> Figure:
    """Return a figure of the braking distances of each scenario and controller, with the published ones as marks.

    A bar for each distance if its number fits on the bar, else a line for each case, else the distribution over the
    cases of a scenario.
    """
    cases = len({row.label for row in rows})
    if _MAX_BARS < cases <= MAX_CASES:
        return cases_figure(rows, _bar_colours(rows))
    if cases > MAX_CASES:
        return distribution_figure(distributions_of(over_cases(rows)), of="stop")
    settings = list(dict.fromkeys((row.actuation, row.sensors, row.polach) for row in rows))
    scenarios = list(dict.fromkeys(row.label for row in rows))
    colours = _bar_colours(rows)
    drawing = style.figure(max(10.0, 0.42 * len(scenarios) * len(colours)), 3.2 * len(settings))
    panels = drawing.subplots(len(settings), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    width = 0.8 / len(colours)
    for panel, setting in zip(panels, settings, strict=True):
        here = {
            (row.label, row.controller_label): row
            for row in rows
            if (row.actuation, row.sensors, row.polach) == setting and row.distance_m is not None
        }
        for number, (controller, colour) in enumerate(colours.items()):
            bars = [(k, here[name, controller]) for k, name in enumerate(scenarios) if (name, controller) in here]
            places = [k + (number - (len(colours) - 1) / 2) * width for k, _ in bars]
            lengths = [row.distance_m or 0.0 for _, row in bars]
            panel.bar(places, lengths, 0.92 * width, color=colour, label=controller)
            for place, length, (_, row) in zip(places, lengths, bars, strict=True):
                panel.annotate(
                    f"{length:.0f}", (place, length), ha="center", va="top", fontsize=8, xytext=(0, -3),
                    textcoords="offset points", color="white" if colour in palette.DARK else palette.BLACK,
                )  # fmt: skip
                if row.paper_distance_m is not None:
                    half = 0.46 * width
                    panel.plot(
                        [place - half, place + half], [row.paper_distance_m] * 2, color=palette.VERMILION, linewidth=2.2
                    )
        actuation, sensors, polach = setting
        style.dress(
            panel,
            y="braking distance [m]",
            title=f"actuation {actuation}, sensors {sensors}, creep curve {polach}",
        )
        panel.grid(visible=False, axis="x")
    axes, names = short_names(rows)
    panels[-1].set_xticks(range(len(scenarios)), [names[label] for label in scenarios])
    panels[-1].set_xlabel(axes if len(scenarios) > 1 else "")
    panels[0].plot([], [], color=palette.VERMILION, linewidth=2.2, label="published")
    style.legend(panels[0], ncols=4, loc="lower left", bbox_to_anchor=(0, 1.16))
    return drawing


def _bar_colours(rows: Sequence[Row]) -> dict[str, str]:
    """Return name of each controller → colour: that of its kind, lighter for each further one of the same kind."""
    kinds = {row.controller_label: row.controller for row in rows}
    order = [*_CONTROLLER_COLOURS, *dict.fromkeys(kinds.values())]
    colours: dict[str, str] = {}
    for name in sorted(kinds, key=lambda name: order.index(kinds[name])):
        alike = sum(kinds[other] == kinds[name] for other in colours)
        colours[name] = palette.lighter(_CONTROLLER_COLOURS.get(kinds[name], palette.GREEN), alike)
    return colours


def stop_figure(stop: Result) -> Figure:
    """Return the figure of a stop whose samples are in a file; see `signals_figure`."""
    return signals_figure(stop, stop.record.trace())


def signals_figure(stop: Result, trace: xarray.Dataset) -> Figure:
    """Return the figure of one stop: a column for each group, rows from speed to pressure.

    A train of many groups continues below, in bands with the same axes.

    The rows are speeds of train and wheelset; slip and the slip of maximum adhesion; adhesion with its estimate ±2σ and
    the maximum; the same for the pad friction; cylinder pressure. Signals that a foreign plant does not output, and
    that are not estimated, have no row.
    """
    metrics, time = stop.record.metrics, trace["time"].values
    rows = {
        quantity: draw
        for quantity, draw in _ROWS.items()
        if any(_has_values(trace, name) for name in _SIGNALS[quantity])
    }
    outside = {"adhesion": metrics.adhesion_outside, "pad friction": metrics.pad_friction_outside}
    drawing, panels = _columns(trace.sizes["group"], len(rows))
    for row, (quantity, draw) in zip(panels, rows.items(), strict=True):
        for group, panel in enumerate(row):
            draw(panel, time, trace, group)
            shares = outside.get(quantity)
            if shares is not None and isfinite(shares[group]):
                panel.text(0.98, 0.96, f"{100 * shares[group]:.0f} % outside ±2σ", transform=panel.transAxes,
                           ha="right", va="top", fontsize=8)  # fmt: skip
            panel.grid(visible=True, color="#DDDDDD", linewidth=0.6)
            panel.spines[["top", "right"]].set_visible(False)
            if panel.get_subplotspec().is_first_col():
                panel.set_ylabel(quantity)
        if quantity in _FROM_ZERO:
            # Setting the limits of a panel freezes them, so this comes after all lines.
            top = max(panel.get_ylim()[1] for panel in row)
            for panel in row:
                panel.set_ylim(0, top)
        style.legend(row[_wide(len(row)) - 1], loc="center left", bbox_to_anchor=(1.0, 0.5))
    for group in range(trace.sizes["group"]):
        panels[0, group].set_title(f"group {group + 1}", fontsize=10)
        panels[-1, group].set_xlabel("time [s]")
        panels[0, group].set_xlim(0, time[-1])
    scenario = stop.record.scenario
    utilisation_text = (
        f", {100 * metrics.utilisation:.1f} % of the possible adhesion used" if isfinite(metrics.utilisation) else ""
    )
    consistency = "" if metrics.nis_ratio is None else f"; median NIS {metrics.nis_ratio:.2g} of the expected one"
    drawing.suptitle(
        f"{_title(stop)}: {label(scenario)}, actuation "
        f"{scenario['actuation']['kind']}, sensors {scenario['sensors']['kind']}; {_distance(stop.record)} in "
        f"{metrics.duration:.1f} s{utilisation_text}{consistency}",
        x=0.01, y=1 - 0.22 / drawing.get_figheight(), ha="left", fontsize=11,
    )  # fmt: skip
    return drawing


def _distance(record: StopRecord) -> str:
    """Return the braking distance for readers; the distance travelled if the train did not stop."""
    if record.braking_distance is None:
        return f"no standstill: {record.metrics.distance_travelled:.1f} m travelled"
    return f"{record.braking_distance:.1f} m"


def _wide(groups: int) -> int:
    return ceil(groups / ceil(groups / _MAX_COLUMNS))


def _columns(groups: int, rows: int) -> tuple[Figure, np.ndarray]:
    bands = ceil(groups / _MAX_COLUMNS)
    wide = _wide(groups)
    above, below, between, block = 0.77, 0.5, 0.85, 0.03 + 1.94 * rows  # inches
    height = above + bands * block + (bands - 1) * between + below
    drawing = style.figure(14, height, _STOP_MARGINS)
    parts: list[np.ndarray] = []
    for band in range(bands):
        top = above + band * (block + between)
        grid = drawing.add_gridspec(
            rows, wide, top=1 - top / height, bottom=1 - (top + block) / height, **_STOP_MARGINS
        )
        panels = grid.subplots(sharex=True, sharey="row", squeeze=False)
        for spare in panels[:, groups - band * wide :].flat:
            spare.remove()
        parts.append(panels[:, : groups - band * wide])
    return drawing, np.hstack(parts)


def _title(stop: Result) -> str:
    """Return the name of a scenario, for a random rail with its seed, since it is one draw of many."""
    scenario = stop.record.scenario
    name = scenario["name"].replace("_", " ")
    return f"{name}, seed {scenario['seed']}" if scenario["adhesion"]["kind"] == "random" else name


def _has_values(trace: xarray.Dataset, name: str) -> bool:
    return name in trace and bool(np.isfinite(trace[name].values).any())


def _draw_speed(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, group: int) -> None:
    train = style.KMH * trace["speed"].values
    panel.plot(time, train, color=palette.BLACK, linewidth=1.4, label="train")
    if _has_values(trace, "slip"):
        wheelset = train * (1 - trace["slip"].values[:, group])
        panel.plot(time, wheelset, color=palette.BLUE, linewidth=0.9, label="wheelset")


def _draw_slip(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, group: int) -> None:
    panel.plot(time, 100 * trace["slip"].values[:, group], color=palette.BLUE, linewidth=0.9, label="slip")
    if _has_values(trace, "peak_slip"):
        best = 100 * trace["peak_slip"].values[:, group]
        panel.plot(time, best, color=palette.BLACK, linewidth=1.2, label="of greatest adhesion")
    # The optimum slip is 1 to 10 %, a locked wheel 100 %: only a logarithmic axis resolves both.
    panel.set_yscale("log")
    panel.set_ylim(0.1, 120)
    panel.set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
    panel.yaxis.set_minor_locator(NullLocator())


def _draw_adhesion(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, group: int) -> None:
    # A plant that does not output its brakes has no bound.
    if _has_values(trace, "peak_adhesion"):
        best = trace["peak_adhesion"].values[:, group]
        panel.plot(time, best, color=palette.BLACK, linewidth=1.2, label="greatest possible")
    _draw_truth_and_estimate(panel, time, trace, "group_adhesion", "estimate_adhesion", group)


def _draw_friction(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, group: int) -> None:
    _draw_truth_and_estimate(panel, time, trace, "pad_friction", "estimate_pad_friction", group)
    # The estimate before the first brake application may be very uncertain; it must not determine the scale.
    panel.set_ylim(0.2, 0.6)


def _draw_pressure(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, group: int) -> None:
    pressure = trace["cylinder_pressure"].values[:, group] / 1e5
    panel.plot(time, pressure, color=palette.BLUE, linewidth=0.9, label="cylinder")


def _draw_truth_and_estimate(
    panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, truth: str, belief: str, group: int
) -> None:
    if _has_values(trace, truth):
        panel.plot(time, trace[truth].values[:, group], color=palette.BLUE, linewidth=1.0, label="true")
    if _has_values(trace, belief):
        _draw_estimate(panel, time, trace, belief, group)


_ROWS = {
    "speed [km/h]": _draw_speed,
    "slip [%]": _draw_slip,
    "adhesion": _draw_adhesion,
    "pad friction": _draw_friction,
    "cylinder pressure [bar]": _draw_pressure,
}

_FROM_ZERO = {"adhesion", "cylinder pressure [bar]"}

_SIGNALS = {
    "speed [km/h]": ("speed",),
    "slip [%]": ("slip",),
    "adhesion": ("group_adhesion", "estimate_adhesion"),
    "pad friction": ("pad_friction", "estimate_pad_friction"),
    "cylinder pressure [bar]": ("cylinder_pressure",),
}


def _draw_estimate(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, name: str, group: int) -> None:
    mean = trace[name].values[:, group]
    if f"{name}_sd" in trace:
        half_width = 2 * trace[f"{name}_sd"].values[:, group]
        style.band(panel, time, mean - half_width, mean + half_width, palette.ORANGE, 0.3, label="±2σ")
    panel.plot(time, mean, color=palette.VERMILION, linewidth=1.0, linestyle=(0, (2, 1.2)), label="estimated")
