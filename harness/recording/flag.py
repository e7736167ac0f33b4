"""Errors in recorded data: kind, time, and treatment."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

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
    return [
        Flag(signal=signal, kind=kind, begin=float(time[i]), end=float(time[j]), samples=j - i + 1)
        for i, j in intervals(where)
    ]


def summary(flags: Sequence[Flag]) -> list[str]:
    """Return sentences for people: each flag of a signal and kind, or the first few and how many there are."""
    groups: dict[tuple[str, Kind], list[Flag]] = {}
    for flag in flags:
        groups.setdefault((flag.signal, flag.kind), []).append(flag)
    sentences: list[str] = []
    for (signal, kind), flags_here in groups.items():
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
