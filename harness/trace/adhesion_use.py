"""Figures of how much of the possible adhesion a stop used; the trace comes from `with_bound`."""

import numpy as np
import xarray

from railgrip.trace.recorder import formation_in


def utilisation(trace: xarray.Dataset) -> tuple[float, tuple[float, ...]]:
    """Return ∫ F dt / ∫ F_ideal dt of the train and of each wheelset, F the braking force in the contact.

    1 is a stop at the ideal bound. A wheelset may exceed it for a moment: inertia releases force that no
    steady torque would hold. NaN where the trace has no bound, as of a plant that does not show its brakes.
    """
    unknown = float("nan"), (float("nan"),) * formation_in(trace).wheelsets
    if "ideal_share" not in trace:
        return unknown
    time, load = trace["time"].values, trace["wheelset_load"].values
    impulse = np.trapezoid(trace["adhesion"].values * load, time, axis=0)
    possible = np.trapezoid(trace["ideal_share"].values * load, time, axis=0)
    if not np.all(possible > 0):
        return unknown
    return float(impulse.sum() / possible.sum()), tuple(map(float, impulse / possible))


def over_the_rail(trace: xarray.Dataset) -> float:
    """Return ∫ F dt / ∫ F_peak dt of the train, F_peak at the peak of the creep curve: above 1 it cannot be.

    `utilisation` may be: its bound is also what the brakes draw and what the operator allows. NaN without a bound.
    """
    if "peak_adhesion" not in trace:
        return float("nan")
    load = formation_in(trace).summed(trace["wheelset_load"].values)
    impulse, possible = (
        np.trapezoid((trace[name].values * load).sum(axis=1), trace["time"].values)
        for name in ("group_adhesion", "peak_adhesion")
    )
    return float(impulse / possible) if possible > 0 else float("nan")


def time_over_limit(trace: xarray.Dataset, alpha_max: float) -> tuple[float, ...]:
    """Return the time that each group used more adhesion than α_max [s]."""
    times = np.diff(trace["time"].values, append=trace["time"].values[-1])
    return tuple(map(float, (trace["group_adhesion"].values > alpha_max).T @ times))
