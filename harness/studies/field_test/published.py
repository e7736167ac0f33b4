"""Figures 1 to 5 of Schwarz, Lüdicke and Heckmann (2019) in comparison with the simulated case 6."""

from collections.abc import Sequence

import numpy as np
import pymap3d
from scipy.ndimage import uniform_filter1d

from railgrip.estimation.braking import brake_mask, traction_mask
from railgrip.estimators.belief import Array
from railgrip.estimators.compiled import FilterRecord
from railgrip.recording.samples import reading_of
from railgrip.report import style
from railgrip.report.table import ReportTable
from railgrip.rolling_stock.schema import Train
from railgrip.studies.field_test.filtering import GROUPS, FilterTask
from railgrip.studies.field_test.runs import FieldRun
from railgrip.studies.field_test.score import R_WHEEL
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
