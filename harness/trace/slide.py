"""Figures of wheel slide: how long, how far, how hot."""

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.trace.recorder import formation_in

Array = NDArray[np.float64]

SLIP_EDGES = (0.02, 0.05, 0.10, 0.15, 0.20, 0.30, 0.50, 0.90)
"""Inner edges of the slip histogram: the first class is below 2 %, the last a wheel locked or nearly."""

DEEP_SLIDE = 0.30

FAST = 15 / 3.6
"""Speed of the train [m/s] below which a lock makes no flat that counts."""


def _sample_times(trace: xarray.Dataset) -> Array:
    """Return for how long each sample stands: until the next; the last for nothing."""
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
    """Return the longest time that a condition holds without a break."""
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
