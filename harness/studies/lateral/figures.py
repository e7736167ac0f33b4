"""Figures of the lateral study: the five tests, compactly, after figures 4 to 23 of Mal et al. (2020)."""

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from railgrip.report import style
from railgrip.studies.lateral.filters import NAMES
from railgrip.studies.lateral.judge import QUANTITIES, beliefs_about
from railgrip.studies.lateral.run import Trace
from railgrip.studies.lateral.tables import PLANT_TITLES, TITLES

COLOURS: Final = {"literal": style.VERMILION, "known_track": style.BLUE, "unknown_track": style.GREEN}
LABELS: Final = {
    "lateral_velocity": "lateral velocity [m/s]",
    "yaw_rate": "yaw rate [rad/s]",
    "creep": "creep",
    "creep_force": "creep force [N]",
    "friction": "friction coefficient",
}


def test_figure(trace: Trace) -> Figure:
    """Return truth and estimates on the left, errors on the right, a row for each quantity."""
    drawing, panels = style.panels(11, 2.0 * len(QUANTITIES), len(QUANTITIES), 2, sharex=True)
    beliefs = {name: beliefs_about(trace, name) for name in NAMES}
    for (left, right), quantity in zip(panels, QUANTITIES, strict=True):
        truth = trace.truth[quantity]
        size = float(np.max(np.abs(truth)))
        left.plot(trace.time, truth, color=style.BLACK, linewidth=1.2, label="true")
        for name in NAMES:
            mean = beliefs[name][quantity].mean
            left.plot(trace.time, mean, color=COLOURS[name], linewidth=0.8, linestyle="--", label=TITLES[name])
            right.plot(trace.time, np.abs(mean - truth), color=COLOURS[name], linewidth=0.7)
        # Room for twice the truth: a filter that leaves the panel is wrong by more than all there is to estimate.
        bottom = -1.5 * size if np.min(truth) < 0 else -0.1 * size
        left.set_ylim(bottom, 1.5 * size)
        style.dress(left, y=LABELS[quantity])
        right.set_yscale("log")
        right.set_ylim(1e-7 * size, 1e1 * size)
        unit = LABELS[quantity].partition("[")[2]
        style.dress(right, y=f"|error| [{unit}" if unit else "|error|")
        for axes in (left, right):
            for change in trace.changes[1:]:
                axes.axvline(change, color=style.GREY, linewidth=0.8, linestyle=":")
    panels[0, 0].legend(ncols=2, fontsize=7, loc="upper right", framealpha=0.9)
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
        axes.set_xlim(0, trace.time[-1])
    case = trace.case
    drawing.suptitle(
        f"{case.test.name} at {case.speed:g} m/s, {PLANT_TITLES[case.plant]}, seed {case.seed}",
        fontsize=11,
        x=0.02,
        ha="left",
    )
    return drawing
