"""Figures 2 and 4 to 23 of Mal et al. (2020): creep curves, and estimates and errors of each test."""

from collections.abc import Mapping
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from railgrip.report import palette, style
from railgrip.studies.lateral.judge import QUANTITIES, adhesion, beliefs_about
from railgrip.studies.lateral.run import NAMES, LateralCase, Trace, simulate
from railgrip.studies.lateral.tables import TITLES
from railgrip.studies.lateral.wheelset import CONDITIONS, PLANTS, TESTS

FIRST_FIGURES: Final[Mapping[str, int]] = {test.name: 4 + 4 * number for number, test in enumerate(TESTS)}
"""Number of the first of the paper's four figures of each test."""
COLOURS: Final = {"reconstruction": palette.VERMILION, "known_track": palette.BLUE, "unknown_track": palette.SKY}
LABELS: Final = {
    "lateral_velocity": "lateral\nvelocity [m/s]",
    "yaw_rate": "yaw rate\n[rad/s]",
    "creep": "creep",
    "creep_force": "creep force\n[N]",
    "friction": "friction",
}
THINNING: Final = 10
"""Recorded instants from one drawn point to the next: 10 ms, for motions of 2 Hz."""
WINDOW: Final = 100
"""Recorded instants in each rms error: 0.1 s."""


def creep_curves(speed: float) -> Figure:
    """Return adhesion over creep of each condition at a speed [m/s], with the published friction at zero creep."""
    drawing, panel = style.panels(7, 3.4)
    creep = np.geomspace(1e-5, 0.1, 120)
    lines = ("-", "--", "-.", ":")
    for condition, colour, line in zip(CONDITIONS, palette.lead_to_trail(len(CONDITIONS)), lines, strict=True):
        panel.plot(100 * creep, adhesion(condition, creep, speed), color=colour, linestyle=line, label=condition.name)
        panel.plot(0.0, condition.mu0, "D", color=palette.BLACK, markersize=5, markerfacecolor="none", clip_on=False,
                   label="published $u_0$" if condition is CONDITIONS[-1] else None)  # fmt: skip
    style.dress(panel, x="creep [%]", y="adhesion coefficient", title=f"Fig. 2, at {speed:g} m/s")
    panel.set_xlim(0, 10)
    panel.set_ylim(0, 0.5)
    style.legend(panel, loc="upper right", ncols=2)
    return drawing


def test_figure(case: LateralCase) -> Figure:
    """Run a case; draw estimates, errors as the paper draws them, and rms errors, a row for each quantity."""
    trace = simulate(case)
    drawing, panels = style.panels(11, 1.35 * len(QUANTITIES) + 0.4, len(QUANTITIES), 3, sharex=True)
    beliefs = {name: beliefs_about(trace, name) for name in NAMES}
    time = trace.time[::THINNING]
    windows = len(trace.time) // WINDOW * WINDOW
    middles = trace.time[:windows].reshape(-1, WINDOW).mean(axis=1)
    first = FIRST_FIGURES.get(case.test.name) if case.plant == "paper" else None
    for row, ((left, middle, right), quantity) in enumerate(zip(panels, QUANTITIES, strict=True)):
        truth = trace.truth[quantity]
        size = float(np.max(np.abs(truth)))
        largest = 0.0
        for name in NAMES:
            error = beliefs[name][quantity].mean - truth
            left.plot(time, (truth + error)[::THINNING], color=COLOURS[name], linewidth=1.2, label=TITLES[name])
            middle.plot(trace.time, error, color=COLOURS[name], linewidth=0.8)
            # Errors of filters that are lost are cut off.
            largest = max(largest, min(float(np.nanmax(np.abs(error))), 1.5 * size))
            squares = error[:windows].reshape(-1, WINDOW) ** 2
            right.plot(middles, np.sqrt(squares.mean(axis=1)), color=COLOURS[name], linewidth=1.0)
        middle.set_ylim(-1.05 * largest, 1.05 * largest)
        left.plot(time, truth[::THINNING], color=palette.BLACK, linewidth=0.5, label="true")
        # A curve outside of the panel has an error of more than half of the largest true value.
        bottom = -1.5 * size if np.min(truth) < 0 else -0.1 * size
        left.set_ylim(bottom, 1.5 * size)
        # The friction coefficient, which the paper estimates too, is in none of its figures.
        number = f"Fig. {first + row}" if first is not None and quantity != "friction" else ""
        style.dress(left, y=LABELS[quantity], title=number)
        right.set_yscale("log")
        right.set_ylim(1e-6 * size, 1e1 * size)
        unit = LABELS[quantity].partition("[")[2]
        for axes, what in ((middle, "error"), (right, "rms error over 0.1 s")):
            style.dress(axes, y=f"error [{unit}" if unit else "error", title=number and f"{number}, {what}")
        for axes in (left, middle, right):
            for change in trace.changes[1:]:
                axes.axvline(change, color=palette.GREY, linewidth=0.8, linestyle=":")
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
        axes.set_xlim(0, trace.time[-1])
    drawing.legend(*panels[0, 0].get_legend_handles_labels(), ncols=4, fontsize=8, frameon=False,
                   loc="outside lower center")  # fmt: skip
    drawing.suptitle(
        f"{case.test.name} at {case.speed:g} m/s, {PLANTS[case.plant].title}, seed {case.seed}",
        fontsize=10,
        x=0.02,
        ha="left",
    )
    return drawing


def spike_figure(trace: Trace) -> Figure:
    """Draw creep force and its error around the first change of the surface of a run."""
    drawing, (left, right) = style.panels(8, 2.8, 1, 2)
    change = trace.changes[1]
    part = (trace.time > change - 0.2) & (trace.time <= change + 0.5)
    time, truth = trace.time[part], 1e-3 * trace.truth["creep_force"][part]
    size, largest = float(np.max(truth)), 0.0
    for name in NAMES:
        force = 1e-3 * beliefs_about(trace, name)["creep_force"].mean[part]
        left.plot(time, force, color=COLOURS[name], linewidth=1.2, label=TITLES[name])
        right.plot(time, force - truth, color=COLOURS[name], linewidth=1.0)
        largest = max(largest, min(float(np.nanmax(np.abs(force - truth))), 1.5 * size))
    left.plot(time, truth, color=palette.BLACK, linewidth=0.5, label="true")
    left.set_ylim(-0.1 * size, 1.5 * size)
    right.set_ylim(-1.05 * largest, 1.05 * largest)
    style.dress(left, x="time [s]", y="creep force [kN]", title=f"Fig. 23 around {change:g} s, seed {trace.case.seed}")
    style.dress(right, x="time [s]", y="error [kN]", title="error")
    for axes in (left, right):
        axes.axvline(change, color=palette.GREY, linewidth=0.8, linestyle=":")
    drawing.legend(*left.get_legend_handles_labels(), ncols=4, fontsize=8, frameon=False, loc="outside lower center")
    return drawing
