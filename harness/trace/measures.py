"""Figures of a stop: motion of the train, use of the possible adhesion, and slide of the wheels."""

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.base.arrays import Array
from railgrip.trace.recorder import formation_in

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
    distance = trace["distance"].values
    return float(distance[-1] - distance[0])


def duration(trace: xarray.Dataset) -> float:
    """Return the time from the brake demand to the last sample [s]."""
    time = trace["time"].values
    return float(time[-1] - time[0])


def mean_deceleration(trace: xarray.Dataset) -> float:
    """Return (v₀² − v₁²)/(2 s), the mean over the distance, as braking standards take it [m/s2]."""
    speed, distance = trace["speed"].values, distance_travelled(trace)
    return float((speed[0] ** 2 - speed[-1] ** 2) / (2 * distance)) if distance > 0 else float("nan")


def jerk(trace: xarray.Dataset) -> tuple[float, float]:
    """Return the mean magnitude and the root mean square of the jerk [m/s3].

    Jerk is the change of acceleration over 0.1 s divided by 0.1 s; NaN for a stop shorter than that.
    """
    time, acceleration = trace["time"].values, trace["acceleration"].values
    if time[-1] - time[0] < _JERK_WINDOW:
        return float("nan"), float("nan")
    step = max(1, round(_JERK_WINDOW / (time[1] - time[0])))
    change = (acceleration[step:] - acceleration[:-step]) / (time[step:] - time[:-step])
    return float(np.mean(np.abs(change))), float(np.sqrt(np.mean(change**2)))


def energy_residual(trace: xarray.Dataset) -> float:
    """Return the residual of the plant's energy balance over the initial kinetic energy; NaN without energies.

    Kinetic energy lost − heat in contacts, pads and dampers − work of resistance; near zero unless the plant
    errs.
    """
    loss = -_change(trace, "kinetic_energy")
    heat = sum(_change(trace, name) for name in ("contact_heat", "pad_heat", "damper_heat", "resistance_work"))
    start = float(trace["kinetic_energy"].values[0])
    return (loss - heat) / start if start > 0 else float("nan")


def _change(trace: xarray.Dataset, name: str) -> float:
    values = trace[name].values
    return float(values[-1] - values[0])


def utilisation(trace: xarray.Dataset) -> tuple[float, tuple[float, ...]]:
    """Return ∫ F dt / ∫ F_ideal dt of the train and of each wheelset, F the braking force in the contact.

    The trace is one of `with_bound`; 1 is a stop at the ideal bound. Both may exceed 1 where the bound is what
    the brakes draw: the contact then also carries the inertia of a wheelset that regains speed; or where it is
    alpha_max and more was used. A wheelset may exceed 1, too, where the slip is not the best of its group, at which the
    shares are taken. A wheelset with isolated brakes has no share and is NaN. All are NaN where the trace has no bound,
    as of a plant that does not show its brakes.
    """
    unknown = float("nan"), (float("nan"),) * formation_in(trace).wheelsets
    if "ideal_share" not in trace:
        return unknown
    time, load = trace["time"].values, trace["wheelset_load"].values
    impulse = np.trapezoid(trace["adhesion"].values * load, time, axis=0)
    possible = np.trapezoid(trace["ideal_share"].values * load, time, axis=0)
    if not np.any(possible > 0):
        return unknown
    each = np.divide(impulse, possible, out=np.full(len(possible), np.nan), where=possible > 0)
    return float(impulse.sum() / possible.sum()), tuple(map(float, each))


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
    """Return ∫ F dt / ∫ F_peak dt of the train, F_peak at the peak of the creep curve: above 1 it cannot be.

    `utilisation` may be: its bound is also what the brakes draw and what the operator allows. NaN without a bound.
    """
    if "peak_adhesion" not in trace:
        return float("nan")
    load = formation_in(trace).sum_by_group(trace["wheelset_load"].values)
    impulse, possible = (
        np.trapezoid((trace[name].values * load).sum(axis=1), trace["time"].values)
        for name in ("group_adhesion", "peak_adhesion")
    )
    return float(impulse / possible) if possible > 0 else float("nan")


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
    return tuple(_longest(column, times) for column in locked.T)


def _longest(holds: NDArray[np.bool_], times: Array) -> float:
    turns = np.flatnonzero(np.diff(holds, prepend=False, append=False))
    instants = np.concatenate([[0.0], np.cumsum(times)])
    return float(np.max(instants[turns[1::2]] - instants[turns[::2]], initial=0.0))


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
    """Return the energy that each wheelset dissipated in its contacts [J]: what flats are made of."""
    time = trace["time"].values
    return tuple(float(np.trapezoid(power, time)) for power in tread_power(trace).T)
