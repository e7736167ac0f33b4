"""What the readings determine: friction and creep stiffness together, and the states of the reconstruction."""

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from railgrip.base.units import GRAVITY
from railgrip.estimation.judgement import NORMAL_95, rms
from railgrip.estimation.lateral.run import (
    CLASSES,
    EVERY,
    PAPER_NOISE,
    STIFFNESS_NAMES,
    LateralCase,
    Name,
    Trace,
    prediction,
    simulate,
)
from railgrip.estimation.lateral.run_measures import WINDOW, time_since_change
from railgrip.estimation.lateral.wheelset import (
    ALL_PLANTS,
    CONDITIONS,
    PAPER_SENSORS,
    PERIOD,
)
from railgrip.estimation.models import of_class
from railgrip.estimators.belief import Array
from railgrip.estimators.observability import along

KNOWN: Final = 0.1
"""Deviation of the logarithm of friction up to which friction counts as known: the 95 % interval, ±20 %, then separates
neighbouring conditions of Table 3, whose frictions have ratios from 1.5 to 2."""

LOAD: Final = 15000 * GRAVITY / 2
"""Load of a wheel with the parameters of Table 1 [N]."""


def errors_of_run(case: LateralCase) -> list[dict[str, Any]]:
    """Run `STIFFNESS_NAMES` on one case and return a row for each, with `test`, `plant` and `filter`."""
    trace = simulate(case, STIFFNESS_NAMES)
    about = {"test": case.test.name, "plant": case.plant}
    return [{**about, "filter": name, **errors_of_filter(trace, name)} for name in STIFFNESS_NAMES]


def errors_of_filter(trace: Trace, name: Name) -> dict[str, float]:
    """Return the errors of a filter with states log_mu0 and, if it estimates it, log_stiffness.

    They are from `WINDOW` after each change of the surface on. `rmse`: of mu0, infinity if the filter diverged;
    `coverage`: share of samples in which the 95 % interval contains mu0; `known`: share in which friction is known, see
    `KNOWN`; `coverage_known`, `coverage_unknown`: coverage while it is, and while it is not, NaN without samples;
    `deviation`: median deviation of the logarithm of mu0; `correlation`: median posterior correlation of friction and
    stiffness, NaN without an estimate of stiffness; `stiffness`: root mean square error of the logarithm of the
    stiffness, without an estimate that of the parameters; `stiffness_coverage`: share in which its 95 % interval
    contains the truth, NaN without an estimate; `used`: 90 % quantile of the creep force over friction times load.
    """
    judged = time_since_change(trace) >= WINDOW
    states, belief = prediction(name).states, trace.beliefs[name]
    mu0 = states.index("log_mu0")
    mean, covariance, truth = belief.mean[judged], belief.covariance[judged], trace.mu0[judged]
    with np.errstate(over="ignore", invalid="ignore"):  # estimates of a lost filter may have any size
        error, deviation = mean[:, mu0] - np.log(truth), np.sqrt(covariance[:, mu0, mu0])
        rmse = rms(np.exp(mean[:, mu0]) - truth)
    is_covered, is_known = np.abs(error) <= NORMAL_95 * deviation, deviation <= KNOWN
    true = math.log(ALL_PLANTS[trace.case.plant].parameters.get("k_A", 1.0))
    correlation, stiffness, stiffness_coverage = math.nan, abs(true), math.nan
    if "log_stiffness" in states:
        column = states.index("log_stiffness")
        of_stiffness = np.sqrt(covariance[:, column, column])
        off = mean[:, column] - true
        correlation = float(np.median(covariance[:, mu0, column] / (deviation * of_stiffness)))
        stiffness, stiffness_coverage = rms(off), float(np.mean(np.abs(off) <= NORMAL_95 * of_stiffness))
    used = trace.truth["creep_force"][judged] / (trace.truth["friction"][judged] * LOAD)
    return {
        "rmse": rmse if math.isfinite(rmse) else math.inf,
        "coverage": float(np.mean(is_covered)),
        "known": float(np.mean(is_known)),
        "coverage_known": _share(is_covered, is_known),
        "coverage_unknown": _share(is_covered, ~is_known),
        "deviation": float(np.median(deviation)),
        "correlation": correlation,
        "stiffness": stiffness,
        "stiffness_coverage": stiffness_coverage,
        "used": float(np.quantile(used, 0.9)),
    }


def _share(values: NDArray[np.bool_], part: NDArray[np.bool_]) -> float:
    return float(np.mean(values[part])) if part.any() else math.nan


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
    model = of_class(CLASSES["reconstruction"]).equations({})
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
