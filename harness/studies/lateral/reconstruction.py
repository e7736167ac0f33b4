"""Analysis of the loss of creep and force in the reconstructed filter: information in readings, and process noise."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from railgrip.estimation.run import prediction_of
from railgrip.estimators.belief import Array
from railgrip.estimators.observability import along
from railgrip.report.table import ReportTable, whole_percent
from railgrip.studies.lateral.judge import WINDOW
from railgrip.studies.lateral.run import CLASSES, EVERY, PAPER_NOISE, LateralCase, Trace, simulate
from railgrip.studies.lateral.wheelset import CONDITIONS, PAPER_SENSORS, PERIOD

SHORT: Final = 0.02
"""Time between two zero crossings of the creep, in which the linearisation is valid [s]."""

_STATES: Final = ("lateral_velocity", "yaw_rate", "creep", "friction", "creep_force")
_HIDDEN: Final = slice(2, 5)
"""Creep, friction and force, which no sensor measures."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Information:
    """Information about creep, friction and force in a run, in the order of the states of the reconstruction.

    Attributes:
        size: Root mean square of each in the run, shape (3,).
        condition: Number of the condition of each short window, shape (k,).
        short: Standard deviation given each short window of readings alone, shape (k, 3).
        rank: Number of directions of the five states that each short window determines to less than their size, shape
            (k,).
        long: Standard deviation given each window of length `WINDOW`, shape (j, 3).
        jump: Largest change of friction and force at a change of the condition, shape (2,).
        allowed: Standard deviation of their change in `WINDOW` by process noise, maximum over all conditions, shape
            (2,).
        mirrored: Largest difference of a reading if creep and force have the opposite sign, over its noise.
    """

    size: Array
    condition: NDArray[np.intp]
    short: Array
    rank: NDArray[np.intp]
    long: Array
    jump: Array
    allowed: Array
    mirrored: float


def information(case: LateralCase) -> Information:
    """Run a case and linearise the equations of the reconstruction along its true states."""
    return information_of(simulate(case, names=()))


def information_of(trace: Trace) -> Information:
    """Linearise the equations of the reconstruction along the true states of a run."""
    model = prediction_of(CLASSES["reconstruction"], kind="compiled")
    x = np.column_stack([trace.truth[name] for name in _STATES])
    shape = np.array([(CONDITIONS[number].A, CONDITIONS[number].B) for number in trace.condition])
    columns = {
        "lateral_position": trace.truth["lateral_position"],
        "yaw_angle": trace.truth["yaw_angle"],
        "track": trace.track,
        "track_rate": np.gradient(trace.track, trace.period),
        "speed": trace.truth["speed"],
        "mu0": trace.mu0,
        "A_falling": shape[:, 0],
        "B_falling": shape[:, 1],
    }
    u = np.column_stack([columns[name] for name in model.inputs])
    size = np.sqrt(np.mean(x**2, axis=0))
    # The readings of a recorded instant represent the EVERY readings up to the next.
    noise = np.square(PAPER_SENSORS) / EVERY
    windows = {time: round(time / trace.period) for time in (SHORT, WINDOW)}
    begins, _, short = along(model, x, u, trace.period, noise, size, windows[SHORT], windows[SHORT])
    _, _, long = along(model, x, u, trace.period, noise, size, windows[WINDOW], windows[WINDOW])
    change = 1 + np.flatnonzero(np.diff(trace.condition))
    jump = np.abs(x[change] - x[change - 1])[:, 3:].max(axis=0, initial=0.0)
    deviation = np.sqrt(np.max([PAPER_NOISE[condition.name] for condition in CONDITIONS], axis=0) * WINDOW / PERIOD)
    mirror = np.array([1.0, 1.0, -1.0, 1.0, -1.0])
    seen, other = (np.array([model.output(a, b) for a, b in zip(x * sign, u, strict=True)]) for sign in (1.0, mirror))
    return Information(
        size=size[_HIDDEN],
        condition=trace.condition[begins],
        short=short[:, _HIDDEN],
        rank=np.sum(short < size, axis=1),
        long=long[:, _HIDDEN],
        jump=jump,
        allowed=deviation[3:],
        mirrored=float(np.max(np.abs(seen - other) / PAPER_SENSORS)),
    )


def observability_by_condition(runs: Sequence[Information]) -> ReportTable:
    """Return, by condition, the standard deviation of each hidden state given a short window, over its size."""
    rows: list[dict[str, Any]] = []
    for number, condition in enumerate(CONDITIONS):
        parts = [(run.short / run.size, run.rank, run.condition == number) for run in runs]
        shares = np.concatenate([share[determined] for share, _, determined in parts])
        if not len(shares):
            continue
        ranks = np.concatenate([rank[determined] for _, rank, determined in parts])
        middle, most = np.median(shares, axis=0), np.quantile(shares, 0.9, axis=0)
        rows.append(
            {"condition": condition.name, "windows": len(shares), "all five determined": float(np.mean(ranks == 5))}
            | {
                f"σ({name})": f"{100 * a:.2g} % ({100 * b:.2g} %)"
                for name, a, b in zip(("creep", "friction", "force"), middle, most, strict=True)
            }
        )
    return ReportTable(rows, {"all five determined": whole_percent}, ("condition",))


def surface_change_table(runs: Sequence[Information]) -> ReportTable:
    """Return the change of friction and force at a change of the surface, and that which the process noise allows."""
    jump = np.median([run.jump for run in runs], axis=0)
    allowed, long = runs[0].allowed, np.median(np.concatenate([run.long for run in runs]), axis=0)
    return ReportTable(
        [
            {
                "state": name,
                "largest change with the surface": f"{jump[i]:.3g}{unit}",
                f"1σ of its process noise in {WINDOW:g} s": f"{allowed[i]:.1e}{unit}",
                "ratio": f"{jump[i] / allowed[i]:.1e}",
                f"determined by {WINDOW:g} s of readings": f"±{long[1 + i]:.1e}{unit}",
            }
            for i, (name, unit) in enumerate((("friction", ""), ("force", " N")))
        ],
        left=("state",),
    )
