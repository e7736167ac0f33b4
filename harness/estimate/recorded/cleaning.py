"""Finding what is wrong with one signal: samples that are none, spikes, values out of range, a sensor that froze."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from harness.estimate.recorded.flag import Flag, flags_of, intervals

Vector = NDArray[np.float64]

_NEIGHBOURS = 7  # samples in whose median a sample is judged: up to three in a row can be found off
_SURROUNDINGS = 101  # samples that say what is usual here: braking is rougher than coasting
_GAUSSIAN = 1.4826  # standard deviation of a Gaussian over its median absolute deviation


@dataclass(frozen=True, slots=True, kw_only=True)
class Treatment:
    """How one signal is to be judged.

    Attributes:
        spike: Deviations from the neighbours that make an outlier.
        frozen: Time of exact repetition after which a sensor counts as dead [s].
        limits: Least and largest value that is possible, or None.
        holds: The file repeats a value until a new one comes.
        may_rest: Exact repetition is normal.
    """

    spike: float
    frozen: float
    limits: tuple[float, float] | None
    holds: bool
    may_rest: bool


def cleaned(signal: str, time: Vector, values: Vector, treatment: Treatment) -> tuple[Vector, Vector, list[Flag]]:
    """Return the samples that are left, with their instants, and what was found.

    Args:
        signal: Name, for the flags.
        time: Rising instants [s], shape (k,).
        values: Shape (k,); NaN where there is none.
        treatment: How to judge.
    """
    there = np.isfinite(values)
    time, values = time[there], values[there]
    flags: list[Flag] = []

    def leave_out(kind: str, where: NDArray[np.bool_]) -> None:
        nonlocal time, values
        flags.extend(flags_of(signal, kind, time, where))  # pyright: ignore[reportArgumentType]
        time, values = time[~where], values[~where]

    if treatment.limits is not None:
        low, high = treatment.limits
        leave_out("range", (values < low) | (values > high))
    still = standing(time, values, treatment.frozen)
    zero = still & (values == 0.0)
    if not treatment.may_rest:
        # A locked wheel reads exactly zero for seconds; that must reach the filter, and be said.
        flags.extend(flags_of(signal, "zero", time, zero))
        leave_out("frozen", _but_the_first(still & ~zero))
    if treatment.holds and values.size:
        new = np.concatenate([[True], np.diff(values) != 0.0])
        time, values = time[new], values[new]
    leave_out("spike", spikes(values, treatment.spike))
    return time, values, flags


def standing(time: Vector, values: Vector, longest: float) -> NDArray[np.bool_]:
    """Return where a signal repeats itself exactly for longer than `longest` [s], shape (k,)."""
    found = np.zeros(values.size, dtype=np.bool_)
    if values.size < 2:
        return found
    repeats = np.concatenate([[False], np.diff(values) == 0.0])
    for first, last in intervals(repeats):
        if time[last] - time[first - 1] > longest:
            found[first - 1 : last + 1] = True
    return found


def spikes(values: Vector, deviations: float) -> NDArray[np.bool_]:
    """Return samples that stand out of their neighbours: a Hampel filter with a scale of the surroundings.

    The scale is the larger of the noise nearby and over all, but no less than the resolution, so that a quantised
    signal is not judged by its own steps. Noise is taken from second differences, which a ramp does not raise and a
    median of few samples, often the very sample that is judged, does not lower. A step, or a dynamic of more than
    three samples, is none.

    Source: Pearson, Outliers in process modeling and identification (2002).
    """
    if values.size < _NEIGHBOURS:
        return np.zeros(values.size, dtype=np.bool_)
    off = np.abs(values - median_filter(values, _NEIGHBOURS, mode="nearest"))
    # A second difference of white noise has the variance 1 + 4 + 1.
    bend = np.abs(np.diff(values, 2, prepend=values[0], append=values[-1])) * (_GAUSSIAN / np.sqrt(6.0))
    nearby = median_filter(bend, min(_SURROUNDINGS, values.size), mode="nearest")
    scale = np.maximum(nearby, max(float(np.median(bend)), _resolution(values)))
    return off > deviations * scale


def _resolution(values: Vector) -> float:
    """Return the least step that a signal makes, 0 when it hardly ever makes one.

    A lone spike in a constant signal is two steps, and tells nothing about the resolution.
    """
    steps = np.abs(np.diff(values))
    steps = steps[steps > 0.0]
    return float(np.percentile(steps, 10.0)) if steps.size > 12 else 0.0


def _but_the_first(where: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return every run without its first sample: that one was a reading."""
    return where & np.concatenate([[False], where[:-1]])
