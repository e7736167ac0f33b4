"""Search of noises on training cases: one coordinate search, with the same budget for every estimator."""

import math
import tomllib
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Final

import numpy as np

from railgrip.base.errors import FilterDiverged
from railgrip.base.files import write_text
from railgrip.estimation.judge import NORMAL_95
from railgrip.estimators.belief import Vector
from railgrip.studies.estimators.judge import errors_of_target
from railgrip.studies.estimators.recordings import SENSORS, RecordingCase, Sensors, recording_of_case
from railgrip.studies.estimators.replay import FACTORS, SEARCHED, noise_of, replay, states, with_estimates

BUDGET: Final = 48
"""Evaluations of an estimator for a class of sensors, each over all of its training cases."""

STEPS: Final = (3.0, 3.0, math.sqrt(3.0), math.sqrt(3.0))
"""Factors by which standard deviations change, one after the other in each pass."""

SMALLEST_GAIN: Final = 1e-3
"""Gain of `evaluate` that justifies a change: a tenth of a percent of an interval."""

SearchCase = tuple[str, Sensors, tuple[RecordingCase, ...]]
"""An estimator, a class of sensors, and training cases with these sensors."""


def interval_score(error: Vector, deviation: Vector) -> float:
    """Return the mean interval score of the claimed 95 % interval: its width plus 40 times the excess beyond it.

    It is smallest for the true quantiles, and an outlier counts linearly.

    Source: Gneiting and Raftery, Strictly Proper Scoring Rules, J. American Statistical Association 102 (2007) 359,
    eq. 43.
    """
    half = NORMAL_95 * deviation
    return float(np.mean(2.0 * half + 40.0 * np.maximum(np.abs(error) - half, 0.0)))


def evaluate(estimator: str, sensors: Sensors, cases: Sequence[RecordingCase], factors: Mapping[str, float]) -> float:
    """Return the mean over cases of the logarithms of the interval scores of adhesion and pad friction."""
    noise, total = noise_of(estimator, sensors, factors), 0.0
    for case in cases:
        try:
            found = replay(case, estimator, noise)
        except FilterDiverged:
            return math.inf
        trace = with_estimates(recording_of_case(case), states(estimator), found.mean, found.variance)
        for target in ("adhesion", "pad_friction"):
            error, deviation = errors_of_target(trace, target)
            total += math.log(interval_score(error, deviation)) if error.size else 0.0
    return total / len(cases)


def search(case: SearchCase) -> dict[str, float]:
    """Return the factors that minimise `evaluate`: each in turn up or down by a step, as long as the budget lasts.

    A factor without any effect is tried once.
    """
    estimator, sensors, cases = case
    factors: dict[str, float] = dict.fromkeys(FACTORS, 1.0)
    best, count, idle = evaluate(estimator, sensors, cases, factors), 1, set[str]()
    for step, name in product(STEPS, FACTORS):
        for change in () if name in idle else (step, 1.0 / step):
            if count >= BUDGET:
                return factors
            trial = factors | {name: factors[name] * change}
            value, count = evaluate(estimator, sensors, cases, trial), count + 1
            if value == best:
                idle.add(name)
                break
            if value < best - SMALLEST_GAIN:
                factors, best = trial, value
                break
    return factors


def search_cases(cases: Sequence[RecordingCase], estimators: Sequence[str] = SEARCHED) -> list[SearchCase]:
    """Return one search for each estimator and class of sensors."""
    return [
        (estimator, sensors, tuple(case for case in cases if case.sensors == sensors))
        for estimator in estimators
        for sensors in SENSORS
    ]


def read_factors(path: Path) -> dict[tuple[str, str], Mapping[str, float]]:
    """Return the factors in a file of `write_factors` by estimator and sensors."""
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    return {(estimator, sensors): row for estimator, rows in tables.items() for sensors, row in rows.items()}


def write_factors(path: Path, found: Mapping[tuple[str, str], Mapping[str, float]]) -> None:
    """Write factors by estimator and sensors as the file that `noise_of` reads."""
    lines = ["# Factors of standard deviations; written by `railgrip study estimators --tune`."]
    for (estimator, sensors), factors in found.items():
        values = ", ".join(f"{name} = {value:.4g}" for name, value in factors.items())
        lines += ["", f"[{estimator}]"] if f"[{estimator}]" not in lines else []
        lines.append(f"{sensors} = {{ {values} }}")
    write_text(path, "\n".join(lines) + "\n")
