"""K_dry of a brake, by importance sampling of its quasi-static decelerations within each failure state."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import ndtri

from railgrip.base.arrays import generator
from railgrip.base.errors import InputError
from railgrip.estimators.belief import Array
from railgrip.rolling_stock.dispersion import Failures
from railgrip.supervision import rare
from railgrip.supervision.dispersed import DispersedBrake
from railgrip.supervision.rare import Rates, Sample, State
from railgrip.trace.k_wet import Interval

PROBABILITIES = (0.5, *(10.0**-level for level in range(1, 10)))
"""Probability of a deceleration below K times the nominal one, for EBCL 0 to 9 (SUBSET-040, K_dry_rst)."""

_RATES = 1000
"""Draws of the failure rates, of which 25 are beyond either end of an interval."""

_NEGLECT = 1e-3
"""Maximum probability of neglected failure states, as a share of the smallest probability required."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class QuasiStatic:
    """K of the quasi-static brake.

    Attributes:
        runs: For each output, the sample of each run.
        k: For each output, K of EBCL 0 to 9, with the interval of sampling alone.
        k_of_rates: The same with the interval that also holds the uncertainty of the failure rates.
        states: Failure states that were sampled.
        neglected: Probability of all other failure states.
    """

    runs: tuple[tuple[Sample, ...], ...]
    k: tuple[tuple[Interval, ...], ...]
    k_of_rates: tuple[tuple[Interval, ...], ...]
    states: tuple[State, ...]
    neglected: float
    seconds: float

    @property
    def draws(self) -> int:
        """Draws in all runs."""
        return sum(len(run.values) for run in self.runs[0])


def k_factors(
    brake: DispersedBrake,
    failures: Failures,
    *,
    seed: int,
    runs: int,
    samples: int,
    guides: Sequence[int] | None = None,
    notify: Callable[[str], None] = lambda what: None,
) -> QuasiStatic:
    """Return K of a quasi-static brake for all EBCL; the same arguments give the same numbers.

    Args:
        brake: Train with dispersed components. Its dynamic brakes fail as `failures.dynamic_brake`.
        failures: Failures of its components.
        seed: Seed of the draws.
        runs: Independent runs, for the intervals.
        samples: Draws of each failure state in each run.
        guides: Outputs whose worst points are sampled, all of them unless given; other outputs scatter more.
        notify: Receives the progress.

    Raises:
        InputError: The train has dynamic brakes, but their failures are not given.
    """
    begin = time.perf_counter()
    smallest = PROBABILITIES[-1]
    rates = rates_of(failures)
    # As deep and as many as the highest rates require, because the intervals include these rates.
    highest = rates_of(failures, float(ndtri((1 + rare.CONFIDENCE) / 2)))
    deep, neglected = rare.states_of(brake.units, highest, neglect=_NEGLECT * smallest)
    available, without = [state.available for state in deep], brake.without
    probabilities = rates.of_states(brake.units, available)
    cases = [(brake, "", 1.0)]
    if without is not None:
        lost = _loss(failures)
        cases = [(brake, "", 1 - lost), (without, " without dynamic brakes", lost)]
    states = tuple(
        State(*state) for *_, share in cases for state in zip(available, (share * probabilities).tolist(), strict=True)
    )
    parts: list[list[list[Sample]]] = [[[] for _ in range(runs)] for _ in brake.outputs]
    sampled = [(of, words, share, state) for of, words, share in cases for state in deep]
    for number, (of, words, share, state) in enumerate(sampled, start=1):
        notify(f"failure state {number} of {len(sampled)}")
        performance = partial(of.ratios, state.available)
        depth = rare.depth(State(state.available, share * state.probability), smallest)
        points = rare.worst_points(performance, of.dimension, depth, guides)
        random = generator(seed, f"k_factors {state.available}{words}")
        for run in range(runs):
            ratios, weights = rare.importance_sample(performance, points, samples, random)
            for output, of_output in enumerate(parts):
                of_output[run].append(Sample(ratios[:, output], weights))
    shares = [state.probability for state in states]
    pooled = tuple(tuple(rare.pool_samples(part, shares) for part in of_output) for of_output in parts)
    k = tuple(rare.estimates(of_output, PROBABILITIES, neglected) for of_output in pooled)
    counts = np.array(available)
    drawn = np.array([numbers.of_states(brake.units, counts) for numbers in _draw_rates(failures, seed)])
    if failures.dynamic_brake is not None and without is not None:
        standard = generator(seed, "k_factors dynamic brakes").permutation(_standard()).tolist()
        losses = np.array([[failures.dynamic_brake.quantile(each)] for each in standard])
        drawn = np.hstack([(1 - losses) * drawn, losses * drawn])
    equal = [1 / runs] * runs
    k_of_rates = tuple(
        rare.widen(of, [rare.pool_samples(state, equal) for state in zip(*part, strict=True)], drawn, PROBABILITIES)
        for of, part in zip(k, parts, strict=True)
    )
    return QuasiStatic(
        runs=pooled,
        k=k,
        k_of_rates=k_of_rates,
        states=states,
        neglected=neglected,
        seconds=time.perf_counter() - begin,
    )


def _loss(failures: Failures) -> float:
    if failures.dynamic_brake is None:
        raise InputError(
            "[failures] has no dynamic_brake; K factors of a train with electrodynamic or eddy-current brakes need the "
            "probability that these are off: give [failures.dynamic_brake] probability, error_factor and source"
        )
    return failures.dynamic_brake.quantile(0.0)


def rates_of(failures: Failures, *standard: float) -> Rates:
    """Return the failure probabilities, standard deviations of their logarithms above their medians."""
    isolated, stuck = failures.isolated_unit, failures.stuck_valve
    first, last = (standard[0], standard[-1]) if standard else (0.0, 0.0)
    return Rates(
        isolated=isolated.quantile(first),
        stuck=stuck.quantile(last),
        isolated_beta=isolated.common_cause.beta,
        stuck_beta=stuck.common_cause.beta,
    )


def _standard() -> Array:
    return ndtri((np.arange(_RATES) + 0.5) / _RATES)


def _draw_rates(failures: Failures, seed: int) -> list[Rates]:
    random = generator(seed, "k_factors rates")
    pairs = zip(_standard(), random.permutation(_standard()), strict=True)
    return [rates_of(failures, float(first), float(last)) for first, last in pairs]
