"""Friction and creep stiffness estimated together: errors, and whether the readings determine friction."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from railgrip.base.units import GRAVITY
from railgrip.estimation.judge import NORMAL_95, rms
from railgrip.estimators.belief import Array
from railgrip.report.table import ReportTable, share
from railgrip.studies.lateral.judge import WINDOW
from railgrip.studies.lateral.run import STIFFNESS_NAMES, LateralCase, Name, Trace, prediction, simulate
from railgrip.studies.lateral.tables import TITLES, median_interval
from railgrip.studies.lateral.wheelset import (
    ALL_PLANTS,
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


@dataclass(frozen=True, slots=True, kw_only=True)
class StiffnessErrors:
    """Errors of one filter in one run, from `WINDOW` after each change of the surface on.

    Attributes:
        rmse: Of mu0; infinity if the filter diverged.
        coverage: Share of samples in which the 95 % interval contains mu0.
        known: Share of samples in which friction is known, see `KNOWN`.
        coverage_known, coverage_unknown: Coverage while friction is known, and while it is not; NaN without samples.
        deviation: Median deviation of the logarithm of mu0.
        correlation: Median posterior correlation of friction and stiffness; NaN without an estimate of stiffness.
        stiffness: Root mean square error of the logarithm of the stiffness; without an estimate that of the parameters.
        stiffness_coverage: Share of samples in which its 95 % interval contains the truth; NaN without an estimate.
        used: 90 % quantile of the creep force over the largest one, friction times load.
    """

    rmse: float
    coverage: float
    known: float
    coverage_known: float
    coverage_unknown: float
    deviation: float
    correlation: float
    stiffness: float
    stiffness_coverage: float
    used: float


def errors_of_run(case: LateralCase) -> dict[Name, StiffnessErrors]:
    """Run `STIFFNESS_NAMES` on one case."""
    trace = simulate(case, STIFFNESS_NAMES)
    return {name: errors_of_filter(trace, name) for name in STIFFNESS_NAMES}


def errors_of_filter(trace: Trace, name: Name) -> StiffnessErrors:
    """Return the errors of a filter with states log_mu0 and, if it estimates it, log_stiffness."""
    since = trace.time - np.array(trace.changes)[np.searchsorted(trace.changes, trace.time, side="left") - 1]
    judged = since >= WINDOW
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
    return StiffnessErrors(
        rmse=rmse if math.isfinite(rmse) else math.inf,
        coverage=float(np.mean(is_covered)),
        known=float(np.mean(is_known)),
        coverage_known=_share(is_covered, is_known),
        coverage_unknown=_share(is_covered, ~is_known),
        deviation=float(np.median(deviation)),
        correlation=correlation,
        stiffness=stiffness,
        stiffness_coverage=stiffness_coverage,
        used=_used(trace, judged),
    )


def _share(values: NDArray[np.bool_], part: NDArray[np.bool_]) -> float:
    return float(np.mean(values[part])) if part.any() else math.nan


def _used(trace: Trace, judged: NDArray[np.bool_]) -> float:
    used: Array = trace.truth["creep_force"][judged] / (trace.truth["friction"][judged] * LOAD)
    return float(np.quantile(used, 0.9))


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


Runs = Sequence[tuple[LateralCase, dict[Name, StiffnessErrors]]]


def stiffness_table(runs: Runs) -> ReportTable:
    """Return the errors of every filter in the transition by the error of the stiffness; medians over the seeds."""
    rows: list[dict[str, Any]] = []
    for plant, variant in STIFFNESS_PLANTS.items():
        for name in STIFFNESS_NAMES:
            errors = [found[name] for case, found in runs if case.plant == plant]
            rows.append(
                {
                    "plant": variant.title,
                    "filter": TITLES[name],
                    "RMSE of μ0": f"{median_interval(one.rmse for one in errors)}",
                    "coverage": _mean([one.coverage for one in errors]),
                    "friction known": _mean([one.known for one in errors]),
                    "RMSE of stiffness": f"{100 * _median([one.stiffness for one in errors]):.2g} %",
                    "its coverage": _mean([one.stiffness_coverage for one in errors]),
                }
            )
    return ReportTable(rows, left=("plant", "filter"))


def known_table(runs: Runs) -> ReportTable:
    """Return when the filters with an estimate of stiffness know friction, by surface, sensors and irregularity."""
    rows: list[dict[str, Any]] = []
    groups = dict.fromkeys((case.test.name, case.plant) for case, _ in runs if case.plant in SMOOTH_PLANTS)
    for test, plant in groups:
        for name in ESTIMATING:
            errors = [found[name] for case, found in runs if (case.test.name, case.plant) == (test, plant)]
            rows.append(
                {
                    "rail": test,
                    "sensors and track": SMOOTH_PLANTS[plant].title,
                    "filter": TITLES[name],
                    "force used": _mean([one.used for one in errors]),
                    "σ(log μ0)": f"{_median([one.deviation for one in errors]):.2g}",
                    "correlation": f"{_median([one.correlation for one in errors]):.2f}".replace("-", "−"),
                    "friction known": _mean([one.known for one in errors]),
                    "coverage while known": _mean([one.coverage_known for one in errors]),
                    "while not": _mean([one.coverage_unknown for one in errors]),
                }
            )
    return ReportTable(rows, left=("rail", "sensors and track", "filter"))


def _median(values: Sequence[float]) -> float:
    return float(np.median(values))


def _mean(values: Sequence[float]) -> str:
    """Return the mean of the finite values as a share in per cent."""
    finite = [value for value in values if math.isfinite(value)]
    return share(float(np.mean(finite))) if finite else "–"
