"""Schwarz and Keck (2020): figures on wagon, roller rig and estimates, published and reproduced."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from scipy.ndimage import uniform_filter1d

from railgrip.base.arrays import Vector
from railgrip.estimation.judgement import errors
from railgrip.recording.samples import period_of, reading_of, truth_of
from railgrip.report import palette, style
from railgrip.report.table import ReportTable
from railgrip.scenario.load import read_toml
from railgrip.studies.papers.pages import PaperRow, arrow, canvas, comparison, dimension
from railgrip.trace.bound import Contact

PAGE = "adhesion_and_brake_friction.md"

RADIUS = 0.46
"""Wheel radius of the rig's wheelset [m]."""
LIMIT = 0.02
"""Limit of the error of adhesion outside protection events, as stated in the paper."""
RECOVERY = 0.1
"""Time within which a larger error is corrected, as stated in the paper [s]."""
RESPONSE = 0.2
"""Usual response time of a wheel-slide protection, "about", §4 [s]."""
FALLEN = 1 / np.e
"""Remaining share of the pad force when the protection has responded: after one time constant of a lag."""
PRESSED = 3e3
"""Pad force from which the brake counts as applied [N]: 30 times the noise of its load cell."""

COLOURS = {"rig-paper": palette.ORANGE, "rig-own": palette.BLUE}
LOAD_CELLS = "#B8B8B8"
NAMES = {"rig-paper": "Q and R of equation (20)", "rig-own": "noises of sensors and physics"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Statement:
    """Statement of the text about a test from `begin` to `end` [s], with the bounds of adhesion, if it has any."""

    begin: float
    end: float
    words: str
    adhesion: tuple[float, float] | None = None


STATEMENTS: Mapping[str, Sequence[Statement]] = {
    test: [Statement(**row) for row in rows]
    for test, rows in read_toml(Path(__file__).parent / "library" / "statements.toml").items()
}
"""Statements by test. The end of the tests is in the images only."""

START_SPEED = {"rig_slide": 120.0, "rig_sand": 200.0}
"""Published initial speeds [km/h]."""

DEEP_SLIDE = (4.0, 11.0)
"""Time range that is drawn as figure 6 in the sanding test [s]: adhesion passes its peak, falls, recovers and goes to
zero. The paper describes this range with figure 5 and does not state that of figure 6."""
SLIDING = 0.1
"""Slip above which the wheelset slides: several times the slip of the peak."""


def measured_adhesion(recording: xarray.Dataset) -> Vector:
    """Return adhesion by the load cells of the rig, equation 2."""
    return reading_of(recording, "contact_force") / reading_of(recording, "wheelset_load")


def wagon_figure() -> Figure:
    """Draw the wagon with forces and torques, positive as in equations 1 to 6 (figure 1)."""
    drawing, axes = canvas(8, 4.2)
    axes.add_patch(Rectangle((1.0, 2.1), 6.0, 1.25, fill=False, linewidth=1.4))
    axes.plot([0.3, 7.7], [0.5, 0.5], color=palette.BLACK, linewidth=2)
    axes.plot(4.0, 2.6, "o", color=palette.BLACK)
    arrow(axes, (4.0, 2.6), (4.0, 1.6), "$m g$", (4.25, 1.75))
    arrow(axes, (4.4, 3.65), (5.6, 3.65), "$v_x$", (5.0, 3.85))
    arrow(axes, (7.0, 2.7), (7.9, 2.7), "$F_{TR} + k_d v_x^2$", (7.35, 2.95))
    for x, name in ((5.9, "f"), (2.1, "r")):
        axes.add_patch(Circle((x, 1.2), 0.7, fill=False, linewidth=1.4))
        axes.add_patch(Circle((x, 1.2), 0.36, fill=False, linestyle="--", linewidth=1.0))
        axes.plot([x, x], [1.2, 2.1], color=palette.GREY, linewidth=3, alpha=0.5)
        arrow(axes, (x, 0.5), (x + 0.85, 0.5), f"$F_{{x,{name}}}$", (x + 0.75, 0.72), palette.VERMILION)
        arrow(axes, (x, 0.0), (x, 0.48), f"$F_{{z,{name}}}$", (x - 0.28, 0.2), palette.VERMILION)
        arrow(axes, (x - 1.2, 1.2), (x - 0.36, 1.2), f"$F_{{\\perp,{name}}}$", (x - 1.0, 1.4), palette.BLUE)
        axes.text(x + 0.06, 1.38, "$r_B$", fontsize=9, color=palette.GREY)
        axes.text(x + 0.36, 0.84, "$r_W$", fontsize=9, color=palette.GREY)
        axes.plot([x, x + 0.34], [1.2, 1.32], color=palette.GREY, linewidth=0.9)
        axes.plot([x, x + 0.66], [1.2, 0.97], color=palette.GREY, linewidth=0.9)
        axes.annotate("", (x + 0.75, 1.55), (x + 0.1, 2.0), arrowprops={
            "arrowstyle": "-|>", "connectionstyle": "arc3,rad=-0.3", "color": palette.BLACK, "lw": 1.2})  # fmt: skip
        axes.text(x + 0.62, 1.88, f"$\\omega_{name}$, $M_{{W,{name}}}$", fontsize=9)
    dimension(axes, (2.1, 0.3), (5.9, 0.3), "$a$", (0.0, -0.13))
    dimension(axes, (3.6, 0.5), (3.6, 2.6), "$h$", (-0.15, 0.0))
    return drawing


def rig_figure() -> Figure:
    """Draw the roller rig: wheelset, roller, cylinders with load cells, drive (figure 2)."""
    drawing, axes = canvas(8, 4.6)
    roller, wheelset = (3.6, 1.35), (3.6, 3.02)
    for centre, radius in ((roller, 1.1), (wheelset, 0.57)):
        axes.add_patch(Circle(centre, radius, fill=False, linewidth=1.6))
        axes.plot(*centre, "o", color=palette.BLACK, markersize=4)
    axes.add_patch(Circle(wheelset, 0.3, fill=False, linestyle="--"))
    for corner, size in (((1.7, 2.92), (0.5, 0.2)), ((3.5, 3.95), (0.2, 0.4))):
        axes.add_patch(Rectangle(corner, *size, facecolor=palette.ORANGE, edgecolor=palette.BLACK))
    axes.plot([0.9, 1.7], [3.02, 3.02], color=palette.BLACK, linewidth=2)
    axes.plot([2.2, 3.6], [3.02, 3.02], color=palette.BLACK, linewidth=2)
    axes.plot([0.9, 0.9], [2.6, 3.4], color=palette.BLACK, linewidth=4)
    axes.plot([3.6, 3.6], [3.02, 3.95], color=palette.BLACK, linewidth=2)
    axes.plot([3.1, 4.1], [4.38, 4.38], color=palette.BLACK, linewidth=4)
    axes.text(1.95, 3.28, "longitudinal cylinder,\nload cell: $F_x$", ha="center", fontsize=9)
    axes.text(3.9, 4.05, "vertical cylinder, load cell: $F_z$", fontsize=9)
    pads = "pads on the disc: $F_\\perp$, $\\mu_B$"
    arrow(axes, (4.75, 3.02), (3.92, 3.02), pads, (4.85, 3.02), palette.BLUE, "left")
    arrow(axes, (3.6, 2.45), (2.9, 2.45), "adhesion $\\mu_W = F_x / F_z$", (2.8, 2.35), palette.VERMILION, "right")
    axes.text(4.3, 2.6, "wheelset: $\\omega_W$", fontsize=9)
    axes.text(3.6, 0.95, "roller:\n$v_x = \\omega_{Roller}\\, r_{Roller}$", ha="center", va="center", fontsize=9)
    axes.add_patch(Rectangle((5.6, 1.0), 2.1, 0.7, fill=False, linewidth=1.4))
    axes.text(6.65, 1.35, "drive: torque of drag\nand mass of a wagon", ha="center", va="center", fontsize=9)
    arrow(axes, (5.6, 1.35), (3.66, 1.35))
    return drawing


def points_of_slide(recording: xarray.Dataset, contact: Contact) -> dict[str, Any]:
    """Return the points of figure 3 in the slide of figure 6, and the creep curve of its release.

    1 is the peak of the curve, 2 the largest slip, 3 the wheelset rolling again. `way`: samples from 2 to 3.
    """
    part = recording.sel(time=slice(*DEEP_SLIDE))
    slip, adhesion = truth_of(part, "slip"), truth_of(part, "group_adhesion")
    release = int(np.argmax(slip))
    again = release + int(np.argmax(slip[release:] < 1e-3))
    slips = np.concatenate([[0.0], np.geomspace(1e-3, 0.5, 60)])
    speed, load, mu0 = (part[name].values[release] for name in ("speed", "wheelset_load", "mu0"))
    curve = contact(slips, np.full(slips.size, speed), np.full(slips.size, load[0]), np.full(slips.size, mu0[0]))
    peak = int(np.argmax(curve))
    return {
        "curve": (slips, curve),
        "way": (slip[release:again], adhesion[release:again]),
        "points": {
            1: (float(slips[peak]), float(curve[peak])),
            2: (float(slip[release]), float(adhesion[release])),
            3: (float(slip[again]), float(adhesion[again])),
        },
    }


def qualitative_figure(slide: Mapping[str, Any]) -> Figure:
    """Draw adhesion over slip with the points 1 to 3 of the text, and the way of the test between them (figure 3)."""
    drawing, panel = style.panels(8, 3.6)
    for (slip, adhesion), color, dashes, name in (
        (slide["curve"], palette.BLACK, "-", "creep curve at the release of the brake"),
        (slide["way"], palette.ORANGE, "--", "way from 2 over 1 to 3 in the sanding test"),
    ):
        panel.plot(100 * slip, adhesion, dashes, color=color, label=name, linewidth=1.4)
    for number, (slip, adhesion) in slide["points"].items():
        panel.plot(100 * slip, adhesion, "o", color=palette.VERMILION, clip_on=False)
        panel.annotate(str(number), (100 * slip, adhesion), xytext=(7, 5), textcoords="offset points", weight="bold")
    style.dress(panel, x="slip [%]", y="adhesion")
    panel.set_xlim(0, 50)
    panel.set_ylim(0, 0.14)
    style.legend(panel, loc="upper right")
    return drawing


def record_figure(test: str, recording: xarray.Dataset, estimates: Mapping[str, xarray.Dataset]) -> Figure:
    """Draw inputs and readings, adhesion, and pad friction of a test, with what the text states (figures 4 and 5)."""
    time = recording["time"].values
    drawing, (inputs, adhesion, friction) = style.panels(9, 7.5, 3, 1, sharex=True)
    wheelset = style.KMH * RADIUS * reading_of(recording, "wheelset_speed")
    inputs.plot(time, wheelset, color=palette.BLUE, lw=0.7, label="wheelset, at the rim")
    inputs.plot(time, style.KMH * reading_of(recording, "speed"), color=palette.BLACK, lw=1.4, label="roller")
    inputs.plot(0, START_SPEED[test], "D", color=palette.VERMILION, clip_on=False, label="roller, published")
    style.dress(inputs, y="speed [km/h]")
    force = style.second_scale(inputs, "pad force [kN]")
    force.plot(time, reading_of(recording, "pad_force") / 1e3, color=palette.ORANGE, lw=0.6, label="pad force (right)")
    force.set_ylim(0, 150)
    inputs.set_ylim(0, 1.25 * START_SPEED[test])
    # Above the axes, where no line runs.
    lines = [*inputs.get_lines(), *force.get_lines()]
    names = [str(line.get_label()) for line in lines]
    style.legend(inputs, lines, names, loc="lower left", bbox_to_anchor=(0.0, 0.98), ncols=4)
    measured = measured_adhesion(recording)
    friction.plot(time, truth_of(recording, "pad_friction"), color=palette.BLACK, lw=1.2, ls="--", label="true")
    # The noisiest line looks like a band and is drawn first, below the true value.
    for name, estimate in estimates.items():
        width = 1.6 if name == "rig-paper" else 0.6
        adhesion.plot(
            time, estimate["mean"].sel(state="group_adhesion"), color=COLOURS[name], lw=width, label=NAMES[name]
        )
        friction.plot(time, estimate["mean"].sel(state="pad_friction"), color=COLOURS[name], lw=0.8, label=NAMES[name])
        if name == "rig-paper":
            adhesion.plot(time, measured, color=LOAD_CELLS, lw=1.4, label="load cells")
    top = 1.35 * float(np.nanmax(measured))
    adhesion.set_ylim(-0.01, top)
    style.dress(adhesion, y="adhesion")
    style.dress(friction, x="time [s]", y="pad friction")
    friction.set_ylim(0.3, 0.5)
    for statement in STATEMENTS[test]:
        _draw_statement(statement, adhesion, friction, top)
    for panel in (adhesion, friction):
        style.legend(panel, loc="lower left", bbox_to_anchor=(0.0, 0.98), ncols=3)
    friction.set_xlim(0, time[-1])
    return drawing


def _draw_statement(statement: Statement, adhesion: Axes, friction: Axes, top: float) -> None:
    for panel in (adhesion, friction):
        panel.axvspan(statement.begin, statement.end, color=palette.SKY, alpha=0.15, linewidth=0)
    if statement.adhesion:
        for bound in statement.adhesion:
            adhesion.plot([statement.begin, statement.end], [bound] * 2, color=palette.BLACK, lw=1.2, ls=":")
    adhesion.text(statement.begin + 0.4, 0.97 * top, f"published:\n{statement.words}", fontsize=8, va="top")


def over_slip_figure(recording: xarray.Dataset, estimates: Mapping[str, xarray.Dataset]) -> Figure:
    """Draw adhesion over slip and its absolute error in the deep slide of the sanding test (figure 6)."""
    part = recording.sel(time=slice(*DEEP_SLIDE))
    slip, truth = 100 * truth_of(part, "slip"), truth_of(part, "group_adhesion")
    drawing, (above, below) = style.panels(8, 6, 2, 1, sharex=True)
    above.plot(slip, measured_adhesion(part), color=LOAD_CELLS, lw=2.2, label="load cells")
    for name, estimate in estimates.items():
        adhesion = estimate.sel(time=slice(*DEEP_SLIDE))["mean"].sel(state="group_adhesion").values
        above.plot(slip, adhesion, color=COLOURS[name], lw=0.7, label=NAMES[name])
        below.plot(slip, np.abs(adhesion - truth), ".", color=COLOURS[name], ms=2.5, label=NAMES[name])
    for bound, place, words in ((0.1, 0.102, "published: peak 0.1"), (0.05, 0.043, "published: falls to 0.05")):
        above.axhline(bound, color=palette.BLACK, lw=1.0, ls=":")
        above.text(25, place, words, fontsize=8)
    below.axhline(LIMIT, color=palette.BLACK, lw=1.0, ls=":")
    below.text(25, LIMIT + 0.0006, f"published: {LIMIT:g} but for one peak", fontsize=8)
    style.dress(above, y="adhesion")
    style.dress(below, x="slip [%]", y="absolute error of adhesion")
    below.set_xlim(0, None)
    above.set_ylim(0, 0.14)
    below.set_ylim(0, 0.025)
    style.legend(above, loc="upper right")
    return drawing


def figures(
    tests: Mapping[str, tuple[xarray.Dataset, Mapping[str, xarray.Dataset]]], slide: Mapping[str, Any]
) -> dict[str, Figure]:
    """Return all figures of the page by file name; recording and estimates by test, and `points_of_slide`."""
    drawings = (
        wagon_figure(),
        rig_figure(),
        qualitative_figure(slide),
        record_figure("rig_slide", *tests["rig_slide"]),
        record_figure("rig_sand", *tests["rig_sand"]),
        over_slip_figure(*tests["rig_sand"]),
    )
    return {
        f"{Path(PAGE).stem}_{number}.{'svg' if number <= 3 else 'png'}": drawing
        for number, drawing in enumerate(drawings, 1)
    }


def measures(
    tests: Mapping[str, tuple[xarray.Dataset, Mapping[str, xarray.Dataset]]],
    scores: Sequence[Mapping[str, Any]],
    slide: Mapping[str, Any],
    same_protection: xarray.Dataset,
) -> dict[str, Any]:
    """Return the numbers measured in the reproduced figures, by name, from which the table of the page is made.

    Args:
        tests: Recording and estimates by test.
        scores: Rows of the study: errors of each filter in each test.
        slide: See `points_of_slide`.
        same_protection: Recording of the sanding test with the protection of the sliding test.
    """
    found: dict[str, Any] = {"points": {str(number): point for number, point in slide["points"].items()}}
    for test, (recording, estimates) in tests.items():
        found[test] = {"speed": style.KMH * float(reading_of(recording, "speed")[0]), **brakings(recording)}
        found[test]["rises"] = begin = STATEMENTS[test][-1].begin
        courses = {name: estimate["mean"].sel(state="pad_friction").values for name, estimate in estimates.items()}
        courses["true"] = truth_of(recording, "pad_friction")
        found[test]["pad friction"] = {name: _rise(course, recording, begin) for name, course in courses.items()}
        found[test]["settling"] = {name: settling(recording, estimate) for name, estimate in estimates.items()}
        found[test]["response"] = response(recording)
        found[test]["late"] = {name: late_errors(recording, estimate) for name, estimate in estimates.items()}
        found[test]["oscillation"] = _oscillation(courses["rig-paper"], recording)
        found[test]["filters"] = {
            row["filter"]: {key: row[key] for key in ("adhesion_outside", "longest", "excursions")}
            for row in scores
            if row["scenario"].replace("-", "_") == test
        }
    low = STATEMENTS["rig_slide"][1]
    while_braking = tests["rig_slide"][0].sel(time=slice(low.begin + 1, low.end))
    quantiles = np.quantile(measured_adhesion(while_braking), [0.05, 0.95])
    found["rig_slide"]["adhesion"] = [float(value) for value in quantiles]
    recording, estimates = tests["rig_sand"]
    found["rig_sand"]["adhesion"] = _adhesion_of_slide(recording)
    found["rig_sand"]["slides"] = slides(recording)
    found["rig_sand"]["applications, same protection"] = brakings(same_protection)["applications"]
    found["rig_sand"]["peaks"] = {name: peaks_in_slide(recording, estimate) for name, estimate in estimates.items()}
    return found


def late_errors(recording: xarray.Dataset, estimates: xarray.Dataset) -> dict[str, float]:
    """Return errors of a filter: rms of both speeds after the start [rad/s, m/s], and of adhesion after 110 s.

    Of adhesion also the largest error.
    """
    time = recording["time"].values - recording["time"].values[0]
    found = {
        state: float(np.sqrt(np.mean(errors(recording, estimates, state)[time >= 0.5] ** 2)))
        for state in ("wheelset_speed", "speed")
    }
    late = errors(recording, estimates, "group_adhesion")[time >= STATEMENTS["rig_slide"][-1].begin]
    if late.size:
        found |= {"adhesion": float(np.sqrt(np.mean(late**2))), "largest": float(np.max(np.abs(late)))}
    return found


def brakings(recording: xarray.Dataset) -> dict[str, Any]:
    """Return instants of brake applications before the stop braking [s], and their rate after its beginning [1/s]."""
    time, pressed = recording["time"].values, reading_of(recording, "pad_force") > PRESSED
    begins = time[np.flatnonzero(np.diff(pressed.astype(int)) > 0)]
    ends = time[np.flatnonzero(np.diff(pressed.astype(int)) < 0)]
    gaps = np.diff(begins)
    # The stop braking begins after the last long pause: those of the protection take some seconds.
    stop = float(begins[int(np.argmax(gaps)) + 1]) if gaps.max() > 8 else float(begins[0])
    short = [(float(begin), float(end)) for begin, end in zip(begins, ends, strict=False) if begin < stop]
    return {"short": short, "stop": stop, "applications": float(np.sum(begins >= stop) / (time[-1] - stop))}


def settling(recording: xarray.Dataset, estimates: xarray.Dataset) -> float:
    """Return the time [s] after the start until the error of adhesion is within `LIMIT` for one second or more.

    Infinite if it is not within the first second.
    """
    time = recording["time"].values - recording["time"].values[0]
    over = ~(np.abs(errors(recording, estimates, "group_adhesion")) <= LIMIT) & (time <= 2.0)
    last = float(time[np.flatnonzero(over)[-1]]) if over.any() else -period_of(recording)
    return last + period_of(recording) if last < 1.0 else float("inf")


def response(recording: xarray.Dataset) -> float:
    """Return the time [s] from an intervention of the protection until the pad force has fallen to `FALLEN`, median."""
    force, busy = reading_of(recording, "pad_force"), reading_of(recording, "protecting") > 0.5
    begins = np.flatnonzero(np.diff(busy.astype(int)) > 0) + 1
    times = [
        float(np.argmax(force[begin:] < FALLEN * force[begin])) * period_of(recording)
        for begin in begins
        if force[begin] > PRESSED and (force[begin:] < FALLEN * force[begin]).any()
    ]
    return float(np.median(times))


def slides(recording: xarray.Dataset) -> int:
    """Return the number of slides that begin in the time range of figure 6."""
    sliding = truth_of(recording.sel(time=slice(*DEEP_SLIDE)), "slip") > SLIDING
    return int(np.sum(np.diff(sliding.astype(int)) > 0))


def _rise(friction: Vector, recording: xarray.Dataset, begin: float) -> list[float]:
    time = recording["time"].values
    return [float(np.mean(friction[(time >= at) & (time < at + 1)])) for at in (begin, time[-1] - 1)]


def _oscillation(friction: Vector, recording: xarray.Dataset) -> float:
    return float(np.std(friction - uniform_filter1d(friction, round(10.0 / period_of(recording)))))


def peaks_in_slide(recording: xarray.Dataset, estimates: xarray.Dataset) -> int:
    """Return the number of intervals of figure 6 with an error of adhesion above `LIMIT`."""
    over = np.abs(errors(recording, estimates, "group_adhesion")) > LIMIT
    time = recording["time"].values
    over &= (time >= DEEP_SLIDE[0]) & (time <= DEEP_SLIDE[1])
    return int(np.sum(np.diff(over.astype(int)) > 0))


def _adhesion_of_slide(recording: xarray.Dataset) -> list[float]:
    part = recording.sel(time=slice(*DEEP_SLIDE))
    slip, adhesion = truth_of(part, "slip"), measured_adhesion(part)
    largest = int(np.argmax(slip))
    again = largest + int(np.argmax(slip[largest:] < 1e-3))
    return [
        float(np.max(adhesion[:largest])),
        float(adhesion[largest]),
        float(np.max(adhesion[largest:again])),
        float(np.min(adhesion[largest:])),
    ]


def compare_with_paper(found: Mapping[str, Any]) -> list[PaperRow]:
    """Return published and reproduced quantities; `found` are `measures`."""
    words = {"1": "greatest adhesion", "2": "brake released", "3": "rolling"}
    rows = [
        PaperRow("Fig. 3", f"point {number}, {words[number]}", "no numbers",
                 f"adhesion {adhesion:.3f} at {100 * slip:.1f} % slip")
        for number, (slip, adhesion) in found["points"].items()
    ]  # fmt: skip
    slide, sand = found["rig_slide"], found["rig_sand"]
    rows += [*_compare_slide(slide), *_compare_sand(sand, slide)]
    for name, judged in sand["filters"].items():
        outside = f"error of adhesion outside protection events, {NAMES[name]}"
        longest = f"longest error above {LIMIT:g}, {NAMES[name]}"
        rows += [
            PaperRow("Fig. 6", outside, (-np.inf, LIMIT), judged["adhesion_outside"], "{:.4f}"),
            PaperRow("Fig. 6", longest, (-np.inf, RECOVERY), judged["longest"], "{:.3f} s"),
        ]
    rows += [
        PaperRow("Fig. 6", f"peaks above {LIMIT:g} as drawn / in all of the test, {NAMES[name]}", "one",
                 f"{count} / {sand['filters'][name]['excursions']}")
        for name, count in sand["peaks"].items()
    ]  # fmt: skip
    response = f"{slide['response']:.2f} / {sand['response']:.2f} s"
    return [*rows, PaperRow("Fig. 6", "response of the protection, slide / sand", f"about {RESPONSE:g} s", response)]


def _compare_slide(slide: Mapping[str, Any]) -> list[PaperRow]:
    low, short = STATEMENTS["rig_slide"][1], slide["short"]
    rows = [
        PaperRow("Fig. 4", "initial speed", START_SPEED["rig_slide"], slide["speed"], "{:.0f} km/h", is_chosen=True),
        PaperRow("Fig. 4", "short brakings", 3.0, float(len(short)), "{:.0f}", is_chosen=True),
        PaperRow("Fig. 4", "begin of the first short braking", 18.0, short[0][0], "{:.1f} s", is_chosen=True),
        PaperRow("Fig. 4", "end of the last short braking", 33.0, short[-1][1], "{:.1f} s"),
        PaperRow("Fig. 4", "begin of the stop braking", low.begin, slide["stop"], "{:.1f} s", is_chosen=True),
    ]
    for name, adhesion in zip(("5 %", "95 %"), slide["adhesion"], strict=True):
        quantity = f"adhesion until {low.end:g} s, {name} quantile"
        rows.append(PaperRow("Fig. 4", quantity, (0.02, 0.05), adhesion, "{:.3f}", is_chosen=True))
    rows += _compare_estimates("Fig. 4", slide)
    for name, late in slide["late"].items():  # of these errors the paper publishes words only
        outside = slide["filters"][name]["adhesion_outside"]
        rows += [
            PaperRow("Fig. 4", f"largest error of adhesion outside protection events, {NAMES[name]}",
                     "almost identical", f"{outside:.4f}"),
            PaperRow("Fig. 4", f"error of adhesion from 110 s on, rms / largest, {NAMES[name]}",
                     "well approximated", f"{late['adhesion']:.4f} / {late['largest']:.3f}"),
            PaperRow("Fig. 4", f"rms error of ω_W / v_x, {NAMES[name]}", "no remarkable difference",
                     f"{late['wheelset_speed']:.1e} rad/s / {late['speed']:.1e} m/s"),
        ]  # fmt: skip
    return rows


def _compare_sand(sand: Mapping[str, Any], slide: Mapping[str, Any]) -> list[PaperRow]:
    names, expected = ("first peak", "after the fall", "after the release", "at last"), (0.1, 0.05, 0.1, 0.0)
    rates = [test["applications"] for test in (slide, sand)] + [sand["applications, same protection"]]
    return [
        PaperRow("Fig. 5", "initial speed", START_SPEED["rig_sand"], sand["speed"], "{:.0f} km/h", is_chosen=True),
        *(
            PaperRow("Fig. 5", f"adhesion, 4 to 11 s, {name}", published, ours, "{:.3f}", is_chosen=published > 0)
            for name, published, ours in zip(names, expected, sand["adhesion"], strict=True)
        ),
        PaperRow("Fig. 5", f"slides with more than {100 * SLIDING:g} % slip, 4 to 11 s", 1, sand["slides"], "{:d}",
                 is_chosen=True),
        *_compare_estimates("Fig. 5", sand),
        PaperRow("Fig. 5", "applications of the brake a second, slide / sand", "fewer in the sanding test",
                 f"{rates[0]:.2f} / {rates[1]:.2f}"),
        PaperRow("Fig. 5", "the same with one protection in both tests", "fewer in the sanding test",
                 f"{rates[0]:.2f} / {rates[2]:.2f}"),
        PaperRow("Fig. 5", "rms oscillation of estimated pad friction, slide / sand", "larger in the sanding test",
                 f"{slide['oscillation']:.4f} / {sand['oscillation']:.4f}"),
    ]  # fmt: skip


def _compare_estimates(figure: str, test: Mapping[str, Any]) -> list[PaperRow]:
    rows = [
        PaperRow(figure, f"wrong start of adhesion corrected in, {NAMES[name]}", "first few tenths of a second",
                 f"{seconds:.3f} s")
        for name, seconds in test["settling"].items()
    ]  # fmt: skip
    published = f"rises from {test['rises']:g} s on"
    return rows + [
        PaperRow(figure, f"pad friction, {NAMES.get(name, name)}", published, f"{begin:.3f} to {end:.3f}",
                 difference="" if end > begin else "does not rise")
        for name, (begin, end) in test["pad friction"].items()
    ]  # fmt: skip


def table(found: Mapping[str, Any]) -> ReportTable:
    """Return the table of the page; `found` are `measures`."""
    return comparison(compare_with_paper(found))
