"""What the readings determine: friction and creep stiffness together, and the states of the reconstruction."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from railgrip.base.units import GRAVITY
from railgrip.estimation.judge import NORMAL_95, rms
from railgrip.estimation.models import of_class
from railgrip.estimators.belief import Array
from railgrip.estimators.observability import along
from railgrip.report.frame import Frame, groups_of
from railgrip.report.table import ReportTable, share, whole_percent
from railgrip.studies.lateral.judge import WINDOW, time_since_change
from railgrip.studies.lateral.run import (
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
from railgrip.studies.lateral.tables import TITLES, median_interval
from railgrip.studies.lateral.wheelset import (
    ALL_PLANTS,
    CONDITIONS,
    PAPER_SENSORS,
    PERIOD,
    SMOOTH_PLANTS,
    STIFFNESS_PLANTS,
    TESTS,
    SurfaceTest,
)

KNOWN: Final = 0.1
"""Deviation of the logarithm of friction up to which friction counts as known: the 95 % interval, ±20 %, then separates
neighbouring conditions of Table 3, whose frictions have ratios from 1.5 to 2."""

ESTIMATING: Final[tuple[Name, ...]] = ("known_track_stiffness", "unknown_track_stiffness")
"""Filters of the table that shows when friction is known."""

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


def stiffness_cases(seeds: int, duration: float) -> tuple[LateralCase, ...]:
    """Return the transition with every error of the stiffness, and dry and worst rail with small irregularities."""
    transition = TESTS[-1].shorten(duration)
    surfaces: Sequence[SurfaceTest] = [TESTS[k].shorten(duration) for k in (0, 3)]
    runs = [(transition, plant) for plant in STIFFNESS_PLANTS]
    runs += [(test, plant) for test in surfaces for plant in SMOOTH_PLANTS]
    return tuple(
        LateralCase(test=test, speed=25.0, plant=plant, seed=seed)
        for test, plant in runs
        for seed in range(1, seeds + 1)
    )


def stiffness_table(frame: Frame) -> ReportTable:
    """Return the errors of every filter in the transition by the error of the stiffness; medians over the seeds."""
    rows = [
        {
            "plant": STIFFNESS_PLANTS[plant].title,
            "filter": TITLES[name],
            "RMSE of μ0": f"{median_interval(errors['rmse'])}",
            "coverage": _mean(errors["coverage"]),
            "friction known": _mean(errors["known"]),
            "RMSE of stiffness": f"{100 * errors['stiffness'].median():.2g} %",
            "its coverage": _mean(errors["stiffness_coverage"]),
        }
        for (plant, name), errors in groups_of(frame[frame["plant"].isin(STIFFNESS_PLANTS)], ("plant", "filter"))
    ]
    return ReportTable(rows, left=("plant", "filter"))


def known_table(frame: Frame) -> ReportTable:
    """Return when the filters with an estimate of stiffness know friction, by surface, sensors and irregularity."""
    part = frame[frame["plant"].isin(SMOOTH_PLANTS) & frame["filter"].isin(ESTIMATING)]
    rows = [
        {
            "rail": test,
            "sensors and track": SMOOTH_PLANTS[plant].title,
            "filter": TITLES[name],
            "force used": _mean(errors["used"]),
            "σ(log μ0)": f"{errors['deviation'].median():.2g}",
            "correlation": f"{errors['correlation'].median():.2f}".replace("-", "−"),
            "friction known": _mean(errors["known"]),
            "coverage while known": _mean(errors["coverage_known"]),
            "while not": _mean(errors["coverage_unknown"]),
        }
        for (test, plant, name), errors in groups_of(part, ("test", "plant", "filter"))
    ]
    return ReportTable(rows, left=("rail", "sensors and track", "filter"))


def _mean(values: Frame) -> str:
    """Return the mean of the values that exist as a share in per cent."""
    return share(float(values.mean())) if values.count() else "–"


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
