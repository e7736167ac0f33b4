"""Figures of a stop: motion, use of the possible adhesion, slide of the wheels, and errors of the estimator.

Against another stop, also where along the track it loses distance. Both pass the same speeds at different places; the
distance between these places is the distance lost so far. It begins with 0 and ends with the difference of the
distances. What a section of the track adds to it is the length of the section less the distance that the first stop
needs for the same speeds.
"""

from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np
import pandas
import xarray
from numpy.typing import NDArray

from railgrip.base.arrays import Array
from railgrip.estimators.consistency import loss_step, nis_ratio
from railgrip.trace.recorder import formation_in
from railgrip.vehicle.signals import READINGS

_JERK_WINDOW = 0.1  # s; shorter is the ringing of the suspension, which no passenger feels as jerk

SLIP_EDGES = (0.02, 0.05, 0.10, 0.15, 0.20, 0.30, 0.50, 0.90)
"""Inner edges of the slip histogram: the first class is below 2 %, the last a wheel locked or nearly."""

DEEP_SLIDE = 0.30

SLIDE = 0.05
"""Slip above which a group slides, for the adhesion at the first slide."""

FAST = 15 / 3.6
"""Speed of the train [m/s] below which locks and slides do not count."""


def since_brake_demand(trace: xarray.Dataset) -> xarray.Dataset:
    """Return the samples from the first brake demand of the driver on; without a demand only the last sample.

    The row of a sample holds the demand up to its instant, so the demand was made one sample earlier.
    """
    if "driver_demand" not in trace:
        return trace
    demanded = np.append(np.any(trace["driver_demand"].values > 0, axis=1), True)
    return trace.isel(time=slice(max(int(np.argmax(demanded)) - 1, 0), None))


def distance_travelled(trace: xarray.Dataset) -> float:
    """Return the distance from the first sample to the last [m]; of a stop to standstill, its braking distance."""
    return change(trace, "distance")


def duration(trace: xarray.Dataset) -> float:
    """Return the time from the brake demand to the last sample [s]."""
    return change(trace, "time")


def mean_deceleration(trace: xarray.Dataset) -> float:
    """Return (v₀² − v₁²)/(2 s), the mean over the distance, as braking standards take it [m/s2]."""
    speed, distance = trace["speed"].values, distance_travelled(trace)
    return float((speed[0] ** 2 - speed[-1] ** 2) / (2 * distance)) if distance > 0 else float("nan")


def jerk(trace: xarray.Dataset) -> dict[str, float]:
    """Return the mean magnitude and the root mean square of the jerk [m/s3] by their names in `Metrics`.

    Jerk is the change of acceleration over 0.1 s divided by 0.1 s; NaN for a stop shorter than that.
    """
    time, acceleration = trace["time"].values, trace["acceleration"].values
    if time[-1] - time[0] < _JERK_WINDOW:
        return {"jerk_mean": nan, "jerk_rms": nan}
    step = max(1, round(_JERK_WINDOW / (time[1] - time[0])))
    change = (acceleration[step:] - acceleration[:-step]) / (time[step:] - time[:-step])
    return {"jerk_mean": float(np.mean(np.abs(change))), "jerk_rms": float(np.sqrt(np.mean(change**2)))}


def energy_residual(trace: xarray.Dataset) -> float:
    """Return the residual of the plant's energy balance over the initial kinetic energy; NaN without energies.

    Kinetic energy lost − heat in contacts, pads and dampers − work of resistance; near zero unless the plant
    errs.
    """
    loss = -change(trace, "kinetic_energy")
    heat = sum(change(trace, name) for name in ("contact_heat", "pad_heat", "damper_heat", "resistance_work"))
    start = float(trace["kinetic_energy"].values[0])
    return (loss - heat) / start if start > 0 else float("nan")


def change(trace: xarray.Dataset, name: str) -> float:
    """Return the change of a signal from the first sample to the last."""
    values = trace[name].values
    return float(values[-1] - values[0])


def utilisation(trace: xarray.Dataset) -> dict[str, float | tuple[float, ...]]:
    """Return ∫ F dt / ∫ F_ideal dt of the train and of each wheelset, F the braking force in the contact.

    They have their names in `Metrics`.

    The trace is one of `with_bound`; 1 is a stop at the ideal bound. Both may exceed 1 where the bound is what
    the brakes draw: the contact then also carries the inertia of a wheelset that regains speed; or where it is
    alpha_max and more was used. A wheelset may exceed 1, too, where the slip is not the best of its group, at which the
    shares are taken. A wheelset with isolated brakes has no share and is NaN. All are NaN where the trace has no bound,
    as of a plant that does not show its brakes.
    """
    unknown = {"utilisation": nan, "utilisation_wheelset": (nan,) * formation_in(trace).wheelsets}
    if "ideal_share" not in trace:
        return unknown
    time, load = trace["time"].values, trace["wheelset_load"].values
    impulse = np.trapezoid(trace["adhesion"].values * load, time, axis=0)
    possible = np.trapezoid(trace["ideal_share"].values * load, time, axis=0)
    if not np.any(possible > 0):
        return unknown
    each = np.divide(impulse, possible, out=np.full(len(possible), np.nan), where=possible > 0)
    return {"utilisation": float(impulse.sum() / possible.sum()), "utilisation_wheelset": _row(each)}


def adhesion_allowed(trace: xarray.Dataset) -> float:
    """Return the mean of the train's adhesion at the peak of the creep curve with which v²/(2 g α) holds [1].

    From s = ∫ v dv/(g α) follows the harmonic mean over v²; of a rail on which the peak depends on speed alone it is
    the same for every stop. NaN without a bound, or for a train that does not slow down.
    """
    if "peak_adhesion" not in trace:
        return float("nan")
    load = formation_in(trace).sum_by_group(trace["wheelset_load"].values)
    peak = (trace["peak_adhesion"].values * load).sum(axis=1) / load.sum(axis=1)
    square = trace["speed"].values ** 2
    inverse = -np.trapezoid(1.0 / peak, square)
    return float((square[0] - square[-1]) / inverse) if inverse > 0 else float("nan")


def adhesion_at_slide(trace: xarray.Dataset) -> float:
    """Return the adhesion of the first group that slides, when its slip first exceeds 5 % above 15 km/h [1].

    It is the adhesion available when the slide begins, which EN 15595 quotes for its test with soap and water. If
    groups begin to slide in the same sample, it is that of the group with the largest slip. NaN for a stop without
    slide.
    """
    slip = trace["slip"].values
    is_sliding = np.any(slip > SLIDE, axis=1) & (trace["speed"].values > FAST)
    if not is_sliding.any():
        return float("nan")
    first = int(np.argmax(is_sliding))
    return float(trace["group_adhesion"].values[first, np.argmax(slip[first])])


def over_the_rail(trace: xarray.Dataset) -> float:
    """Return ∫ F dt / ∫ F_peak dt of the train, with the force F_peak at the peak of the creep curve; at most 1.

    `utilisation` may exceed 1, because its bound is also what the brakes draw and what the operator allows. NaN without
    a bound, and if the plant outputs the adhesion neither of wheelsets nor of groups.
    """
    if "peak_adhesion" not in trace:
        return float("nan")
    load = trace["wheelset_load"].values
    group_load, time = formation_in(trace).sum_by_group(load), trace["time"].values
    force = (trace["adhesion"].values * load).sum(axis=1)
    if np.isnan(force).all():
        force = (trace["group_adhesion"].values * group_load).sum(axis=1)
    possible = np.trapezoid((trace["peak_adhesion"].values * group_load).sum(axis=1), time)
    return float(np.trapezoid(force, time) / possible) if possible > 0 else float("nan")


def time_over_limit(trace: xarray.Dataset, alpha_max: float) -> tuple[float, ...]:
    """Return the time that each group used more adhesion than α_max [s]."""
    return tuple(map(float, (trace["group_adhesion"].values > alpha_max).T @ _sample_times(trace)))


def _sample_times(trace: xarray.Dataset) -> Array:
    """Return the time from each sample to the next, 0 for the last [s]."""
    return np.diff(trace["time"].values, append=trace["time"].values[-1])


def slip_histogram(trace: xarray.Dataset) -> tuple[tuple[float, ...], ...]:
    """Return the time [s] of each group in each slip class of `SLIP_EDGES`; shape (groups, classes)."""
    times, slip = _sample_times(trace), trace["slip"].values
    classes = np.digitize(slip, SLIP_EDGES)
    counts = [np.bincount(classes[:, g], weights=times, minlength=len(SLIP_EDGES) + 1) for g in range(slip.shape[1])]
    return tuple(tuple(map(float, row)) for row in counts)


def time_in_deep_slide(trace: xarray.Dataset) -> tuple[float, ...]:
    """Return the time of each group above 30 % slip [s]."""
    above = trace["slip"].values > DEEP_SLIDE
    return tuple(map(float, above.T @ _sample_times(trace)))


def longest_lock(trace: xarray.Dataset, *, above: float = -np.inf) -> tuple[float, ...]:
    """Return the longest uninterrupted time that each group stood still on a moving train [s].

    Args:
        trace: Of a stop.
        above: Speed of the train that it has to be faster than for a lock to count [m/s].
    """
    times = _sample_times(trace)
    locked = (trace["locked"].values > 0.5) & (trace["speed"].values > above)[:, None]
    return tuple(largest_sum(column, times) for column in locked.T)


def largest_sum(holds: NDArray[np.bool_], values: Array) -> float:
    """Return the largest sum of values over samples in which a condition holds without interruption; 0 if it never
    does."""
    turns = np.flatnonzero(np.diff(holds, prepend=False, append=False))
    sums = np.concatenate([[0.0], np.cumsum(values)])
    return float(np.max(sums[turns[1::2]] - sums[turns[::2]], initial=0.0))


def locked_distance(trace: xarray.Dataset) -> tuple[float, ...]:
    """Return how far each group was dragged without turning [m]."""
    travel = np.diff(trace["distance"].values, append=trace["distance"].values[-1])
    return tuple(map(float, (trace["locked"].values > 0.5).T @ travel))


def tread_power(trace: xarray.Dataset) -> Array:
    """Return F·v·s, the power that each wheelset dissipates in its contacts [W], shape (n, wheelsets)."""
    force = trace["adhesion"].values * trace["wheelset_load"].values
    slip = trace["slip"].values[:, formation_in(trace).group_of_wheelset]
    return force * slip * trace["speed"].values[:, None]


def tread_energy(trace: xarray.Dataset) -> tuple[float, ...]:
    """Return the energy that each wheelset dissipated in its contacts [J]."""
    time = trace["time"].values
    return tuple(float(np.trapezoid(power, time)) for power in tread_power(trace).T)


WEAR = 5.3e-9
"""Wear of a wheel of steel R8T by the energy of its slip [kg/J], in the mild regime.

Source: Braghin, Lewis, Dwyer-Joyce and Bruni, Wear 261 (2006) 1253: 5.3 µg/m/mm² times Tγ/A in N/mm².
"""

DENSITY = 7850.0
"""Density of steel [kg/m3]."""

RAIL_HEAD = 0.3
"""Radius of the rail head [m], of a rail 60E1 after EN 13674-1."""


def flat_length(trace: xarray.Dataset) -> tuple[float, ...]:
    """Return the estimated length of the longest wheel flat of each wheelset [m]; 0 without a lock.

    A locked wheel loses the volume V = `WEAR` E/`DENSITY`, E half of the energy of the wheelset in one lock. A straight
    rail cuts it off as a cap of depth d = L²/(8 r) and volume π √(r R) d², r the radius of the wheel and R that of the
    rail head: L⁴ = 64 r² V/(π √(r R)). A wheelset that turns between two locks has two flats. The radius is the median
    of (1 − s) v/ω; NaN for a wheelset that locked and never turned, or whose adhesion the plant does not output.

    Source: depth of a new flat of length L from Newton and Clark, J. Mech. Eng. Sci. 21 (1979) 287.
    """
    of_wheelset = formation_in(trace).group_of_wheelset
    energy = tread_power(trace) * _sample_times(trace)[:, None]
    locked = trace["locked"].values[:, of_wheelset] > 0.5
    turning = trace["wheelset_speed"].values
    rolled = (1 - trace["slip"].values) * trace["speed"].values[:, None]
    lengths: list[float] = []
    for wheelset, group in enumerate(of_wheelset):
        worn = largest_sum(locked[:, wheelset], np.where(locked[:, wheelset], energy[:, wheelset], 0.0))
        turns = turning[:, group] > 0
        radius = np.median(rolled[turns, group] / turning[turns, group]) if turns.any() else nan
        length = (64 * radius**2 * WEAR * worn / 2 / DENSITY / (np.pi * np.sqrt(radius * RAIL_HEAD))) ** 0.25
        lengths.append(float(length) if worn else 0.0)
    return tuple(lengths)


SLOWEST = 10 / 3.6  # m/s; below, slip is the ratio of two small numbers and no one asks for the adhesion
_LONGEST_DELAY = 0.5  # s
_DELAY_STEP = 0.005  # s


def adhesion_errors(trace: xarray.Dataset) -> dict[str, tuple[float, ...]]:
    """Return the errors of the estimated adhesion of each group by their names in `Metrics`.

    They are estimate minus truth above 10 km/h; empty for a stop without estimates, or that was never as fast.
    Without a standard deviation there is no NEES, the mean of (error/deviation)², which is 1 for a consistent
    estimator, and no share outside ±2σ, which is 0.046 then. Delays are 0 to 0.5 s in steps of 5 ms.
    """
    truth, estimate = _moving(trace, "group_adhesion"), _moving(trace, "estimate_adhesion")
    if truth is None or estimate is None or len(truth) < 2:
        return {}
    error, deviation = estimate - truth, _moving(trace, "estimate_adhesion_sd")
    period = float(trace["time"].values[1] - trace["time"].values[0])
    errors = {
        "adhesion_rmse": np.sqrt(np.mean(error**2, axis=0)),
        "adhesion_bias": np.mean(error, axis=0),
        "adhesion_error_95": np.quantile(np.abs(error), 0.95, axis=0),
        "adhesion_delay": _delay(truth, estimate, period),
    }
    if deviation is not None:
        errors["adhesion_sd"] = np.mean(deviation, axis=0)
        errors["adhesion_nees"] = np.mean((error / deviation) ** 2, axis=0)
        errors["adhesion_outside"] = _outside(error, deviation)
    return {name: _row(values) for name, values in errors.items()}


def _moving(trace: xarray.Dataset, name: str) -> Array | None:
    """Return a signal above 10 km/h, or None: some estimators provide no standard deviation."""
    return trace[name].values[trace["speed"].values > SLOWEST] if name in trace else None


def _delay(truth: Array, estimate: Array, period: float) -> Array:
    """Return the shift that minimises the mean square of estimate(t + shift) − truth(t), shape (groups,) [s].

    All shifts are judged on the same samples of the truth, so that a hard passage cannot drop out with a
    shift.
    """
    step = max(1, round(_DELAY_STEP / period))
    longest = min(round(_LONGEST_DELAY / period), len(truth) // 2)
    shifts = np.arange(0, longest + 1, step)
    count = len(truth) - longest
    rows, fixed = np.ascontiguousarray(estimate.T), np.ascontiguousarray(truth[:count].T)
    errors = (rows[:, s : s + count] - fixed for s in shifts)
    squares = np.stack([np.einsum("ij,ij->i", error, error) for error in errors])
    return np.asarray(shifts[np.argmin(squares, axis=0)] * period, dtype=np.float64)


def rmse(trace: xarray.Dataset, estimated: str, true: str) -> tuple[float, ...] | None:
    """Return the root mean square error of another estimate above 10 km/h, or None without it."""
    error = _error(trace, estimated, true)
    return None if error is None else _row(np.atleast_1d(np.sqrt(np.mean(error**2, axis=0))))


def outside(trace: xarray.Dataset, estimated: str, true: str) -> tuple[float, ...] | None:
    """Return the share of time above 10 km/h with the truth outside ±2σ of an estimate, or None without it."""
    error, deviation = _error(trace, estimated, true), _moving(trace, f"{estimated}_sd")
    return None if error is None or deviation is None else _row(_outside(error, deviation))


def _error(trace: xarray.Dataset, estimated: str, true: str) -> Array | None:
    estimate = _moving(trace, estimated)
    truth = _moving(trace, true)
    return None if estimate is None or truth is None or not len(estimate) else estimate - truth


def _outside(error: Array, deviation: Array) -> Array:
    """Return the share of samples beyond two deviations, shape (groups,); NaN without a truth."""
    return np.where(np.isnan(error).any(axis=0), np.nan, np.mean(np.abs(error) > 2.0 * deviation, axis=0))


def innovations(trace: xarray.Dataset) -> dict[str, float]:
    """Return the ratio of the median NIS to its expected value, and the time of divergence [s], as far as they exist.

    See `railgrip.estimators.consistency`. Between two steps of the estimator rows repeat the last one.
    """
    if "estimate_nis" not in trace:
        return {}
    nis, readings = trace["estimate_nis"].values, trace["estimate_readings"].values
    ratio, lost = nis_ratio(nis, readings), loss_step(nis, readings)
    found = {} if lost is None else {"estimator_lost": float(trace["time"].values[lost])}
    return found if ratio is None else found | {"nis_ratio": ratio}


def reading_errors(trace: xarray.Dataset) -> dict[str, float]:
    """Return the RMS error of each reading over the RMS of the true value, by the names in `Metrics`.

    Errors are means over the channels of a reading; missing readings are left out. NaN if the trace lacks the reading
    or the true value, or the true value is always 0 and the reading is not.
    """
    readings = {signal.name.removeprefix("reading_"): signal.name for signal in READINGS}
    return {f"{true}_error": _relative_error(trace, reading, true) for true, reading in readings.items()}


def _relative_error(trace: xarray.Dataset, reading: str, true: str) -> float:
    if reading not in trace or true not in trace:
        return float("nan")
    truth = trace[true].values
    error = trace[reading].values - truth
    if np.isnan(error).all():
        return float("nan")
    error_rms, scale = np.sqrt(np.nanmean(error**2)), np.sqrt(np.mean(truth**2))
    return float(error_rms / scale) if scale > 0 else 0.0 if error_rms == 0 else float("nan")


def _row(values: Array) -> tuple[float, ...]:
    return tuple(map(float, values))


_WIDTHS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0)
_MAX_SECTIONS = 12
_REST = 0.1
"""Share of a section below which the last piece of the track is joined to the section before."""
_NOTHING = 1e-9
"""Distance below which the other stop has no deceleration [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StopCourse:
    """Where a stop falls below each of its speeds, shape (n,); the first sample is the brake demand.

    Attributes:
        time: Since the brake demand [s].
        place: Distance since the brake demand [m].
        speed: Falling; a stretch along which the train keeps or gains speed has only its end [m/s].
    """

    time: Array
    place: Array
    speed: Array

    def place_at(self, speed: Array) -> Array:
        """Return where the stop falls below a speed [m]; 0 for one above that at the start."""
        return np.interp(-speed, -self.speed, self.place)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loss:
    """The distance that a stop loses against another along its track.

    Attributes:
        first: The other stop.
        course: The stop, down to the lowest speed that both reached.
        lost: So far, at each of its samples [m].
        sections: A frame with a row for each section of the track, preceded by the saving from a lower speed at the
            start: places `begin` and `end` [m]; `time` [s] and `speed` [m/s] at which the stop enters it; distance
            `lost` in it, negative where it is gained, and `so_far`, up to its end [m]; mean `deceleration` of the stop
            in it, and `deceleration_of_first` of the other stop between the same speeds, NaN where it had none of them
            [m/s2].
    """

    first: StopCourse
    course: StopCourse
    lost: Array
    sections: Any

    @property
    def at_start(self) -> float:
        """Distance saved, negative, by a lower speed at the start [m]."""
        return float(self.lost[0])

    @property
    def total(self) -> float:
        """Distance lost at the end [m]."""
        return float(self.lost[-1])

    @property
    def speed_difference(self) -> Array:
        """Speed less that of the first stop at the same place, 0 beyond its end [m/s]; shape of `lost`."""
        return self.course.speed - np.interp(self.course.place, self.first.place, self.first.speed)


def course_of(trace: xarray.Dataset, *, is_standstill: bool) -> StopCourse:
    """Return the course of a stop.

    Args:
        trace: Trace of the stop.
        is_standstill: Whether it ended at a standstill; the last speed, which is nearly 0, then counts as 0.
    """
    braking = since_brake_demand(trace)
    time, distance = braking["time"].values, braking["distance"].values
    speed = np.minimum.accumulate(braking["speed"].values)
    if is_standstill:
        speed[-1] = 0.0
    ends = np.append(np.diff(speed) < 0, True)
    ends[0] = True
    return StopCourse(time=(time - time[0])[ends], place=(distance - distance[0])[ends], speed=speed[ends])


def loss(first: StopCourse, course: StopCourse) -> Loss:
    """Return where a stop loses distance against a first one, down to the lowest speed that both reached."""
    common = course.speed >= first.speed[-1]
    common[0] = True
    course = StopCourse(time=course.time[common], place=course.place[common], speed=course.speed[common])
    lost = course.place - first.place_at(course.speed)
    if course.speed[0] >= first.speed[0]:
        lost[0] = 0.0
    return Loss(first=first, course=course, lost=lost, sections=_sections(course, lost))


def _sections(course: StopCourse, lost: Array) -> Any:
    end = float(course.place[-1])
    width = next((width for width in _WIDTHS if end / width <= _MAX_SECTIONS), end / _MAX_SECTIONS)
    edges = np.append(np.arange(0.0, end - _REST * width, width), end) if end > 0.0 else np.zeros(1)
    time, speed, so_far = (np.interp(edges, course.place, values) for values in (course.time, course.speed, lost))
    squares, needed = -np.diff(speed**2) / 2, np.diff(edges) - np.diff(so_far)
    return pandas.DataFrame(
        {
            "begin": edges[:-1],
            "end": edges[1:],
            "time": time[:-1],
            "speed": speed[:-1],
            "lost": np.diff(so_far),
            "so_far": so_far[1:],
            "deceleration": squares / np.diff(edges),
            "deceleration_of_first": np.divide(squares, needed, out=np.full(len(needed), nan), where=needed > _NOTHING),
        }
    )
