"""Runs on the simulated roller rig of Schwarz and Keck (2020), §4, and measures of estimates of adhesion."""

import math
from pathlib import Path
from typing import Final

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.base.arrays import Mask, Vector
from railgrip.estimation.judgement import errors
from railgrip.recording.faults import intervals
from railgrip.recording.samples import evenly, period_of, reading_of, truth_of, with_signals
from railgrip.scenario.load import load
from railgrip.scenario.schema import Scenario
from railgrip.simulate.run import run_stop
from railgrip.trace.bound import Contact

LIMIT = 0.02
"""Limit of the error of adhesion outside protection events, as stated in the paper."""
RECOVERY = 0.1
"""Time within which a larger error is corrected, as stated in the paper [s]."""
SETTLED = 0.5
"""Seconds after the start in which estimates are not judged."""
DEEP_SLIDE = (4.0, 11.0)
"""Time range that is drawn as figure 6 in the sanding test [s]: adhesion passes its peak, falls, recovers and goes to
zero. The paper describes this range with figure 5 and does not state that of figure 6."""
_SLIDING: Final = 0.1
"""Slip above which the wheelset slides: several times the slip of the peak."""
_FALLEN: Final = 1 / np.e
"""Remaining share of the pad force when the protection has responded: after one time constant of a lag."""
_PRESSED: Final = 3e3
"""Pad force from which the brake counts as applied [N]: 30 times the noise of its load cell."""
_LONGEST_STEP: Final = 10e-3


def resample(name: str, period: float, noise: float) -> Scenario:
    """Return a test of the rig with a sampling period [s] and a standard deviation of the roller's encoder [m/s]."""
    periods = dict.fromkeys(("estimator", "trace"), period) | {"controller": max(period, 0.01)}
    # The plant takes equal steps of at most 10 ms from sample to sample: longer ones miss how the wheelset slides.
    periods["communication"] = period / math.ceil(round(period / _LONGEST_STEP, 9))
    changes = [f'periods.{who}="{each:.12g} s"' for who, each in periods.items()]
    return load(Path(name), [*changes, f'sensors.noise.speed="{noise} m/s"'])


def recording_of_rig(scenario: Scenario) -> xarray.Dataset:
    """Return a run on the rig, with `protecting`: 1 while the protection reduces the demanded brake.

    Raises:
        PlantFailed: The plant refused a step.
    """
    trace = evenly(run_stop(scenario).stored_trace, scenario.name)
    # A row has the decision before it; its own decision is in the next row.
    protection = (trace["demand"] < trace["driver_demand"]).values[:, 0]
    return with_signals(trace, {"protecting": (np.append(protection[1:], protection[-1:]), "1")})


def measured_adhesion(recording: xarray.Dataset) -> Vector:
    """Return adhesion by the load cells of the rig, equation 2."""
    return reading_of(recording, "contact_force") / reading_of(recording, "wheelset_load")


def outside_events(recording: xarray.Dataset, settled: float) -> Mask:
    """Return the samples outside protection events, shape (k,).

    An event lasts while the protection reduces the driver's demand, and `RECOVERY` longer. The first `settled` seconds
    are omitted, in which the estimate converges from its start value.
    """
    time = recording["time"].values
    busy = reading_of(recording, "protecting") > 0.5
    last = np.where(busy, time, -np.inf)
    since = time - np.maximum.accumulate(last)
    return (since > RECOVERY) & (time >= time[0] + settled)


def excursions(recording: xarray.Dataset, estimates: xarray.Dataset, settled: float) -> dict[str, float]:
    """Return measures of an estimate of adhesion outside `LIMIT`.

    `largest`: error anywhere after the start has settled; `outside`: outside protection events;
    `samples_outside`: over the limit outside events; `excursions`: stretches over the limit, anywhere; `longest` of
    them [s]; `kept`: whether the paper's statement holds, within the limit outside events, corrected in time in them;
    `peaks`: stretches over the limit in `DEEP_SLIDE`.
    """
    time = recording["time"].values
    after = time >= time[0] + settled
    error = np.abs(errors(recording, estimates, "group_adhesion"))
    outside = outside_events(recording, settled)
    # A filter that ended early counts as lost: NaN is over the limit.
    over = ~(error <= LIMIT) & after
    lengths = _stretches(over) * period_of(recording)
    outside_and_over, longest = int(np.sum(over & outside)), float(np.max(lengths, initial=0.0))
    return {
        "largest": float(np.max(error[after], initial=0.0)),
        "outside": float(np.max(error[outside], initial=0.0)),
        "samples_outside": outside_and_over,
        "excursions": lengths.size,
        "longest": longest,
        "kept": outside_and_over == 0 and longest <= RECOVERY,
        "peaks": _stretches(over & _in_deep_slide(recording)).size,
    }


def slides(recording: xarray.Dataset) -> int:
    """Return the number of slides in the time range of figure 6."""
    return _stretches((truth_of(recording, "slip") > _SLIDING) & _in_deep_slide(recording)).size


def _in_deep_slide(recording: xarray.Dataset) -> Mask:
    time = recording["time"].values
    return (time >= DEEP_SLIDE[0]) & (time <= DEEP_SLIDE[1])


def _stretches(mask: Mask) -> NDArray[np.intp]:
    return np.array([last - first + 1 for first, last in intervals(mask)], dtype=np.intp)


def points_of_slide(recording: xarray.Dataset, contact: Contact) -> dict[str, tuple[Vector, Vector]]:
    """Return slips and adhesions of figure 3 in the slide of figure 6, of its points and lines.

    `curve`: creep curve at the release of the brake; `peak` of it, point 1; `released`: the largest slip, point 2;
    `rolling`: the wheelset rolls again, point 3; `way`: samples from 2 to 3.
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
        "peak": (slips[peak : peak + 1], curve[peak : peak + 1]),
        "released": (slip[release : release + 1], adhesion[release : release + 1]),
        "rolling": (slip[again : again + 1], adhesion[again : again + 1]),
    }


def adhesion_of_slide(recording: xarray.Dataset) -> dict[str, float]:
    """Return measured adhesion in the slide of figure 6: before and at the largest slip, after it, and the smallest."""
    part = recording.sel(time=slice(*DEEP_SLIDE))
    slip, adhesion = truth_of(part, "slip"), measured_adhesion(part)
    largest = int(np.argmax(slip))
    again = largest + int(np.argmax(slip[largest:] < 1e-3))
    return {
        "first_peak": float(np.max(adhesion[:largest])),
        "after_fall": float(adhesion[largest]),
        "after_release": float(np.max(adhesion[largest:again])),
        "at_last": float(np.min(adhesion[largest:])),
    }


def brakings(recording: xarray.Dataset) -> tuple[list[tuple[float, float]], float, float]:
    """Return begin and end of each brake application before the stop braking [s], the begin of that [s], and the rate
    of applications after it [1/s].
    """
    time, pressed = recording["time"].values, reading_of(recording, "pad_force") > _PRESSED
    begins = time[np.flatnonzero(np.diff(pressed.astype(int)) > 0)]
    ends = time[np.flatnonzero(np.diff(pressed.astype(int)) < 0)]
    gaps = np.diff(begins)
    # The stop braking begins after the last long pause: those of the protection take some seconds.
    stop = float(begins[int(np.argmax(gaps)) + 1]) if gaps.max() > 8 else float(begins[0])
    short = [(float(begin), float(end)) for begin, end in zip(begins, ends, strict=False) if begin < stop]
    return short, stop, float(np.sum(begins >= stop) / (time[-1] - stop))


def settling(recording: xarray.Dataset, estimates: xarray.Dataset) -> float:
    """Return the time [s] after the start until the error of adhesion is within `LIMIT` for one second or more.

    Infinite if it is not within the first second.
    """
    time = recording["time"].values - recording["time"].values[0]
    over = ~(np.abs(errors(recording, estimates, "group_adhesion")) <= LIMIT) & (time <= 2.0)
    last = float(time[np.flatnonzero(over)[-1]]) if over.any() else -period_of(recording)
    return last + period_of(recording) if last < 1.0 else float("inf")


def response(recording: xarray.Dataset) -> float:
    """Return the time [s] from an intervention of the protection until the pad force has fallen to 1/e, median."""
    force, busy = reading_of(recording, "pad_force"), reading_of(recording, "protecting") > 0.5
    begins = np.flatnonzero(np.diff(busy.astype(int)) > 0) + 1
    times = [
        float(np.argmax(force[begin:] < _FALLEN * force[begin])) * period_of(recording)
        for begin in begins
        if force[begin] > _PRESSED and (force[begin:] < _FALLEN * force[begin]).any()
    ]
    return float(np.median(times))
