"""Errors in one signal: missing samples, spikes, values out of range, a frozen sensor."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from railgrip.base.arrays import Vector
from railgrip.recording.flag import Flag, flags_of, intervals

MAX_SPIKE = 3  # samples in a row that can be found off
_BESIDE = 3  # samples on either side of a spike: one that it comes from or back to, and those that show how it moves
_NEIGHBOURS = 7  # samples whose median is not part of a spike
_JUMP = 2.0  # times the motion of the signal next to a spike; the peak of a ramp deviates by exactly that
_VALVE_PULSE = 20e-3  # s: valves of a wheel-slide protection open for 20 to 40 ms, and the cylinder answers
_SURROUNDINGS = 101  # samples for the local noise: braking is rougher than coasting
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


def clean(signal: str, time: Vector, values: Vector, treatment: Treatment) -> tuple[Vector, Vector, list[Flag]]:
    """Return the remaining samples with their instants, and the flags.

    Args:
        signal: Name, for the flags.
        time: Rising instants [s], shape (k,).
        values: Shape (k,); NaN for missing samples.
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
    still = find_repeats(time, values, treatment.frozen)
    zero = still & (values == 0.0)
    if not treatment.may_rest:
        # A locked wheel reads exactly zero for seconds; that must reach the filter, and be said.
        flags.extend(flags_of(signal, "zero", time, zero))
        leave_out("frozen", _all_but_first(still & ~zero))
    if treatment.holds and values.size:
        new = np.concatenate([[True], np.diff(values) != 0.0])
        time, values = time[new], values[new]
    leave_out("spike", spikes(time, values, treatment.spike))
    return time, values, flags


def find_repeats(time: Vector, values: Vector, longest: float) -> NDArray[np.bool_]:
    """Return where a signal repeats itself exactly for longer than `longest` [s], shape (k,)."""
    flags = np.zeros(values.size, dtype=np.bool_)
    if values.size < 2:
        return flags
    repeats = np.concatenate([[False], np.diff(values) == 0.0])
    for first, last in intervals(repeats):
        if time[last] - time[first - 1] > longest:
            flags[first - 1 : last + 1] = True
    return flags


def spikes(time: Vector, values: Vector, deviations: float) -> NDArray[np.bool_]:
    """Return samples that leave the line between their neighbours and come back, both at once, shape (k,).

    A sample is off the line if its distance exceeds `deviations` of the noise and `_JUMP` times the motion of the
    signal next to and across it: so neither a step nor a corner nor the peak of a ramp is a spike. A spike has up to
    three samples and is shorter than `_VALVE_PULSE`: longer ones may be a vented brake. The first and the last sample
    are never spikes.

    The noise is the larger one of its local and its overall value, and not less than the resolution, so that steps of a
    quantised signal are not spikes. It is taken from second differences, which a ramp does not raise.

    Args:
        time: Rising instants [s], shape (k,).
        values: Shape (k,), finite.
        deviations: Of the noise, that make a spike.
    """
    flags = np.zeros(values.size, dtype=np.bool_)
    if values.size < _NEIGHBOURS:
        return flags
    # A second difference of white noise has the variance 1 + 4 + 1.
    bend = np.abs(np.diff(values, 2, prepend=values[0], append=values[-1])) * (_GAUSSIAN / np.sqrt(6.0))
    nearby = median_filter(bend, min(_SURROUNDINGS, values.size), mode="mirror")
    scale = np.maximum(nearby, max(float(np.median(bend)), _resolution(values)))
    # Two spikes with a sample between them leave that one where the others are.
    apart = np.abs(values - median_filter(values, _NEIGHBOURS, mode="mirror")) > deviations * scale
    padding = np.pad(values, _BESIDE, mode="reflect")
    steps = np.abs(np.diff(padding))
    period = float(np.median(np.diff(time)))
    for length in range(1, MAX_SPIKE + 1):
        if length > 1 and length * period > 0.9 * _VALVE_PULSE:  # two of 10 ms are as long, whatever rounding says
            break
        first = np.arange(1, values.size - length)
        before, after = padding[first + _BESIDE - 1], padding[first + _BESIDE + length]
        inside = first[:, None] + np.arange(length)
        line = before[:, None] + (after - before)[:, None] * np.arange(1, length + 1) / (length + 1)
        off = np.abs(values[inside] - line)
        # Two steps before and two after; a second spike close by takes part in two of them.
        beside = np.sort(np.stack([steps[first + k] for k in (0, 1, 3 + length, 4 + length)]), axis=0)[1]
        moving = np.maximum(beside, np.abs(after - before))
        spike = apart[inside] & (off > deviations * scale[inside]) & (off > _JUMP * moving[:, None])
        flags[inside[spike.all(axis=1)]] = True
    return flags


def _resolution(values: Vector) -> float:
    """Return the smallest step of a signal, 0 if it hardly ever steps.

    A lone spike in a constant signal is two steps, and shows nothing about the resolution.
    """
    steps = np.abs(np.diff(values))
    steps = steps[steps > 0.0]
    return float(np.percentile(steps, 10.0)) if steps.size > 12 else 0.0


def _all_but_first(where: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return where & np.concatenate([[False], where[:-1]])
