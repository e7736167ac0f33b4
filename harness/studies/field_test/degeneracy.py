"""Where equation (14) is blind: two ways of changing noises that it does not see, or rewards."""

from collections.abc import Callable, Sequence

import numpy as np

from railgrip.estimators.belief import Array
from railgrip.estimators.compiled import CompiledFilter
from railgrip.studies.field_test.filtering import Task, follow
from railgrip.studies.field_test.noise import Noise
from railgrip.studies.field_test.score import score

COMMON = 10.0 ** np.arange(-4, 5, 1.0)
TRUSTED = 10.0 ** np.arange(-8, 3, 1.0)


Sweep = dict[str, Array]
"""Figures over brakings for each `factor`: worst `deviation`, means of `adhesion`, `pad_friction` and `nees`."""


def common_factor(tasks: Sequence[Task], filter_: CompiledFilter, noise: Noise) -> Sweep:
    """Return what a factor on R, Q and the first covariance does: nothing to the mean, everything to its spread."""
    return _sweep(tasks, filter_, COMMON, lambda f: (noise.scaled(f, f), f))


def readings_trusted(tasks: Sequence[Task], filter_: CompiledFilter, noise: Noise) -> Sweep:
    """Return what a factor on R alone does: towards zero the filter repeats its readings, and (14) goes to zero."""
    return _sweep(tasks, filter_, TRUSTED, lambda f: (noise.scaled(f, 1.0), 1.0))


def _sweep(
    tasks: Sequence[Task],
    filter_: CompiledFilter,
    factors: Array,
    setting: Callable[[float], tuple[Noise, float]],
) -> Sweep:
    rows: list[dict[str, float]] = []
    for factor in factors:
        noise, start = setting(float(factor))
        scores = [score(task, follow(task, filter_, noise, start)) for task in tasks]
        means = {name: float(np.mean([s[name] for s in scores])) for name in ("adhesion", "pad_friction", "nees")}
        rows.append({"factor": float(factor), "deviation": max(s["deviation"] for s in scores)} | means)
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}
