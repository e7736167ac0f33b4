"""Faults of sensors: steps that no brake or wheelset makes, and noise that stops.

A cylinder has a finite flow, a wheelset an inertia, a train a mass. A sample that differs from the one before by more
than these allow is an error of the sensor, however long it lasts: a reading that jumps away and back is left out in
between, one that does not come back is reported. A noisy reading that repeats itself exactly has died.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from railgrip.base.arrays import Mask, Vector
from railgrip.base.names import ElementName
from railgrip.recording.cleaning import MAX_SPIKE, find_repeats
from railgrip.recording.flag import Flag, intervals


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
_GAUSSIAN = 1.4826


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
        for first, last in intervals(stuck):
            found.append(
                Flag(
                    signal=name,
                    kind="frozen",
                    begin=float(time[first]),
                    end=float(time[last]),
                    samples=last - first + 1,
                )
            )
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
        flags.append(
            Flag(
                signal=name,
                kind="jump" if back.at - first.at > MAX_SPIKE else "spike",
                begin=first.time,
                end=float(time[back.at - 1]),
                samples=back.at - first.at,
            )
        )
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
