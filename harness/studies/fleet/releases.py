"""Releases of single groups: by hand, as a small modulation, and designed for information on the pads (D-optimal)."""

from collections.abc import Callable, Sequence
from functools import cache
from itertools import product

import numpy as np

from railgrip.estimators.belief import Matrix
from railgrip.studies.pad_monitor.evidence import evidence_of, formation
from railgrip.studies.pad_monitor.life import FIRST_SLOT, IN_TURN, SLOT, Life, Release, live

Releases = tuple[Release, ...]

PULSE = 0.2e5
"""Drop of the pressure in the modulation [Pa]."""
PULSE_DURATION = 1.0
"""Duration of a pulse [s]."""
CYCLES = 4
"""Pulses of each group in a stop."""

MODULATION: Releases = tuple(
    Release(group=g, start=FIRST_SLOT + (cycle * formation().groups + g) * PULSE_DURATION, duration=PULSE_DURATION,
            drop=PULSE)
    for cycle, g in product(range(CYCLES), range(formation().groups))
)  # fmt: skip
"""Small pulses of each group in turn."""

STARTS = tuple(FIRST_SLOT + slot * SLOT for slot in range(6))
DROPS = (1e5, float("inf"))
CANDIDATES: Releases = tuple(
    Release(group=g, start=start, duration=SLOT, drop=drop)
    for g, start, drop in product(range(formation().groups), STARTS, DROPS)
)
"""Releases from which a design is chosen: each as long as those by hand."""

DESIGN_SEEDS = (901, 902)
"""Trains whose first stop gives the expected information."""

Criterion = Callable[[Releases], float]


@cache
def expected_information(releases: Releases) -> Matrix:
    """Return the Fisher information on the health of each group's pads in a stop, shape (groups, groups).

    It is the mean over a stop of each of the trains in `DESIGN_SEEDS`. A stop's information is the inverse of the
    covariance that the filter of the monitor propagates with the Jacobians of the prediction, without its prior.
    """
    covariances = [
        evidence_of(*next(live(Life(stops=1, seed=seed, releases=releases)))).covariance for seed in DESIGN_SEEDS
    ]
    return np.asarray(np.mean([np.linalg.inv(covariance) for covariance in covariances], axis=0), dtype=np.float64)


def log_determinant(releases: Releases) -> float:
    """Return the logarithm of the determinant of the expected information."""
    return float(np.linalg.slogdet(expected_information(releases))[1])


def design(candidates: Sequence[Release], count: int, criterion: Criterion = log_determinant) -> Releases:
    """Return `count` of the candidates that maximise a criterion, in the order of time.

    Greedy choice, then exchanges of single releases until none improves the criterion: a local maximum.

    Source: Fedorov, Theory of Optimal Experiments (1972), ch. 3; Cook and Nachtsheim, Technometrics 22 (1980) 315.
    """
    chosen: Releases = ()
    for _ in range(count):
        chosen = _best(chosen, candidates, criterion)
    value = criterion(chosen)
    while True:
        for release in chosen:
            chosen = _best(tuple(other for other in chosen if other is not release), candidates, criterion)
        improved = criterion(chosen)
        if improved <= value + 1e-9 * abs(value):
            return chosen
        value = improved


def _best(chosen: Releases, candidates: Sequence[Release], criterion: Criterion) -> Releases:
    sets = (in_order((*chosen, candidate)) for candidate in candidates if candidate not in chosen)
    return max(sets, key=criterion)


def in_order(releases: Sequence[Release]) -> Releases:
    """Return releases in the order of time and group."""
    return tuple(sorted(releases, key=lambda release: (release.start, release.group, release.drop)))


def designed() -> Releases:
    """Return the design with the number of releases that are made by hand."""
    return design(CANDIDATES, len(IN_TURN))
