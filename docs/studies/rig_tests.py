"""Tests of Schwarz and Keck (2020), §4, on a simulated rig: both filters against true values, and drawings."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from numpy.typing import NDArray
from schematics import arrow, canvas
from scipy.ndimage import uniform_filter1d

from railgrip.estimation import roller_rig as rig
from railgrip.estimation.judgement import judge
from railgrip.estimation.run import by_name
from railgrip.estimation.sources import recording_of_estimation
from railgrip.estimation.spec import (
    LIBRARY,
    Specification,
    equations_for,
    estimate_of,
    load_specification,
    settings_for,
)
from railgrip.estimators.observability import along
from railgrip.recording.samples import period_of, reading_of, samples, truth_of, with_signals
from railgrip.report import palette, style
from railgrip.report.baseline import Finding, extreme, mean
from railgrip.scenario.load import load
from railgrip.simulate.vehicle_data import VehicleData

PERIOD, NOISE = 5e-3, 5e-5
"""Sampling period [s] and standard deviation of the roller's speed [m/s] of the scenarios."""
WRONG_START = ("start.mean.group_adhesion=0.1", "start.deviation.group_adhesion=0.1")
"""Both filters assume an adhesion of 0.1 at the start, where the wheelset rolls: the paper shows how a wrong start is
corrected, but not which."""
SAME_PROTECTION = ("controller.parameters.low=0.10", "controller.parameters.high=0.20")
"""Thresholds of the sliding test, used in the sanding test to separate the effect of sand on interventions."""
R_OF_SPEED = 1e-7
"""Variance of the roller's speed that equation (20) states [m²/s²]."""
ENCODERS = ("no error", "white noise of R", "steps of variance R")
"""Encoders of the roller: without error, with noise of variance R, and with rounding of variance R."""
_DRAWS = 10
"""Number of draws of the noise, or of the offset of the rounding grid."""
WAGONS: Mapping[str, Mapping[str, float]] = {
    "corrected": {},
    "as printed": {"adhesion_share": 0.5, "resistance_transfer": 1.0, "adhesion_transfer": 0.0},
}
"""Parameters of `WagonPrediction` with equations (4), (5) and (12) corrected, and as printed."""
_WAGON_STATES = {"α": "group_adhesion", "μ_B front": "pad_friction[1]", "μ_B rear": "pad_friction[2]"}
START_SPEED = {"rig_slide": 120.0, "rig_sand": 200.0}
"""Published initial speeds [km/h]."""
STATEMENTS: Mapping[str, list[tuple[float, float, str, tuple[float, ...]]]] = {
    "rig_slide": [
        (18, 33, "three short\nbrakings", ()),
        (42, 110, "stop braking, adhesion 0.02 to 0.05", (0.02, 0.05)),
        (110, 200, "fast changes,\npad friction rises", ()),
    ],
    "rig_sand": [(4, 11, "0.1, 0.05,\nagain 0.1, 0", (0.0, 0.1)), (55, 200, "pad friction rises", ())],
}
"""Statements of the text about each test: begin and end [s], words, and bounds of adhesion, if there are any. The end
of the tests is in the images only."""
NAMES = {"rig-paper": "Q and R of equation (20)", "rig-own": "noises of sensors and physics"}
_COLOURS = {"rig-paper": palette.ORANGE, "rig-own": palette.BLUE}
_LOAD_CELLS = "#B8B8B8"
_RADIUS = 0.46
"""Wheel radius of the rig's wheelset [m]."""

Row = dict[str, Any]


def filters(noise: float = NOISE) -> dict[str, Specification]:
    """Return both filters by name: equation (20), and ours for a standard deviation of the roller's speed [m/s]."""
    own = (*WRONG_START, f"noise.readings.speed={noise**2}")
    return {
        "rig-paper": load_specification(LIBRARY / "rig_paper.toml", WRONG_START),
        "rig-own": load_specification(LIBRARY / "rig_own.toml", own),
    }


def rows(test: str, period: float, noise: float) -> list[Row]:
    """Return a row for each filter in a test, with a sampling period [s] and a noise of the roller's encoder [m/s].

    Errors of the filter are those after `roller_rig.SETTLED` seconds. Mean pad friction is that of the first second
    from the instant on that the paper names, and of the last one. Figures of the run itself are in each row.
    """
    recording = rig.recording_of_rig(rig.resample(test, period, noise))
    time, begin = recording["time"].values, STATEMENTS[test][-1][0]
    after = time >= rig.SETTLED

    def ends_of(friction: NDArray[np.float64]) -> list[float]:
        return [float(np.mean(friction[(time >= at) & (time < at + 1)])) for at in (begin, time[-1] - 1)]

    short, stop, rate = rig.brakings(recording)
    run: Row = {
        "speed": float(reading_of(recording, "speed")[0]),
        "short": len(short),
        "short_begin": short[0][0] if short else None,
        "short_end": short[-1][1] if short else None,
        "stop": stop,
        "rate": rate,
        "response": rig.response(recording),
    }
    run["true_begin"], run["true_end"] = ends_of(truth_of(recording, "pad_friction"))
    if test == "rig_sand":
        same = rig.recording_of_rig(load(Path(test), SAME_PROTECTION))
        run |= {"slides": rig.slides(recording), "same_rate": rig.brakings(same)[2]}
        run |= rig.adhesion_of_slide(recording)
    else:
        low, high, *_ = STATEMENTS[test][1]
        quantiles = np.quantile(rig.measured_adhesion(recording.sel(time=slice(low + 1, high))), [0.05, 0.95])
        run["low"], run["high"] = quantiles.tolist()
    found: list[Row] = []
    for name, specification in filters(noise).items():
        estimates = estimate_of(specification, recording)
        adhesion, pads, wheelset, speed = (
            judge(recording, estimates, state, after)
            for state in ("group_adhesion", "pad_friction", "wheelset_speed", "speed")
        )
        row = {"filter": name, "nees": adhesion.nees, "settling": rig.settling(recording, estimates)}
        row |= {"rmse": adhesion.rmse, "bias": adhesion.bias, **rig.excursions(recording, estimates, rig.SETTLED)}
        row |= {"pads_rmse": pads.rmse, "pads_bias": pads.bias, "pads_nees": pads.nees, "pads_sd": pads.sd}
        row |= {"omega": wheelset.rmse, "v": speed.rmse}
        friction = estimates["mean"].sel(state="pad_friction").values
        row["pads_begin"], row["pads_end"] = ends_of(friction)
        smooth = uniform_filter1d(friction, round(10.0 / period_of(recording)))
        row["ripple"] = float(np.std(friction - smooth))
        if test == "rig_slide":
            last = judge(recording, estimates, "group_adhesion", time >= begin)
            row |= {"late_rmse": last.rmse, "late_largest": last.largest}
        found.append(row | run)
    return found


@cache
def run_of(test: str) -> tuple[xarray.Dataset, dict[str, xarray.Dataset]]:
    """Return a test of the rig, and the estimates of each filter."""
    recording = rig.recording_of_rig(load(Path(test)))
    return recording, {name: estimate_of(filter_, recording) for name, filter_ in filters().items()}


def slide_rows(test: str) -> list[Row]:
    """Return slip and adhesion of the lines and points of figure 3 in a test; see `roller_rig.points_of_slide`."""
    scenario = load(Path(test))
    found = rig.points_of_slide(rig.recording_of_rig(scenario), VehicleData(scenario).contact)
    return [
        {"part": part, "slip": slip, "adhesion": adhesion}
        for part, ways in found.items()
        for slip, adhesion in zip(*ways, strict=True)
    ]


def fit_rows(test: str, period: float) -> list[Row]:
    """Return errors of equation (20) as printed in a test at a period, with each encoder of the roller.

    `outside`: error outside protection events, median over draws; `kept`: draws within the claim. `bound` is the
    deviation to which `roller_rig.RECOVERY` seconds of readings with the noises of R determine adhesion at their start,
    with an exact model: the Cramér-Rao bound of a filter that corrects an error in that time, median over windows.
    """
    specification = filters()["rig-paper"]
    recording = rig.recording_of_rig(rig.resample(test, period, 1e-9))
    equations, settings = equations_for(specification), settings_for(specification, period)
    states = np.stack([truth_of(recording, state) for state in equations.states], axis=1)
    readings = by_name("readings", settings.readings, equations.outputs)
    window, scale = round(rig.RECOVERY / period), np.ones(len(equations.states))
    inputs = samples(recording, equations.inputs)
    _, _, deviation = along(equations, states, inputs, period, readings, scale, window, 10 * window)
    bound = float(np.median(deviation[:, equations.states.index("group_adhesion")]))
    found: list[Row] = []
    for encoder in ENCODERS:
        draws: list[dict[str, float]] = []
        for draw in range(1 if encoder == ENCODERS[0] else _DRAWS):
            read = with_signals(recording, {"speed": (encode(recording["reading_speed"].values, encoder, draw), "m/s")})
            draws.append(rig.excursions(read, estimate_of(specification, read), rig.SETTLED))
        outside = float(np.median([each["outside"] for each in draws]))
        kept = sum(bool(each["kept"]) for each in draws)
        found.append({"encoder": encoder, "outside": outside, "kept": kept, "draws": len(draws), "bound": bound})
    return found


def encode(speed: NDArray[np.float64], encoder: str, draw: int) -> NDArray[np.float64]:
    """Return speeds as one of `ENCODERS` reads them [m/s]."""
    random = np.random.default_rng([20, draw])
    if encoder == "white noise of R":
        return speed + np.sqrt(R_OF_SPEED) * random.standard_normal(speed.shape)
    if encoder == "steps of variance R":
        step, place = np.sqrt(12 * R_OF_SPEED), random.random()
        return step * (np.round(speed / step + place) - place)
    return speed


def trust_row(R11: float, Q11: float) -> Row:
    """Return errors of adhesion in the sanding test with R11 and Q11 in equation (20), else as printed.

    They are the rms error and the largest in the slide, the range of figure 6, and the rms error after the start.
    """
    changes = (f"noise.readings.wheelset_speed={R11}", f"noise.process.wheelset_speed={Q11}")
    specification = load_specification(LIBRARY / "rig_paper.toml", (*WRONG_START, *changes))
    recording = rig.recording_of_rig(load(Path("rig_sand")))
    time, estimates = recording["time"].values, estimate_of(specification, recording)
    slide, whole = (
        judge(recording, estimates, "group_adhesion", where)
        for where in ((time >= rig.DEEP_SLIDE[0]) & (time <= rig.DEEP_SLIDE[1]), time >= rig.SETTLED)
    )
    names = ("α rms, 4 to 11 s", "α largest, 4 to 11 s", "α rms, whole test")
    return dict(zip(names, (slide.rmse, slide.largest, whole.rmse), strict=True))


def wagon_row(equations: str) -> Row:
    """Return the biases of adhesion and pad friction of the wagon's filter in its stop, for one of `WAGONS`."""
    changes = tuple(f"model.parameters.{parameter}={value}" for parameter, value in WAGONS[equations].items())
    wagon = load_specification(LIBRARY / "wagon.toml", changes)
    recording = recording_of_estimation(wagon)
    estimates = estimate_of(wagon, recording)
    judged = {word: judge(recording, estimates, state) for word, state in _WAGON_STATES.items()}
    return {f"{word} {figure}": getattr(one, figure) for word, one in judged.items() for figure in ("bias", "rmse")}


def headlines() -> list[Finding]:
    """Return errors of adhesion and pad friction in both tests, with both filters, and of the goods wagon."""
    findings: list[Finding] = []
    for test in START_SPEED:
        for row in rows(test, PERIOD, NOISE):
            who = f"{test.replace('_', '-')}, {row['filter']}"
            findings += [
                extreme(f"{who}: adhesion error outside protection events", row["outside"]),
                Finding(f"{who}: longest adhesion error above 0.02", row["longest"], "s", 1.01 * PERIOD),
                mean(f"{who}: adhesion RMSE", row["rmse"]),
                mean(f"{who}: pad friction RMSE", row["pads_rmse"]),
            ]
    wagon = wagon_row("corrected")
    return findings + [mean(f"wagon: {state} RMSE", wagon[f"{word} rmse"]) for word, state in _WAGON_STATES.items()]


def wagon_figure() -> Figure:
    """Draw the wagon with forces and torques, positive as in equations 1 to 6 (figure 1)."""
    drawing, axes = canvas(8, 4.2, "Wagon with forces and torques")
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
    dimension = {"color": palette.GREY, "arrowstyle": "<->", "lw": 0.9}
    arrow(axes, (2.1, 0.3), (5.9, 0.3), "$a$", (4.0, 0.17), **dimension)
    arrow(axes, (3.6, 0.5), (3.6, 2.6), "$h$", (3.45, 1.55), **dimension)
    return drawing


def rig_figure() -> Figure:
    """Draw the roller rig: wheelset, roller, cylinders with load cells, drive (figure 2)."""
    drawing, axes = canvas(8, 4.6, "Roller rig with wheelset, roller, cylinders and drive")
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


def qualitative_figure(slide: pd.DataFrame) -> Figure:
    """Draw adhesion over slip with the points 1 to 3 of the text, and the way of the test between them (figure 3).

    `slide` has the rows of `slide_rows`.
    """
    drawing, panel = style.panels(8, 3.6, label="Creep curve with three points")
    lines = {
        "curve": (palette.BLACK, "-", "creep curve at the release of the brake"),
        "way": (palette.ORANGE, "--", "way from 2 over 1 to 3 in the sanding test"),
    }
    numbers = {"peak": "1", "released": "2", "rolling": "3"}
    for part, places in slide.groupby("part", sort=False):
        if part in lines:
            color, dashes, name = lines[part]
            panel.plot(100 * places["slip"], places["adhesion"], dashes, color=color, label=name, linewidth=1.4)
        else:
            place = 100 * places["slip"].iloc[0], places["adhesion"].iloc[0]
            panel.plot(*place, "o", color=palette.VERMILION, clip_on=False)
            panel.annotate(numbers[part], place, xytext=(7, 5), textcoords="offset points", weight="bold")
    style.dress(panel, x="slip [%]", y="adhesion", xlim=(0, 50), ylim=(0, 0.14))
    style.legend(panel, loc="upper right")
    return drawing


def record_figure(test: str, recording: xarray.Dataset, estimates: Mapping[str, xarray.Dataset]) -> Figure:
    """Draw inputs and readings, adhesion, and pad friction of a test, with what the text states (figures 4 and 5)."""
    time = recording["time"].values
    drawing, (inputs, adhesion, friction) = style.panels(9, 7.5, 3, 1, sharex=True)
    wheelset = style.KMH * _RADIUS * reading_of(recording, "wheelset_speed")
    inputs.plot(time, wheelset, color=palette.BLUE, lw=0.7, label="wheelset, at the rim")
    inputs.plot(time, style.KMH * reading_of(recording, "speed"), color=palette.BLACK, lw=1.4, label="roller")
    inputs.plot(0, START_SPEED[test], "D", color=palette.VERMILION, clip_on=False, label="roller, published")
    style.dress(inputs, y="speed [km/h]", ylim=(0, 1.25 * START_SPEED[test]))
    force = style.second_scale(inputs, "pad force [kN]")
    force.plot(time, reading_of(recording, "pad_force") / 1e3, color=palette.ORANGE, lw=0.6, label="pad force (right)")
    force.set_ylim(0, 150)
    # Above the axes, where no line runs.
    lines = [*inputs.get_lines(), *force.get_lines()]
    style.legend(inputs, handles=lines, loc="lower left", bbox_to_anchor=(0.0, 0.98), ncols=4)
    measured = rig.measured_adhesion(recording)
    friction.plot(time, truth_of(recording, "pad_friction"), color=palette.BLACK, lw=1.2, ls="--", label="true")
    # The noisiest line looks like a band and is drawn first, below the true value.
    for name, estimate in estimates.items():
        mean, look = estimate["mean"], {"color": _COLOURS[name], "label": NAMES[name]}
        adhesion.plot(time, mean.sel(state="group_adhesion"), lw=1.6 if name == "rig-paper" else 0.6, **look)
        friction.plot(time, mean.sel(state="pad_friction"), lw=0.8, **look)
        if name == "rig-paper":
            adhesion.plot(time, measured, color=_LOAD_CELLS, lw=1.4, label="load cells")
    top = 1.35 * float(np.nanmax(measured))
    style.dress(adhesion, y="adhesion", ylim=(-0.01, top))
    style.dress(friction, x="time [s]", y="pad friction", ylim=(0.3, 0.5))
    for begin, end, words, bounds in STATEMENTS[test]:
        for panel in (adhesion, friction):
            panel.axvspan(begin, end, color=palette.SKY, alpha=0.15, linewidth=0)
        for bound in bounds:
            adhesion.plot([begin, end], [bound] * 2, color=palette.BLACK, lw=1.2, ls=":")
        adhesion.text(begin + 0.4, 0.97 * top, f"published:\n{words}", fontsize=8, va="top")
    for panel in (adhesion, friction):
        style.legend(panel, loc="lower left", bbox_to_anchor=(0.0, 0.98), ncols=3)
    friction.set_xlim(0, time[-1])
    return drawing


def over_slip_figure(recording: xarray.Dataset, estimates: Mapping[str, xarray.Dataset]) -> Figure:
    """Draw adhesion over slip and its absolute error in the deep slide of the sanding test (figure 6)."""
    part = recording.sel(time=slice(*rig.DEEP_SLIDE))
    slip, truth = 100 * truth_of(part, "slip"), truth_of(part, "group_adhesion")
    drawing, (above, below) = style.panels(8, 6, 2, 1, sharex=True)
    above.plot(slip, rig.measured_adhesion(part), color=_LOAD_CELLS, lw=2.2, label="load cells")
    for name, estimate in estimates.items():
        adhesion = estimate.sel(time=slice(*rig.DEEP_SLIDE))["mean"].sel(state="group_adhesion").values
        above.plot(slip, adhesion, color=_COLOURS[name], lw=0.7, label=NAMES[name])
        below.plot(slip, np.abs(adhesion - truth), ".", color=_COLOURS[name], ms=2.5, label=NAMES[name])
    for bound, place, words in ((0.1, 0.102, "published: peak 0.1"), (0.05, 0.043, "published: falls to 0.05")):
        above.axhline(bound, color=palette.BLACK, lw=1.0, ls=":")
        above.text(25, place, words, fontsize=8)
    below.axhline(rig.LIMIT, color=palette.BLACK, lw=1.0, ls=":")
    below.text(25, rig.LIMIT + 0.0006, f"published: {rig.LIMIT:g} but for one peak", fontsize=8)
    style.dress(above, y="adhesion", ylim=(0, 0.14))
    style.dress(below, x="slip [%]", y="absolute error of adhesion", xlim=(0, None), ylim=(0, 0.025))
    style.legend(above, loc="upper right")
    return drawing
