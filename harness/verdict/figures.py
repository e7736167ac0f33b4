"""Figures over a campaign: the friction of its scenarios, the adhesion that was used, the distances."""

from collections.abc import Sequence

import numpy as np
import xarray
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from harness.record.signals import GROUPS
from harness.verdict import style
from harness.verdict.reference import CONTROLLERS
from harness.verdict.results import Result
from harness.verdict.row import Row

_CONTROLLER_COLOURS = {
    "full_brake": style.GREY,
    "slip_two_state": style.BLUE,
    "slip_three_state": style.SKY,
    "adhesion_based": style.ORANGE,
    "adhesion_literal": style.PURPLE,
    "ideal_bound": style.BLACK,
}


_STOP_MARGINS = {"left": 0.055, "right": 0.875, "bottom": 0.045, "top": 0.93, "wspace": 0.06, "hspace": 0.1}

_DARK = {"full_brake", "slip_two_state", "ideal_bound"}


def friction_figure(stops: Sequence[Result]) -> Figure:
    """Return the maximum friction over time at each wheelset, a panel for each stop (one of each scenario).

    Source of the form: Schwarz, Posielek and Goetjes, Fig. 3.
    """
    made = style.figure(9, 2.4 * len(stops))
    panels = made.subplots(len(stops), 1, sharex=True, squeeze=False)[:, 0]
    for panel, stop in zip(panels, stops, strict=True):
        trace = stop.record.trace()
        mu0, time = trace["mu0"].values, trace["time"].values
        colours = style.lead_to_trail(mu0.shape[1])
        for wheelsets in style.alike(list(mu0.T)):
            label = f"wheelset{'s' if len(wheelsets) > 1 else ''} {style.spelled(wheelsets)}"
            panel.plot(time, mu0[:, wheelsets[0]], color=colours[wheelsets[0]], linewidth=1.4, label=label)
        style.dress(panel, y="maximum friction $\\mu_0$", title=stop.record.scenario["name"].replace("_", " "))
        panel.set_ylim(bottom=0)
        panel.set_xlim(0, None)
    panels[0].legend(ncols=3, fontsize=8, loc="lower right", framealpha=0.9)
    panels[-1].set_xlabel("time since the brake demand [s]")
    return made


def adhesion_figure(sbc: Result, abc: Result) -> Figure:
    """Return the adhesion of the first wheelset: SBC, ABC, estimated, and the greatest possible.

    Source of the form: Schwarz, Posielek and Goetjes, Fig. 4. The greatest possible adhesion is that of the ABC stop's
    rail and speed, before the operator's limit, which is a line of its own.
    """
    slide, seek = sbc.record.trace(), abc.record.trace()
    made = style.figure(10, 4.8)
    panel = made.subplots()
    time = seek["time"].values
    panel.plot(
        slide["time"].values, slide["adhesion"].values[:, 0], color=style.BLUE, linewidth=0.9, label="SBC, two-state"
    )
    panel.plot(time, seek["adhesion"].values[:, 0], color=style.ORANGE, linewidth=1.2, label="ABC")
    if "estimate_adhesion" in seek:
        panel.plot(
            time,
            seek["estimate_adhesion"].values[:, 0],
            color=style.VERMILION,
            linewidth=1.2,
            linestyle=(0, (1, 1.6)),
            label="ABC, estimated",
        )
    panel.plot(time, seek["peak_adhesion"].values[:, 0], color=style.BLACK, linewidth=1.4, label="greatest possible")
    limit = abc.record.scenario["limits"]["alpha_max"]
    panel.axhline(limit, color=style.GREY, linewidth=1.0, linestyle="--", label=f"limit {limit:g}")
    style.dress(
        panel,
        x="time since the brake demand [s]",
        y="adhesion of wheelset 1",
        title=f"{abc.record.scenario['name'].replace('_', ' ')}, actuation {abc.record.scenario['actuation']['kind']}, "
        f"sensors {abc.record.scenario['sensors']['kind']}: "
        f"{sbc.record.metrics.distance:.1f} m with SBC, {abc.record.metrics.distance:.1f} m with ABC",
    )
    panel.set_xlim(0, None)
    panel.set_ylim(0, None)
    panel.legend(ncols=5, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.12), frameon=False)
    return made


def distance_figure(rows: Sequence[Row]) -> Figure:
    """Return the braking distances of each scenario and controller, with the published ones as marks."""
    settings = list(dict.fromkeys((row.actuation, row.sensors, row.polach) for row in rows))
    scenarios = list(dict.fromkeys(row.label for row in rows))
    controllers = [name for name in _CONTROLLER_COLOURS if any(row.controller == name for row in rows)]
    made = style.figure(10, 3.2 * len(settings))
    panels = made.subplots(len(settings), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    width = 0.8 / len(controllers)
    for panel, setting in zip(panels, settings, strict=True):
        here = {
            (row.label, row.controller): row
            for row in rows
            if (row.actuation, row.sensors, row.polach) == setting and row.distance_m is not None
        }
        for number, controller in enumerate(controllers):
            found = [(k, here[name, controller]) for k, name in enumerate(scenarios) if (name, controller) in here]
            places = [k + (number - (len(controllers) - 1) / 2) * width for k, _ in found]
            lengths = [row.distance_m or 0.0 for _, row in found]
            panel.bar(
                places, lengths, 0.92 * width, color=_CONTROLLER_COLOURS[controller], label=CONTROLLERS[controller]
            )
            for place, length, (_, row) in zip(places, lengths, found, strict=True):
                panel.annotate(
                    f"{length:.0f}", (place, length), ha="center", va="top", fontsize=8, xytext=(0, -3),
                    textcoords="offset points", color="white" if controller in _DARK else style.BLACK,
                )  # fmt: skip
                if row.paper_distance_m is not None:
                    half = 0.46 * width
                    panel.plot(
                        [place - half, place + half], [row.paper_distance_m] * 2, color=style.VERMILION, linewidth=2.2
                    )
        actuation, sensors, polach = setting
        style.dress(
            panel,
            y="braking distance [m]",
            title=f"actuation {actuation}, sensors {sensors}, creep curve {polach}",
        )
        panel.grid(visible=False, axis="x")
    panels[-1].set_xticks(range(len(scenarios)), [name.replace("_", " ") for name in scenarios])
    panels[0].plot([], [], color=style.VERMILION, linewidth=2.2, label="published")
    panels[0].legend(ncols=7, fontsize=8, loc="lower left", bbox_to_anchor=(0, 1.08), frameon=False)
    return made


def stop_figure(stop: Result) -> Figure:
    """Return what an engineer asks of one stop: a column for each ω-group, rows from speed to pressure.

    Speeds of train and wheelset; slip and the slip of greatest adhesion; adhesion with its estimate ±2σ and the
    greatest possible; the same of the pad friction; cylinder pressure.
    """
    trace = stop.record.trace()
    time = trace["time"].values
    made = style.figure(14, 11, _STOP_MARGINS)
    panels = made.subplots(5, GROUPS, sharex=True, sharey="row")
    rows = (
        "speed [km/h]",
        "slip [%]",
        "adhesion",
        "pad friction",
        "cylinder pressure [bar]",
    )
    for group, column in enumerate(panels.T):
        speed, slip, adhesion, friction, pressure = column
        train = style.KMH * trace["speed"].values
        speed.plot(time, train, color=style.BLACK, linewidth=1.4, label="train")
        true_slip = trace["slip"].values[:, group]
        speed.plot(time, train * (1 - true_slip), color=style.BLUE, linewidth=0.9, label="wheelset")
        slip.plot(time, 100 * true_slip, color=style.BLUE, linewidth=0.9, label="slip")
        # A plant that does not show its brakes has no bound.
        if "peak_adhesion" in trace:
            best_slip, best = trace["peak_slip"].values[:, group], trace["peak_adhesion"].values[:, group]
            slip.plot(time, 100 * best_slip, color=style.BLACK, linewidth=1.2, label="of greatest adhesion")
            adhesion.plot(time, best, color=style.BLACK, linewidth=1.2, label="greatest possible")
        adhesion.plot(time, trace["group_adhesion"].values[:, group], color=style.BLUE, linewidth=1.0, label="true")
        friction.plot(time, trace["pad_friction"].values[:, group], color=style.BLUE, linewidth=1.0, label="true")
        for panel, name in ((adhesion, "estimate_adhesion"), (friction, "estimate_pad_friction")):
            if name in trace:
                _believed(panel, time, trace, name, group)
        pressure.plot(
            time, trace["cylinder_pressure"].values[:, group] / 1e5, color=style.BLUE, linewidth=0.9, label="cylinder"
        )
        speed.set_title(f"group {group + 1}", fontsize=10)
        pressure.set_xlabel("time [s]")
    for row, label in zip(panels, rows, strict=True):
        for panel in row:
            panel.grid(visible=True, color="#DDDDDD", linewidth=0.6)
            panel.spines[["top", "right"]].set_visible(False)
        row[0].set_ylabel(label)
        row[-1].legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    panels[0, 0].set_xlim(0, time[-1])
    # The best slip is 1 to 10 %, a locked wheel 100 %: only a logarithmic axis shows both.
    panels[1, 0].set_yscale("log")
    panels[1, 0].set_ylim(0.1, 120)
    panels[1, 0].set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
    panels[1, 0].yaxis.set_minor_locator(NullLocator())
    panels[2, 0].set_ylim(0, None)
    panels[4, 0].set_ylim(0, None)
    # The belief before the first brake application may be wide open; it must not squeeze what follows.
    panels[3, 0].set_ylim(0.2, 0.6)
    metrics, scenario = stop.record.metrics, stop.record.scenario
    made.suptitle(
        f"{scenario['name'].replace('_', ' ')}: {CONTROLLERS[scenario['controller']['kind']]}, actuation "
        f"{scenario['actuation']['kind']}, sensors {scenario['sensors']['kind']}; {metrics.distance:.1f} m in "
        f"{metrics.duration:.1f} s, {100 * metrics.utilisation:.1f} % of the possible adhesion used",
        x=0.01, ha="left", fontsize=11,
    )  # fmt: skip
    return made


def _believed(panel: style.Axes, time: np.ndarray, trace: xarray.Dataset, name: str, group: int) -> None:
    mean, spread = trace[name].values[:, group], 2 * trace[f"{name}_sd"].values[:, group]
    panel.fill_between(time, mean - spread, mean + spread, color=style.ORANGE, alpha=0.3, linewidth=0, label="±2σ")
    panel.plot(time, mean, color=style.VERMILION, linewidth=1.0, linestyle=(0, (2, 1.2)), label="estimated")
