"""Where equation (14) is blind: two ways of changing noises that it does not see, or rewards."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from railgrip.estimators.belief import Array
from railgrip.estimators.compiled import CompiledFilter
from railgrip.studies.field_test.filtering import Task, follow
from railgrip.studies.field_test.noise import Noise
from railgrip.studies.field_test.objective import terms_of
from railgrip.studies.field_test.score import score

COMMON = 10.0 ** np.arange(-4, 5, 1.0)
TRUSTED = 10.0 ** np.arange(-8, 3, 1.0)


@dataclass(frozen=True, slots=True)
class Sweep:
    """Means over brakings, for each factor.

    Attributes:
        factor: Shape (k,).
        deviation: Worst O_c, equation (14) [m/s].
        adhesion: RMSE of α.
        pad_friction: RMSE of μ_B.
        nees: Of both, 1 wanted.
    """

    factor: Array
    deviation: Array
    adhesion: Array
    pad_friction: Array
    nees: Array


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
    rows: list[tuple[float, ...]] = []
    for factor in factors:
        noise, start = setting(float(factor))
        estimates = [follow(task, filter_, noise, start) for task in tasks]
        scores = [score(task, estimate) for task, estimate in zip(tasks, estimates, strict=True)]
        rows.append(
            (
                max(terms_of(task, estimate).deviation for task, estimate in zip(tasks, estimates, strict=True)),
                *(float(np.mean([getattr(s, name) for s in scores])) for name in ("adhesion", "pad_friction", "nees")),
            )
        )
    return Sweep(factors, *np.array(rows).T)
