"""Figures of the train's motion."""

import numpy as np
import xarray
from numpy.typing import NDArray

Array = NDArray[np.float64]

_JERK_WINDOW = 0.1  # s; shorter is the ringing of the suspension, which no passenger feels as jerk


def since_brake_demand(trace: xarray.Dataset) -> xarray.Dataset:
    """Return the samples from the first brake demand of the driver on; only the last one where there is none.

    The row of a sample holds what was demanded until then, so that the demand was made a sample before.
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
    """Return what the plant's energies leave unexplained, over the kinetic energy at the start; NaN without any.

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
