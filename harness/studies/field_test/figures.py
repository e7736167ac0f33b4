"""Figures 1 to 5 of Schwarz, Lüdicke and Heckmann (2019): comparison with the simulated case 6, and drawings of it.

Drawings have marks where the text of the paper has numbers.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import pymap3d
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from scipy.ndimage import uniform_filter1d

from railgrip.estimation.motion import Braking, brake_mask, traction_mask
from railgrip.estimators.belief import Array
from railgrip.estimators.compiled import FilterRecord
from railgrip.recording.samples import reading_of
from railgrip.report import palette, style
from railgrip.report.table import ReportTable
from railgrip.rolling_stock.drawing import drawing as train_drawing
from railgrip.rolling_stock.schema import Train
from railgrip.studies.field_test.filtering import GROUPS, FieldRun, FilterTask
from railgrip.studies.field_test.score import R_WHEEL, Sweep
from railgrip.studies.papers.pages import PaperRow, comparison

TIMES = {
    "first drive ends": 20.0, "second drive begins": 38.0, "second drive ends": 70.0, "braking begins": 80.0,
    "standstill": 102.0,
}  # fmt: skip
"""Times in figure 3 [s]."""
_FOLLOWING = ("first drive ends", "second drive ends")
"""Times that follow from the train; demands and slopes of case 6 were chosen to match the others."""
START_SPEED = 85.0
"""Speeds of case 6 in table 4 [km/h]."""
PRESSURES = (3.4, 2.0)
"""Maximum pressure of motor bogie and Jacobs bogie, §3.2 [bar]."""
OVERBRAKING = 82.0
"""Times of motor bogie 1 in figure 4 [s]."""
OSCILLATION = 81.0
"""Duration of the oscillation of estimated brake friction in figure 5 [s], due to the first contact of the pads."""
ADHESIONS = (0.07, 0.15)
"""Adhesion of motor bogie 1 on the slippery section and elsewhere, figure 5."""
MIDDLE = (3.95777632e6, 8.91479549e5, 4.90551675e6)
"""Middle of the test track, earth-centred [m], §3.2; the paper gives its latitude, longitude and height, too."""
LOADS = (13.4, 14.1, 14.5, 14.5, 14.1, 13.4)
"""Masses on the wheelsets, Table 3 [t]."""

CURVED = 5e-4
"""Curvature that counts as a curve, that of a radius of 2 km [1/m]."""
SLIDING = 0.02
"""Slip of motor bogie 1 above which it slides; it brakes with less than 1 % elsewhere."""


def compare_with_paper(train: Train, run: FieldRun, task: FilterTask, estimate: FilterRecord) -> ReportTable:
    """Return the table of published and simulated quantities.

    Args:
        train: Train of the scenario.
        run: Case 6.
        task: Braking of that case.
        estimate: Estimates of the filter over that braking.
    """
    return comparison([*_of_track(train, run), *_of_drive(run), *_of_braking(task, estimate)])


def _of_track(train: Train, run: FieldRun) -> Sequence[PaperRow]:
    plan, course = run.plan, run.braking.motion.course
    middle = pymap3d.geodetic2ecef(plan.latitude, plan.longitude, plan.height)
    curves = np.diff(np.append(False, course.curvature > CURVED).astype(int))
    span = np.sort(plan.place(course.distance[[0, -1]]))
    grades = np.array([place for place, *_ in plan.grades])
    published, ours = (" / ".join(f"{float(x) / 1e3:.3f}" for x in place) + " km" for place in (MIDDLE, middle))
    changes = int(((grades > span[0]) & (grades < span[1])).sum())
    return (
        PaperRow("Fig. 1", "independent rotations", 4, len(train.groups), "{:d}", is_chosen=True),
        PaperRow("Fig. 1", "mass, sum of Table 3", sum(LOADS), train.mass / 1e3, "{:.1f} t", is_chosen=True),
        PaperRow("Fig. 2", "middle of the track, earth-centred", published, ours,
                 difference=f"{np.linalg.norm(np.array(MIDDLE) - np.ravel(middle)):.1f} m"),
        PaperRow("Fig. 2", "curves to the right", 2, int((curves == 1).sum()), "{:d}", is_chosen=True),
        PaperRow("Fig. 2", "changes of slope", 3, changes, "{:d}", is_chosen=True),
    )  # fmt: skip


def _of_drive(run: FieldRun) -> Sequence[PaperRow]:
    recording = run.recording
    time, speed = recording["time"].values, reading_of(recording, "speed")
    drives = np.flatnonzero(np.diff(traction_mask(recording).astype(int)))[1:4] + 1
    brake = int(np.argmax(brake_mask(recording)))
    # The recording ends at 0.3 m/s; the rest with the mean deceleration of the last second.
    second = round(1.0 / (time[1] - time[0]))
    decelerating = np.polyfit(time[-second:], speed[-second:], 1)
    standstill = float(-decelerating[1] / decelerating[0])
    begin = float(time[brake])
    ours = (*time[drives].tolist(), begin, standstill)
    return (
        *(PaperRow("Fig. 3", name, at, value, "{:.1f} s", f"{value - at:+.1f} s".replace("-", "−"),
                   is_chosen=name not in _FOLLOWING)
          for (name, at), value in zip(TIMES.items(), ours, strict=True)),
        PaperRow("Fig. 3", "time of braking", TIMES["standstill"] - TIMES["braking begins"], standstill - begin,
                 "{:.1f} s", is_chosen=True),
        PaperRow("Fig. 3", "speed when braking begins", START_SPEED,
                 style.KMH * float(speed[brake - second : brake].mean()), "{:.1f} km/h", is_chosen=True),
    )  # fmt: skip


def _of_braking(task: FilterTask, estimate: FilterRecord) -> Sequence[PaperRow]:
    recording, brake = task.braking.recording, task.braking.brake
    time = recording["time"].values[1:]
    after = slice(brake - 1, None)
    # They rise to the end; single readings have noise.
    highest = [float(np.median(reading_of(recording, f"cylinder_pressure[{group}]")[-50:])) / 1e5 for group in (1, 2)]
    v, w, adhesion = (estimate.mean[:, columns] for columns in
                      (0, slice(1, 1 + GROUPS), slice(1 + 2 * GROUPS, 1 + 3 * GROUPS)))  # fmt: skip
    slip = 1 - R_WHEEL * w / v[:, None]
    moving = np.flatnonzero((time > time[after][0]) & (v > 2.0))
    slide = moving[slip[moving, 0] > SLIDING]
    peak = slide[np.argmax(slip[slide, 0])]
    low = float(np.median(adhesion[slide[slide < peak], 0]))
    # Behind the slippery section the wheelsets are accelerated again, over the peak of the creep curve.
    third = float(adhesion[slide[slide > peak], 0].max())
    rolling = np.setdiff1d(moving[time[moving] > time[slide[-1]] + 1.0], slide)
    levels = adhesion[rolling].mean(axis=0)
    pads = estimate.mean[:, 1 + GROUPS : 1 + 2 * GROUPS]
    swing, swings_at = oscillation(time[after], pads[after, 0])
    early, late = (pads[rolling[part]].mean(axis=0) for part in (slice(0, 50), slice(-50, None)))
    rises = " / ".join(f"{100 * (b / a - 1):+.1f} %" for a, b in zip(early, late, strict=True)).replace("-", "−")
    return (
        *(PaperRow("Fig. 4", f"highest pressure, {bogie}", published, ours, "{:.2f} bar", is_chosen=True)
          for bogie, published, ours in zip(("motor bogie", "Jacobs bogie"), PRESSURES, highest, strict=True)),
        PaperRow("Fig. 4", "largest slip of motor bogie 1", OVERBRAKING, float(time[peak]), "at {:.1f} s",
                 is_chosen=True),
        PaperRow("Fig. 4", "overbraking of the wheelset behind", "not distinct",
                 f"{100 * slip[moving, 1].max():.1f} % slip, motor bogie 1 {100 * slip[peak, 0]:.1f} %",
                 is_chosen=True),
        PaperRow("Fig. 5", "adhesion of motor bogie 1, slippery", ADHESIONS[0], low, is_chosen=True),
        PaperRow("Fig. 5", "adhesion of motor bogie 1, elsewhere", ADHESIONS[1], float(levels[0])),
        PaperRow("Fig. 5", "adhesion of motor bogie 1 on its way out of the slide", "no third level",
                 f"up to {third:.2f}"),
        PaperRow("Fig. 5", "adhesion of Jacobs bogie over that of motor bogie 1", "below 1",
                 float(levels[1] / levels[0])),
        PaperRow("Fig. 5", "brake friction over the braking", "rises", rises),
        PaperRow("Fig. 5", "brake friction of motor bogie 1 over that of Jacobs bogie, at last", "above 1",
                 float(late[0] / late[1])),
        PaperRow("Fig. 5", "oscillation of brake friction, motor bogie 1", f"major, at {OSCILLATION:.0f} s",
                 f"{100 * swing:.0f} %, at {swings_at:.1f} s"),
    )  # fmt: skip


def oscillation(time: Array, friction: Array) -> tuple[float, float]:
    """Return the largest deviation from the mean over two seconds, relative to that mean, and its instant [s].

    Args:
        time: Time from the first application of the brake [s], shape (k,).
        friction: Estimated brake friction of a group, shape (k,).
    """
    smooth = uniform_filter1d(friction, round(2.0 / (time[1] - time[0])))
    deviation = np.abs(friction / smooth - 1)
    return float(deviation.max()), float(time[np.argmax(deviation)])


MB1, JTB1 = 0, 1
NOMINAL = 0.35
"""Pad friction of new pads, which normalises the paper's figure."""

GROUP_NAMES = ("motor bogie 1", "Jacobs bogie, front", "Jacobs bogie, rear", "motor bogie 2")
COLOURS = (palette.BLUE, palette.ORANGE, palette.GREEN, palette.PURPLE)


def train_figure(train: Train) -> Figure:
    """Return the train, and the forces, torques and speeds of equations (1) and (2) (figure 1)."""
    drawing = train_drawing(train)
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
    middle = train.length / 2
    _arrow(chart, (middle + 4, 4.8), (middle - 4, 4.8), palette.BLUE, "speed $v_x$", (middle + 4.4, 4.8))
    _arrow(chart, (1.0, 1.9), (6.0, 1.9), palette.VERMILION, "drag $F_{DR}$", (1.2, 2.7))
    _arrow(chart, (36.0, 1.9), (40.5, 1.9), palette.VERMILION, "track $F_{TR}$", (35.5, 2.7))
    for number, members in enumerate(train.groups, start=1):
        place = float(np.mean([train.axles[index].position for index in members]))
        chart.text(place, -3.3, f"$\\omega_{number}$", color=palette.BLUE, ha="center", va="center", fontsize=9)
    x, y, radius = 16.0, -8.0, 3.4
    chart.plot([x - 7, x + 12], [y - radius] * 2, color=palette.BLACK, linewidth=0.8)
    chart.add_patch(Circle((x, y), radius, facecolor="white", edgecolor=palette.BLACK))
    chart.add_patch(Circle((x, y), 0.6 * radius, facecolor="#E6E6E6", edgecolor=palette.GREY))
    chart.add_patch(Rectangle((x - 0.8, y + 0.45 * radius), 1.6, 0.8, color=palette.GREY))
    chart.text(x - 4.6, y, "wheelset $i$", ha="right", va="center", fontsize=9)
    _arrow(chart, (x, y + 0.55 * radius), (x + 5.5, y + 0.55 * radius), palette.VERMILION,
           "brake $F_{B,i}$ of each unit at $r_B$", (x + 5.8, y + 0.55 * radius))  # fmt: skip
    _arrow(chart, (x, y - radius), (x + 5.5, y - radius), palette.VERMILION, "creep force $2F_{x,i}$",
           (x + 5.8, y - radius + 0.7))  # fmt: skip
    _arrow(chart, (x, y), (x, y - 0.8 * radius), palette.VERMILION, "$F_{z,i}$", (x + 0.3, y - 0.3 * radius))
    _arrow(chart, (x + 3.7, y - 0.6), (x + 3.3, y + 1.4), palette.VERMILION,
           "resistance and traction $M_{W,i}$", (x + 4.2, y))  # fmt: skip
    _arrow(chart, (x + 0.6, y + 1.14 * radius), (x - 2.9, y + 0.7 * radius), palette.BLUE, "rotation $\\omega_i$",
           (x + 0.9, y + 1.14 * radius), bend=0.3)  # fmt: skip
    return drawing


def _arrow(
    chart: Axes,
    begin: tuple[float, float],
    end: tuple[float, float],
    colour: str,
    words: str,
    place: tuple[float, float],
    bend: float = 0.0,
) -> None:
    shape = {"arrowstyle": "-|>", "color": colour, "connectionstyle": f"arc3,rad={bend}", "shrinkA": 0, "shrinkB": 0}
    chart.annotate("", end, begin, arrowprops=shape)
    chart.text(*place, words, color=colour, va="center", fontsize=8)


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
        (traction_mask(run), palette.GREEN, 0.12, "driving"), (brake_mask(run), palette.VERMILION, 0.35, "braking"),
    ):  # fmt: skip
        panel.fill_between(time, 0, 1, where=on, transform=panel.get_xaxis_transform(), color=colour, alpha=alpha,
                           linewidth=0, label=label)  # fmt: skip
    for number, at in enumerate(TIMES.values()):
        panel.axvline(at, color=palette.BLACK, linewidth=0.8, linestyle=":",
                      label=None if number else "published times")  # fmt: skip
    panel.plot([TIMES["braking begins"], TIMES["standstill"]], [START_SPEED, 0], "D", color=palette.BLACK, markersize=5,
               markerfacecolor="none", label="published speeds", clip_on=False, zorder=5)  # fmt: skip
    style.dress(panel, x="time [s]", y="speed [km/h]")
    panel.set_xlim(0, max(time[-1], TIMES["standstill"]) + 2)
    panel.set_ylim(0, None)
    style.legend(panel, ncols=5, loc="lower left", bbox_to_anchor=(0, 1))
    return drawing


def readings_figure(braking: Braking) -> Figure:
    """Return the inputs and readings of the filter: pressures, speeds (figure 4)."""
    recording = braking.recording
    time = recording["time"].values
    drawing, (upper, lower) = style.panels(9, 5, 2, 1, sharex=True)
    for group in (MB1, JTB1):
        pressure = reading_of(recording, f"cylinder_pressure[{group + 1}]") / 1e5
        upper.plot(time, pressure, color=COLOURS[group], linewidth=1.2, label=GROUP_NAMES[group])
    lower.plot(
        time, style.KMH * reading_of(recording, "speed"), color=palette.BLACK, linewidth=1.4, label="train, optical"
    )
    for group in (MB1, JTB1):
        rim = style.KMH * R_WHEEL * reading_of(recording, f"wheelset_speed[{group + 1}]")
        lower.plot(time, rim, color=COLOURS[group], linewidth=1.0, label=f"{GROUP_NAMES[group]}, rim")
    for group, highest in zip((MB1, JTB1), PRESSURES, strict=True):
        upper.axhline(highest, color=COLOURS[group], linewidth=1.0, linestyle=":",
                      label=f"{GROUP_NAMES[group]}, published highest")  # fmt: skip
    lower.axvline(
        OVERBRAKING, color=palette.BLACK, linewidth=1.0, linestyle=":", label="published slide of motor bogie 1"
    )
    style.dress(upper, y="cylinder pressure [bar]")
    style.dress(lower, x="time [s]", y="speed [km/h]")
    upper.set_ylim(-0.1, 3.8)
    style.legend(upper, ncols=2, loc="lower right")
    style.legend(lower, loc="upper right")
    upper.set_xlim(time[braking.brake] - 3, time[-1])
    return drawing


def friction_figure(task: FilterTask, estimates: Mapping[str, FilterRecord]) -> Figure:
    """Return pad friction over time and adhesion over slip, estimated and true, a row for each tuning (figure 5)."""
    assert task.truth is not None
    time = task.braking.recording["time"].values[1:]
    drawing, rows = style.panels(11, 3.4 * len(estimates), len(estimates), 2, squeeze=False, sharex="col", sharey="col")
    window = time >= time[task.braking.brake - 1] + 0.3
    for (pads, curve), (title, estimate) in zip(rows, estimates.items(), strict=True):
        for group in (MB1, JTB1):
            mean = estimate.mean[:, 1 + GROUPS + group] / NOMINAL
            sd = np.sqrt(estimate.variance[:, 1 + GROUPS + group]) / NOMINAL
            true = task.truth[:, 1 + GROUPS + group] / NOMINAL
            style.band(pads, time[window], (mean - 2 * sd)[window], (mean + 2 * sd)[window], COLOURS[group], 0.15)
            pads.plot(time[window], mean[window], color=COLOURS[group], linewidth=1.1, label=GROUP_NAMES[group])
            pads.plot(time[window], true[window], color=COLOURS[group], linewidth=1.1, linestyle="--",
                      label=f"{GROUP_NAMES[group]}, true")  # fmt: skip
            # Below walking pace slip is mostly noise of the sensors.
            moving = window & (task.truth[:, 0] > 2.0)
            v, w = estimate.mean[:, 0], estimate.mean[:, 1 + group]
            slip = 100 * (1 - R_WHEEL * w / v)
            alpha = estimate.mean[:, 1 + 2 * GROUPS + group]
            true_slip = 100 * (1 - R_WHEEL * task.truth[:, 1 + group] / task.truth[:, 0])
            curve.plot(true_slip[moving], task.truth[moving, 1 + 2 * GROUPS + group], color=palette.GREY, linewidth=2.5,
                       alpha=0.5, label="true" if group == MB1 else None)  # fmt: skip
            curve.plot(slip[moving], alpha[moving], ".", color=COLOURS[group], markersize=2.5, label=GROUP_NAMES[group])
        pads.axvline(OSCILLATION, color=palette.BLACK, linewidth=1.0, linestyle=":", label="published oscillation")
        # No level of the paper is so high: the wheelsets are accelerated over the peak of the creep curve.
        curve.text(6, 0.215, "motor bogie 1, out of the slide", fontsize=8, color=COLOURS[MB1])
        for number, level in enumerate(ADHESIONS):
            curve.axhline(level, color=palette.BLACK, linewidth=1.0, linestyle=":",
                          label=None if number else "published, motor bogie 1")  # fmt: skip
        widest = 2 * np.sqrt(estimate.variance[window, 1 + GROUPS + MB1].max()) / NOMINAL
        beyond = f" (up to ±{widest:.1f}, beyond the panel)" if widest > 1.0 else ""
        style.dress(pads, y="pad friction over 0.35", title=f"{title}: pad friction ±2σ{beyond}")
        style.dress(curve, y="adhesion", title=f"{title}: adhesion over slip")
        pads.set_ylim(0.7, 1.4)
        curve.set_ylim(-0.02, 0.24)
        curve.set_xlim(-1, 20)
    style.legend(rows[0, 0], ncols=2, loc="lower right")
    style.legend(rows[0, 1], loc="lower right", markerscale=3)
    rows[-1, 0].set_xlabel("time [s]")
    rows[-1, 1].set_xlabel("slip [%]")
    return drawing


def degeneracy_figure(common: Sweep, trusted: Sweep) -> Figure:
    """Return equation (14) and the true errors over two ways to change noises."""
    drawing, panels = style.panels(11, 4, 1, 2)
    for panel, sweep, x, title in (
        (panels[0], common, "factor on R, Q and the first covariance", "a common factor does not change equation (14)"),
        (panels[1], trusted, "factor on R alone", "equation (14) rewards repeating the readings"),
    ):
        for name, colour, label in (
            ("deviation", palette.BLACK, "equation (14) [m/s]"),
            ("adhesion", palette.BLUE, "RMSE of adhesion"),
            ("pad_friction", palette.ORANGE, "RMSE of pad friction"),
        ):
            panel.loglog(sweep["factor"], sweep[name], color=colour, marker="o", markersize=3, label=label)
        panel.loglog(
            sweep["factor"], sweep["nees"], color=palette.VERMILION, linestyle="--", label="NEES, 1 if consistent"
        )
        style.dress(panel, x=x, title=title)
    style.legend(panels[0])
    return drawing
