"""Runs of the field test of Schwarz, Lüdicke and Heckmann (2019), simulated: filters against true values, and drawings.

Drawings have marks where the text of the paper has numbers.
"""

from collections.abc import Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pymap3d
import xarray
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from schematics import arrow
from scipy.ndimage import uniform_filter1d

from railgrip.estimation.field_test.filtering import (
    GROUPS,
    NAMES,
    NOISES,
    PHYSICAL,
    TEST,
    UNITS,
    FieldRun,
    FilterTask,
    Noise,
    cases,
    filter_of,
    follow,
    load_noise,
    prediction,
    run,
    task_of,
)
from railgrip.estimation.field_test.score import R_WHEEL, limits, score, track_score
from railgrip.estimation.motion import Braking, brake_mask, traction_mask
from railgrip.estimators.belief import Array
from railgrip.estimators.compiled import FilterRecord
from railgrip.recording.samples import reading_of
from railgrip.report import palette, style
from railgrip.report.baseline import Finding, mean
from railgrip.rolling_stock.drawing import drawing as train_drawing
from railgrip.rolling_stock.schema import load_train

TRAIN = Path("vt642")
SEED = cases()[TEST].seed
PUBLISHED = "sensors and physics"
"""Noises of figure 5 in addition to the paper's."""
TIMES = {
    "first drive ends": 20.0, "second drive begins": 38.0, "second drive ends": 70.0, "braking begins": 80.0,
    "standstill": 102.0,
}  # fmt: skip
"""Times in figure 3 [s]."""
START_SPEED = 85.0
"""Speed of case 6 in table 4 [km/h]."""
PRESSURES = (3.4, 2.0)
"""Maximum pressure of motor bogie and Jacobs bogie, §3.2 [bar]."""
OVERBRAKING = 82.0
"""Time of motor bogie 1 in figure 4 [s]."""
OSCILLATION = 81.0
"""Time of the oscillation of estimated brake friction in figure 5 [s], due to the first contact of the pads."""
ADHESIONS = (0.07, 0.15)
"""Adhesion of motor bogie 1 on the slippery section and elsewhere, figure 5."""
MIDDLE = (3.95777632e6, 8.91479549e5, 4.90551675e6)
"""Middle of the test track, earth-centred [m], §3.2; the paper gives its latitude, longitude and height, too."""
_CURVED = 5e-4
"""Curvature that counts as a curve, that of a radius of 2 km [1/m]."""
_SLIDING = 0.02
"""Slip of motor bogie 1 above which it slides; it brakes with less than 1 % elsewhere."""
NOMINAL = 0.35
"""Pad friction of new pads, which normalises the paper's figure."""
COLOURS = {"motor bogie 1": palette.BLUE, "Jacobs bogie, front": palette.ORANGE}
"""Colours of the groups in the figures."""
_DOTTED: Mapping[str, Any] = {"linewidth": 1.0, "linestyle": ":"}
"""Lines of published values."""

Row = dict[str, Any]


def noises() -> dict[str, Noise]:
    """Return the sets of noises: tuned for equation (14), tuned with consistency, and untuned."""
    tuned = {"equation (14)": "paper", "with consistency": "consistent"}
    return {title: load_noise(NOISES / f"{name}.toml") for title, name in tuned.items()} | {PUBLISHED: PHYSICAL}


def estimates_of(field_run: FieldRun) -> tuple[FilterTask, dict[str, FilterRecord]]:
    """Return the braking of a run, and the estimates with each set of noises."""
    task = task_of(field_run.braking, model := prediction())
    filter_ = filter_of(model, task.data.period)
    return task, {title: follow(task, filter_, noise) for title, noise in noises().items()}


def rows(case: str, seed: int) -> list[Row]:
    """Return a row for each set of noises: errors of the filter in a case with a seed, and of the recovered track.

    See `score.score`; figures of `score.track_score` are called `track …`.
    """
    field_run = run((case, cases()[case].model_copy(update={"seed": seed})))
    track = {f"track {name}": value for name, value in track_score(field_run).items()}
    task, estimates = estimates_of(field_run)
    return [{"noises": title} | score(task, estimate) | track for title, estimate in estimates.items()]


def noise_table(noises: Mapping[str, Noise]) -> pd.DataFrame:
    """Return the twelve noises of each set with the bounds of the search; those within a tenth of a decade of a bound
    are marked.
    """
    low, high = np.transpose(limits())
    table = pd.DataFrame({"entry": [f"{name} [{unit}]" for name, unit in zip(NAMES, UNITS, strict=True)]})
    for title, noise in noises.items():
        is_near = (np.minimum(noise.logarithms - low, high - noise.logarithms) < 0.1).tolist()
        table[title] = [f"{value:.2e}{' (bound)' * mark}" for value, mark in zip(noise.values, is_near, strict=True)]
    return table.assign(bounds=[f"{10**a:.0e} – {10**b:.0e}" for a, b in limits()])


def compared_row(case: str, seed: int) -> Row:
    """Return the quantities of a case that the paper has in words or numbers, in SI units; speeds in km/h.

    Of the filter with noises of sensors and physics. `low`, `third`: adhesion of motor bogie 1 on its way into the
    slide, median, and out of it, largest; `level`, `level_behind`: of motor bogie 1 and Jacobs bogie elsewhere;
    `rise_1` …: changes of pad friction from the first to the last second without slide.
    """
    field_run = run((case, cases()[case].model_copy(update={"seed": seed})))
    task, estimates = estimates_of(field_run)
    return {**_of_run(field_run), **_of_braking(task, estimates[PUBLISHED])}


def _of_run(field_run: FieldRun) -> Row:
    plan, course, recording = field_run.plan, field_run.braking.motion.course, field_run.recording
    middle = np.ravel(pymap3d.geodetic2ecef(plan.latitude, plan.longitude, plan.height))
    curves = np.diff(np.append(False, course.curvature > _CURVED).astype(int))
    span = np.sort(plan.place(course.distance[[0, -1]]))
    grades = np.array([place for place, *_ in plan.grades])
    time, speed = recording["time"].values, reading_of(recording, "speed")
    drives = np.flatnonzero(np.diff(traction_mask(recording).astype(int)))[1:4] + 1
    brake = int(np.argmax(brake_mask(recording)))
    # The recording ends at 0.3 m/s; the rest with the mean deceleration of the last second.
    second = round(1.0 / (time[1] - time[0]))
    slope, level = np.polyfit(time[-second:], speed[-second:], 1)
    times = (*time[drives].tolist(), float(time[brake]), float(-level / slope))
    return {
        **dict(zip(("x", "y", "z"), middle.tolist(), strict=True)),
        "apart": float(np.linalg.norm(np.array(MIDDLE) - middle)),
        "curves": int((curves == 1).sum()),
        "grades": int(((grades > span[0]) & (grades < span[1])).sum()),
        **dict(zip(("drive_ends", "drive_begins", "second_ends", "brakes", "stands"), times, strict=True)),
        "speed": style.KMH * float(speed[brake - second : brake].mean()),
    }


def _of_braking(task: FilterTask, estimate: FilterRecord) -> Row:
    recording, brake = task.braking.recording, task.braking.brake
    time = recording["time"].values[1:]
    after = slice(brake - 1, None)
    # They rise to the end; single readings have noise.
    highest = [float(np.median(reading_of(recording, f"cylinder_pressure[{group}]")[-50:])) / 1e5 for group in (1, 2)]
    v, w, adhesion = (estimate.mean[:, columns] for columns in
                      (0, slice(1, 1 + GROUPS), slice(1 + 2 * GROUPS, 1 + 3 * GROUPS)))  # fmt: skip
    slip = 1 - R_WHEEL * w / v[:, None]
    moving = np.flatnonzero((time > time[after][0]) & (v > 2.0))
    slide = moving[slip[moving, 0] > _SLIDING]
    peak = slide[np.argmax(slip[slide, 0])]
    low = float(np.median(adhesion[slide[slide < peak], 0]))
    # Behind the slippery section the wheelsets are accelerated again, over the peak of the creep curve.
    third = float(adhesion[slide[slide > peak], 0].max())
    rolling = np.setdiff1d(moving[time[moving] > time[slide[-1]] + 1.0], slide)
    levels = adhesion[rolling].mean(axis=0)
    pads = estimate.mean[:, 1 + GROUPS : 1 + 2 * GROUPS]
    swing, swings_at = oscillation(time[after], pads[after, 0])
    early, late = (pads[rolling[part]].mean(axis=0) for part in (slice(0, 50), slice(-50, None)))
    return {
        "pressure": highest[0],
        "pressure_behind": highest[1],
        "slides_at": float(time[peak]),
        "slip": float(slip[peak, 0]),
        "slip_behind": float(slip[moving, 1].max()),
        "low": low,
        "third": third,
        "level": float(levels[0]),
        "level_behind": float(levels[1]),
        **{f"rise_{group}": float(b / a - 1) for group, (a, b) in enumerate(zip(early, late, strict=True), start=1)},
        "late_ratio": float(late[0] / late[1]),
        "swing": swing,
        "when": swings_at,
    }


def oscillation(time: Array, friction: Array) -> tuple[float, float]:
    """Return the largest deviation from the mean over two seconds, relative to that mean, and its instant [s].

    Args:
        time: Time from the first application of the brake [s], shape (k,).
        friction: Estimated brake friction of a group, shape (k,).
    """
    smooth = uniform_filter1d(friction, round(2.0 / (time[1] - time[0])))
    deviation = np.abs(friction / smooth - 1)
    return float(deviation.max()), float(time[np.argmax(deviation)])


def headlines() -> list[Finding]:
    """Return the errors of the recovered track and of the filter with each set of noises in case 6."""
    who, (first, *_) = f"field {TEST}", (found := rows(TEST, SEED))
    findings = [
        # By the smoothed motion; 1e-5 are 1 cm over the run.
        Finding(f"{who}: distance, relative error", first["track distance"], "1", 1e-5),
        mean(f"{who}: curvature RMSE", first["track curvature"], "1/m"),
        mean(f"{who}: slope RMSE", first["track slope"]),
        mean(f"{who}: track force RMSE", first["track force"], "N"),
    ]
    frictions = {"adhesion": "adhesion", "pad friction": "pad_friction", "mean pad friction": "mean_pad_friction"}
    for row, name in zip(found, ("paper", "consistent", "physical"), strict=True):
        noise = f"{who}, noises '{name}'"
        findings.append(Finding(f"{noise}: braking distance, relative error", row["distance"], "1", 5e-5))
        findings += [mean(f"{noise}: {words} RMSE", row[figure]) for words, figure in frictions.items()]
    best = f"{who}, the best constant"
    return findings + [mean(f"{best}: {words} RMSE", first[f"{name}_constant"]) for words, name in frictions.items()]


@cache
def case_6() -> tuple[FieldRun, FilterTask, FilterRecord]:
    """Return the run of case 6, its braking, and the estimates with noises of sensors and physics."""
    field_run = run((TEST, cases()[TEST]))
    task, estimates = estimates_of(field_run)
    return field_run, task, estimates[PUBLISHED]


def train_figure() -> Figure:
    """Return the train, and the forces, torques and speeds of equations (1) and (2) (figure 1)."""
    train = load_train(TRAIN)
    drawing = train_drawing(train)
    drawing.set_label("The train, and forces, torques and speeds at a wheelset")
    drawing.has_formulas = True
    drawing.set_size_inches(8.0, 4.2)
    chart = drawing.axes[0]
    chart.set_ylim(-12.5, 5.8)
    chart.set_title("", loc="left")
    drawing.supxlabel(
        "under the rail: axle and its load [t]; brackets hold axles that share a brake valve;\n"
        "lines join those that turn together; dots: brake units of an axle; $F_{z,i}$: wheelset load",
        fontsize=7,
        color=palette.GREY,
    )
    mark = partial(arrow, chart, ha="left", fontsize=8, lw=1.0)
    middle, red = train.length / 2, palette.VERMILION
    mark((middle + 4, 4.8), (middle - 4, 4.8), "speed $v_x$", (middle + 4.4, 4.8), palette.BLUE)
    mark((1.0, 1.9), (6.0, 1.9), "drag $F_{DR}$", (1.2, 2.7), red)
    mark((36.0, 1.9), (40.5, 1.9), "track $F_{TR}$", (35.5, 2.7), red)
    for number, members in enumerate(train.groups, start=1):
        place = float(np.mean([train.axles[index].position for index in members]))
        chart.text(place, -3.3, f"$\\omega_{number}$", color=palette.BLUE, ha="center", va="center", fontsize=9)
    x, y, radius = 16.0, -8.0, 3.4
    chart.plot([x - 7, x + 12], [y - radius] * 2, color=palette.BLACK, linewidth=0.8)
    chart.add_patch(Circle((x, y), radius, facecolor="white", edgecolor=palette.BLACK))
    chart.add_patch(Circle((x, y), 0.6 * radius, facecolor="#E6E6E6", edgecolor=palette.GREY))
    chart.add_patch(Rectangle((x - 0.8, y + 0.45 * radius), 1.6, 0.8, color=palette.GREY))
    chart.text(x - 4.6, y, "wheelset $i$", ha="right", va="center", fontsize=9)
    high, low = y + 0.55 * radius, y - radius
    mark((x, high), (x + 5.5, high), "brake $F_{B,i}$ of each unit at $r_B$", (x + 5.8, high), red)
    mark((x, low), (x + 5.5, low), "creep force $2F_{x,i}$", (x + 5.8, low + 0.7), red)
    mark((x, y), (x, y - 0.8 * radius), "$F_{z,i}$", (x + 0.3, y - 0.3 * radius), red)
    mark((x + 3.7, y - 0.6), (x + 3.3, y + 1.4), "resistance and traction $M_{W,i}$", (x + 4.2, y), red)
    top = y + 1.14 * radius
    begin, end = (x + 0.6, top), (x - 2.9, y + 0.7 * radius)
    mark(begin, end, "rotation $\\omega_i$", (x + 0.9, top), palette.BLUE, connectionstyle="arc3,rad=0.3")
    return drawing


def track_figure(run: FieldRun) -> Figure:
    """Return the track of a run: map, heading and curvature, height and slope; recovered and true (figure 2)."""
    course = run.braking.motion.course
    place = run.plan.place(course.distance)
    drawing = style.figure(8.8, 4.4)
    grid = drawing.add_gridspec(2, 2, width_ratios=(1, 1.6))
    chart = drawing.add_subplot(grid[:, 0])
    reference = run.plan.alignment().plan().horizontal_at(place)
    # Both in the frame of the plan: the recovered course has its own origin.
    shift = (reference - course.horizontal).mean(axis=0)
    chart.plot(*reference.T[::-1], color=palette.GREY, linewidth=4, alpha=0.5, label="laid")
    chart.plot(*(course.horizontal + shift).T[::-1], color=palette.BLUE, linewidth=1.4, label="recovered")
    chart.plot(*reference[0][::-1], "o", color=palette.BLACK, markersize=5)
    # The origin of the frame is the point whose position is given.
    chart.plot(0, 0, "D", color=palette.BLACK, markersize=6, markerfacecolor="none", label="published middle")
    chart.annotate("start", reference[0][::-1], textcoords="offset points", xytext=(8, 0), fontsize=8)
    chart.set_aspect("equal")
    style.dress(chart, x="east [m]", y="north [m]", title="map")
    style.legend(chart, loc="center right", bbox_to_anchor=(1.15, 0.4))
    slope, curvature = run.plan_geometry(course.distance)
    for row, (left, true, estimate, unit, label, title) in enumerate(
        (
            (np.degrees(course.heading), 1e3 * curvature, 1e3 * course.curvature, "curvature [1/km]",
             "heading [°]", "heading and curvature"),
            (course.height, 1e3 * slope, 1e3 * course.slope, "slope [‰]", "height [m]", "height and slope"),
        )
    ):  # fmt: skip
        panel = drawing.add_subplot(grid[row, 1])
        panel.plot(course.distance, left, color=palette.BLACK, linewidth=1.2)
        if row:
            middle = abs(run.plan.middle - run.plan.start)
            panel.plot(middle, run.plan.height, "D", color=palette.BLACK, markersize=6, markerfacecolor="none")
        style.dress(panel, y=label, title=title, x="distance [m]" if row else "")
        other = style.second_scale(panel, unit, palette.BLUE)
        other.plot(course.distance, true, color=palette.GREY, linewidth=3.5, alpha=0.5, label="laid")
        other.plot(course.distance, estimate, color=palette.BLUE, linewidth=1.1, label="recovered")
        if row:
            style.legend(other, loc="upper center")
    return drawing


def speed_figure(run: xarray.Dataset) -> Figure:
    """Return the speed of the whole run (figure 3)."""
    drawing, panel = style.panels(9, 3)
    time = run["time"].values
    panel.plot(time, style.KMH * reading_of(run, "speed"), color=palette.BLUE, linewidth=1.4, label="optical sensor")
    for on, colour, alpha, label in (
        (traction_mask(run), palette.GREEN, 0.12, "driving"),
        (brake_mask(run), palette.VERMILION, 0.35, "braking"),
    ):
        shade = {"transform": panel.get_xaxis_transform(), "color": colour, "alpha": alpha, "linewidth": 0}
        panel.fill_between(time, 0, 1, where=on, label=label, **shade)
    for number, at in enumerate(TIMES.values()):
        label = None if number else "published times"
        panel.axvline(at, color=palette.BLACK, linewidth=0.8, linestyle=":", label=label)
    ends = [TIMES["braking begins"], TIMES["standstill"]], [START_SPEED, 0]
    mark = {"color": palette.BLACK, "markersize": 5, "markerfacecolor": "none", "clip_on": False, "zorder": 5}
    panel.plot(*ends, "D", label="published speeds", **mark)
    limits = {"xlim": (0, max(time[-1], TIMES["standstill"]) + 2), "ylim": (0, None)}
    style.dress(panel, x="time [s]", y="speed [km/h]", **limits)
    style.legend(panel, ncols=5, loc="lower left", bbox_to_anchor=(0, 1))
    return drawing


def readings_figure(braking: Braking) -> Figure:
    """Return the inputs and readings of the filter: pressures, speeds (figure 4)."""
    recording = braking.recording
    time, speed = recording["time"].values, style.KMH * reading_of(recording, "speed")
    drawing, (upper, lower) = style.panels(9, 5, 2, 1, sharex=True)
    lower.plot(time, speed, color=palette.BLACK, linewidth=1.4, label="train, optical")
    for number, (name, colour) in enumerate(COLOURS.items(), start=1):
        pressure = reading_of(recording, f"cylinder_pressure[{number}]") / 1e5
        rim = style.KMH * R_WHEEL * reading_of(recording, f"wheelset_speed[{number}]")
        upper.plot(time, pressure, color=colour, linewidth=1.2, label=name)
        lower.plot(time, rim, color=colour, linewidth=1.0, label=f"{name}, rim")
    for (name, colour), highest in zip(COLOURS.items(), PRESSURES, strict=True):
        upper.axhline(highest, color=colour, label=f"{name}, published highest", **_DOTTED)
    lower.axvline(OVERBRAKING, color=palette.BLACK, label="published slide of motor bogie 1", **_DOTTED)
    style.dress(upper, y="cylinder pressure [bar]", ylim=(-0.1, 3.8))
    style.dress(lower, x="time [s]", y="speed [km/h]", xlim=(time[braking.brake] - 3, time[-1]))
    style.legend(upper, ncols=2, loc="lower right")
    style.legend(lower, loc="upper right")
    return drawing


def friction_figure(task: FilterTask, estimate: FilterRecord) -> Figure:
    """Return pad friction over time and adhesion over slip, estimated and true, with `PUBLISHED` noises (figure 5)."""
    assert task.truth is not None
    time = task.braking.recording["time"].values[1:]
    drawing, (pads, curve) = style.panels(11, 3.4, 1, 2)
    window = time >= time[task.braking.brake - 1] + 0.3
    for group, (name, colour) in enumerate(COLOURS.items()):
        columns = [1 + kind * GROUPS + group for kind in range(3)]
        (w, pad, adhesion), (true_w, true_pad, true_adhesion) = estimate.mean[:, columns].T, task.truth[:, columns].T
        sd = np.sqrt(estimate.variance[:, columns[1]])
        pad, sd, true_pad = pad / NOMINAL, sd / NOMINAL, true_pad / NOMINAL
        style.band(pads, time[window], (pad - 2 * sd)[window], (pad + 2 * sd)[window], colour, 0.15)
        pads.plot(time[window], pad[window], color=colour, linewidth=1.1, label=name)
        pads.plot(time[window], true_pad[window], color=colour, linewidth=1.1, linestyle="--", label=f"{name}, true")
        # Below walking pace slip is mostly noise of the sensors.
        moving = window & (task.truth[:, 0] > 2.0)
        slip, true_slip = 100 * (1 - R_WHEEL * w / estimate.mean[:, 0]), 100 * (1 - R_WHEEL * true_w / task.truth[:, 0])
        behind = {"color": palette.GREY, "linewidth": 2.5, "alpha": 0.5, "label": None if group else "true"}
        curve.plot(true_slip[moving], true_adhesion[moving], **behind)
        curve.plot(slip[moving], adhesion[moving], ".", color=colour, markersize=2.5, label=name)
    pads.axvline(OSCILLATION, color=palette.BLACK, label="published oscillation", **_DOTTED)
    # No level of the paper is so high: the wheelsets are accelerated over the peak of the creep curve.
    curve.text(6, 0.215, "motor bogie 1, out of the slide", fontsize=8, color=palette.BLUE)
    for number, level in enumerate(ADHESIONS):
        label = None if number else "published, motor bogie 1"
        curve.axhline(level, color=palette.BLACK, label=label, **_DOTTED)
    title = f"{PUBLISHED}: adhesion over slip"
    style.dress(curve, x="slip [%]", y="adhesion", title=title, xlim=(-1, 20), ylim=(-0.02, 0.24))
    title = f"{PUBLISHED}: pad friction ±2σ"
    style.dress(pads, x="time [s]", y="pad friction over 0.35", title=title, ylim=(0.7, 1.4))
    style.legend(pads, ncols=2, loc="lower right")
    style.legend(curve, loc="lower right", markerscale=3)
    return drawing
