"""Errors of sensors in recorded signals: kind, time and treatment.

Errors in one signal are missing samples, spikes, values out of range and a frozen sensor. Faults are steps that no
brake or wheelset makes, and noise that stops.

A cylinder has a finite flow, a wheelset an inertia, a train a mass. A sample that differs from the one before by more
than these allow is an error of the sensor, however long it lasts: a reading that jumps away and back is left out in
between, one that does not come back is reported. A noisy reading that repeats itself exactly has died.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from railgrip.base.arrays import Mask, Vector
from railgrip.base.groups import gather
from railgrip.base.names import ElementName

Kind = Literal["gap", "bridged", "frozen", "spike", "range", "zero", "time", "timing", "jump", "step"]

TREATMENTS: dict[Kind, str] = {
    "gap": "no samples; nothing is new there",
    "bridged": "no samples; interpolated between the neighbours",
    "frozen": "does not move; left out",
    "spike": "off from its neighbours; left out",
    "range": "outside the range that the map allows; left out",
    "zero": "reads exactly zero, a locked wheel or a dead sensor; kept",
    "time": "instants that repeat or are not numbers; rows left out",
    "jump": "jumps away and back faster than anything it measures can; left out",
    "step": "changes within a sample by more than anything it measures can",
    "timing": "samples moved to the nearest instant of the grid",
}
"""Meaning and treatment of each kind."""

_MOST = 5
"""Flags of a signal and kind that have a sentence each."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Flag:
    """One interval of one signal.

    Attributes:
        signal: Name of the signal, or `time`.
        kind: What was found.
        begin: First instant concerned [s on the recording's axis].
        end: Last one [s].
        samples: How many samples of the file are concerned; 0 for a gap.
        remark: More to say, or empty.
    """

    signal: str
    kind: Kind
    begin: float
    end: float
    samples: int
    remark: str = ""

    def __str__(self) -> str:
        span = f"{self.begin:.3f} s" if self.begin == self.end else f"{self.begin:.3f}–{self.end:.3f} s"
        count = f" ({self.samples} samples)" if self.samples else ""
        return f"{self.signal}, {span}{count}: {TREATMENTS[self.kind]}{'; ' + self.remark if self.remark else ''}."


def intervals(where: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return first and last index of every run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]]).astype(np.int8)))
    return [(int(first), int(after) - 1) for first, after in edges.reshape(-1, 2)]


def flags_of(signal: str, kind: Kind, time: NDArray[np.float64], where: NDArray[np.bool_]) -> list[Flag]:
    """Return a flag for every run of samples in `where`."""
    return [flag_of(signal, kind, time, first, last) for first, last in intervals(where)]


def flag_of(signal: str, kind: Kind, time: NDArray[np.float64], first: int, last: int) -> Flag:
    """Return the flag for the samples from index `first` to `last`."""
    begin, end = float(time[first]), float(time[last])
    return Flag(signal=signal, kind=kind, begin=begin, end=end, samples=last - first + 1)


def summary(flags: Sequence[Flag]) -> list[str]:
    """Return sentences for people: each flag of a signal and kind, or the first few and how many there are."""
    sentences: list[str] = []
    for (signal, kind), flags_here in gather(((flag.signal, flag.kind), flag) for flag in flags).items():
        sentences += [str(flag) for flag in flags_here[:_MOST]]
        if len(flags_here) > _MOST:
            # A gap has no samples, it has a length.
            samples, length = (
                sum(flag.samples for flag in flags_here),
                sum(flag.end - flag.begin for flag in flags_here),
            )
            extent = f"{samples} samples" if samples else f"{length:.3g} s"
            sentences.append(f"{signal}: {len(flags_here) - _MOST} more like these ({kind}), {extent} in all.")
    return sentences


@dataclass(frozen=True, slots=True)
class ChangeLimits:
    """Limits of the change of a signal: in any time, and per second, both in SI units."""

    jump: float
    rate: float


FASTEST: Final[Mapping[str, ChangeLimits]] = {
    # Valves of wheel-slide protection vent a cylinder at 15 bar/s.
    "cylinder_pressure": ChangeLimits(5e3, 2.5e6),
    # The same on the pistons of a brake unit of 40 kN at 3 bar.
    "pad_force": ChangeLimits(700.0, 3.3e5),
    # A brake torque of 20 kN.m on an axle of 60 kg.m2 without adhesion.
    "wheelset_speed": ChangeLimits(2.0, 350.0),
    # Eddy-current and magnetic brakes reach 3 m/s2, couplings 20.
    "speed": ChangeLimits(1.0, 30.0),
}
"""By name of the signal without index."""

NOISE: Final = 8.0
"""Standard deviations of the noise that a step must exceed as well."""
LONGEST: Final = 5.0
"""Longest time after which a signal comes back [s]; after a longer one, what is right is unclear."""
MOST_STEPS: Final = 6
"""Steps of one signal beyond which they are its nature: simulations without dynamics of the valves."""
TOGETHER: Final = 0.03
"""Time within which steps of most signals of a kind are an event of the train, not faults [s]."""
STUCK: Final = 0.3
"""Shortest exact repetition of a noisy signal that is a fault [s]; ten samples or more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Step:
    """A sample whose difference from the one before is impossible."""

    signal: str
    at: int
    time: float
    before: float
    after: float


def find_faults(signals: Mapping[str, tuple[Vector, Vector]]) -> tuple[dict[str, Mask], list[Flag]]:
    """Return the samples to leave out by signal, and a flag for each fault.

    Args:
        signals: Rising instants [s] and finite values in SI units by the names of the model, each shape (k,).
    """
    steps = {name: _steps(name, *samples) for name, samples in signals.items()}
    masks, flags = dict[str, Mask](), list[Flag]()
    for name, (time, values) in signals.items():
        own = [step for step in steps[name] if not _is_shared(step, steps)]
        mask, found = _excursions(name, time, values, own)
        stuck = _stuck(name, time, values, own) & ~mask
        found += flags_of(name, "frozen", time, stuck)
        # A dead sensor steps to its last value: one fault, one flag.
        found = [flag for flag in found if flag.kind != "step" or not stuck[_at(time, flag)].any()]
        masks[name], flags = mask | stuck, flags + found
    return masks, flags


def _at(time: Vector, flag: Flag) -> slice:
    first = int(np.searchsorted(time, flag.begin))
    return slice(max(first - 1, 0), first + 2)


def _steps(name: str, time: Vector, values: Vector) -> list[_Step]:
    motion = FASTEST.get(ElementName.of(name).array)
    if motion is None or values.size < 8:
        return []
    change = np.abs(np.diff(values))
    changes = np.flatnonzero(change > 0.0)
    if changes.size < 2:
        return []
    # A signal that is held between its samples changes at once by what it does in that time.
    held = float(np.median(np.diff(time[changes]))) if changes.size > 8 else 0.0
    noise = _GAUSSIAN / np.sqrt(6.0) * float(np.median(np.abs(np.diff(values, 2))))
    limit = np.maximum(motion.jump + motion.rate * np.maximum(np.diff(time), held), NOISE * noise)
    return [
        _Step(signal=name, at=k + 1, time=float(time[k + 1]), before=float(values[k]), after=float(values[k + 1]))
        for k in np.flatnonzero(change > limit).tolist()
    ]


def _is_shared(step: _Step, steps: Mapping[str, list[_Step]]) -> bool:
    base = ElementName.of(step.signal).array
    others = [name for name in steps if ElementName.of(name).array == base and name != step.signal]
    near = [any(abs(other.time - step.time) <= TOGETHER for other in steps[name]) for name in others]
    return len(near) > 0 and 2 * sum(near) >= len(near)


def _excursions(name: str, time: Vector, values: Vector, steps: list[_Step]) -> tuple[Mask, list[Flag]]:
    mask, flags = np.zeros(values.size, dtype=np.bool_), list[Flag]()
    if len(steps) > MOST_STEPS:
        remark = f"{len(steps)} times, the first from {steps[0].before:.4g} to {steps[0].after:.4g}; kept"
        flag = Flag(signal=name, kind="step", begin=steps[0].time, end=steps[-1].time, samples=0, remark=remark)
        return mask, [flag]
    rest = list(steps)
    while rest:
        first = rest.pop(0)
        jump = first.after - first.before
        back = next(
            (
                step
                for step in rest
                if step.time - first.time <= LONGEST
                and (step.after - step.before) * jump < 0.0
                and abs(step.after - first.before) <= 0.5 * abs(jump)
            ),
            None,
        )
        if back is None:
            remark = f"from {first.before:.4g} to {first.after:.4g}; one of both is wrong, and what follows is kept"
            flags.append(Flag(signal=name, kind="step", begin=first.time, end=first.time, samples=0, remark=remark))
            continue
        rest = [step for step in rest if step.at > back.at]
        mask[first.at : back.at] = True
        kind: Kind = "jump" if back.at - first.at > MAX_SPIKE else "spike"
        flags.append(flag_of(name, kind, time, first.at, back.at - 1))
    return mask, flags


def _stuck(name: str, time: Vector, values: Vector, steps: list[_Step]) -> Mask:
    """Return where a noisy signal repeats itself exactly; zeros only after an impossible step.

    Wheels lock, trains stand and released brakes read zero.
    """
    mask = np.zeros(values.size, dtype=np.bool_)
    for first, last in intervals(find_repeats(time, values, STUCK)):
        is_zero = values[first] == 0.0
        if last - first < 9 or (is_zero and not any(abs(step.at - first) <= 1 for step in steps)):
            continue
        if any(_is_noisy(part) for part in (values[max(first - 40, 0) : first], values[last + 1 : last + 41])):
            mask[first + (not is_zero) : last + 1] = True
    return mask


def _is_noisy(values: Vector) -> bool:
    if values.size < 20:
        return False
    changes = np.diff(values)
    turns = changes[1:] * changes[:-1] < 0.0
    return bool(np.mean(changes == 0.0) < 0.2 and np.mean(turns) > 0.3)


MAX_SPIKE = 3  # samples in a row that can be found off
_AROUND = 3  # samples on either side of a spike: one that it comes from or back to, and those that show how it moves
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
    padding = np.pad(values, _AROUND, mode="reflect")
    steps = np.abs(np.diff(padding))
    period = float(np.median(np.diff(time)))
    for length in range(1, MAX_SPIKE + 1):
        if length > 1 and length * period > 0.9 * _VALVE_PULSE:  # two of 10 ms are as long, whatever rounding says
            break
        first = np.arange(1, values.size - length)
        before, after = padding[first + _AROUND - 1], padding[first + _AROUND + length]
        inside = first[:, None] + np.arange(length)
        line = before[:, None] + (after - before)[:, None] * np.arange(1, length + 1) / (length + 1)
        off = np.abs(values[inside] - line)
        # Two steps before and two after; a second spike close by takes part in two of them.
        neighbours = np.sort(np.stack([steps[first + k] for k in (0, 1, 3 + length, 4 + length)]), axis=0)[1]
        moving = np.maximum(neighbours, np.abs(after - before))
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
