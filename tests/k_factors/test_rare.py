"""Small quantiles compared with closed forms, with all combinations, and with their own intervals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linear import LinearBrake, brute_states, specification
from sampling import FUZZ
from scipy.stats import binom, norm

from railgrip.studies.k_factors.k_dry import quasi_static
from railgrip.supervision.k_dry import PROBABILITIES
from railgrip.supervision.rare import (
    Rates,
    Sample,
    estimates,
    importance_sample,
    pool_samples,
    states_of,
    subset_cost,
    subset_sample,
    worst_points,
)

ISOLATED = 1e-3


def test_failure_states_are_those_of_every_combination_of_units_and_valves():
    states, rest = states_of((2, 1, 2), Rates(0.03, 0.01), neglect=0.0)
    every = brute_states((2, 1, 2), 0.03, 0.01)
    assert rest == 0.0
    assert {state.available: pytest.approx(state.probability, rel=1e-12) for state in states} == every


def test_the_omitted_probability_of_failure_states_is_exact():
    every, _ = states_of((3, 2, 2, 3), Rates(1e-4, 1e-5), neglect=0.0)
    states, rest = states_of((3, 2, 2, 3), Rates(1e-4, 1e-5), neglect=1e-12)
    left_out = sorted(state.probability for state in every if state.available not in {s.available for s in states})
    assert 0 < rest <= 1e-12
    assert rest == pytest.approx(sum(left_out), rel=1e-9)
    assert sum(state.probability for state in every) == pytest.approx(1.0, abs=1e-15)
    assert [state.probability for state in states] == sorted((state.probability for state in states), reverse=True)


def test_a_train_of_many_groups_has_few_relevant_states():
    states, rest = states_of((4,) * 30, Rates(1e-5, 1e-6), neglect=1e-10)
    assert len(states) < 10_000
    assert sum(state.probability for state in states) + rest == pytest.approx(1.0, abs=1e-13)


@pytest.mark.parametrize("beta", [0.0, 0.02, 0.1])
def test_two_units_in_parallel_fail_as_in_the_beta_factor_model(beta):
    """IEC 61508-6: P = β q + ((1 − β) q)², where simultaneous failures of both kinds are negligible."""
    q = 1e-4
    states, _ = states_of((2,), Rates(q, 0.0, isolated_beta=beta), neglect=0.0)
    lost, one_left = (next(s.probability for s in states if s.available == (left,)) for left in (0, 1))
    assert lost == pytest.approx(beta * q + ((1 - beta) * q) ** 2, rel=1e-7)
    alone = (1 - beta) * q
    assert one_left == pytest.approx((1 - beta * q) * 2 * alone * (1 - alone), rel=1e-12)


def test_a_common_cause_of_all_valves_affects_all_groups():
    """As for two components in parallel, with a valve of a group instead of a unit."""
    q, beta = 1e-3, 0.05
    states, _ = states_of((1, 1), Rates(0.0, q, stuck_beta=beta), neglect=1e-9)
    every = {state.available: state.probability for state in states}
    assert every[0, 0] == pytest.approx(beta * q + (1 - beta * q) * ((1 - beta) * q) ** 2, rel=1e-12)
    assert sum(every.values()) == pytest.approx(1.0, abs=1e-14)


def test_a_total_loss_may_be_among_the_omitted_states():
    rates = Rates(0.0, 1e-5, stuck_beta=0.015)
    (whole,), rest = states_of((3, 2), rates, neglect=1e-2)
    assert whole.available == (3, 2)
    assert whole.probability + rest == pytest.approx(1.0, abs=1e-11)


def test_states_with_common_causes_are_complete():
    rates = Rates(0.02, 0.01, isolated_beta=0.2, stuck_beta=0.1)
    states, rest = states_of((2, 1, 2), rates, neglect=0.0)
    assert rest == 0.0
    assert sum(state.probability for state in states) == pytest.approx(1.0, abs=1e-14)
    available = [state.available for state in states]
    assert len(set(available)) == len(available) == 3 * 2 * 3
    assert [state.probability for state in states] == pytest.approx(rates.of_states((2, 1, 2), available), rel=1e-14)


@pytest.mark.parametrize("error_factor", [1.0, 3.0, 10.0])
def test_the_interval_contains_the_effect_of_a_lognormal_rate(error_factor):
    """K falls with the rate, so its quantiles are those at the quantiles of the rate."""
    brake, median = LinearBrake(), 1e-4
    result = quasi_static(specification(runs=20, samples=500, isolated=median, error_factor=error_factor), brake)
    factor = error_factor ** (norm.ppf(0.975) / norm.ppf(0.95))
    for k, k_of_rates in zip(result.k, result.k_of_rates, strict=True):
        for probability, sampled, one in zip(PROBABILITIES, k, k_of_rates, strict=True):
            low, high = (brake.quantile(probability, rate) for rate in (median * factor, median / factor))
            # the interval also includes the sampling error on either side
            assert one.low == pytest.approx(low - (sampled.value - sampled.low), abs=3e-3)
            assert one.high == pytest.approx(high + (sampled.high - sampled.value), abs=3e-3)
            assert one.low <= sampled.low <= sampled.high <= one.high


def test_a_linear_gaussian_brake_has_quantiles_in_closed_form():
    brake = LinearBrake()
    result = quasi_static(specification(runs=20, samples=500), brake)
    for output in result.k:
        for probability, one in zip(PROBABILITIES, output, strict=True):
            exact = brake.quantile(probability, ISOLATED)
            assert one.value == pytest.approx(exact, abs=2e-3)
            # 20 intervals of 95 % do not all contain the value; intervals twice as wide do, except for one in ten
            # thousand
            assert 2 * one.low - one.value <= exact <= 2 * one.high - one.value


@pytest.mark.usefixtures("few_rates")
def test_intervals_contain_the_truth_at_their_nominal_rate():
    brake, seeds, levels = LinearBrake(), 40 if FUZZ else 20, (0, 2, 5, 9)
    exact = [brake.quantile(PROBABILITIES[level], ISOLATED) for level in levels]
    hits = np.zeros(len(levels))
    for seed in range(seeds):
        k = quasi_static(specification(seed=seed, runs=10, samples=100), brake).k[1]
        hits += [k[level].low <= truth <= k[level].high for level, truth in zip(levels, exact, strict=True)]
    # one in ten thousand correct intervals does worse, for each level
    assert min(hits) >= binom.ppf(1e-4, seeds, 0.95)
    assert max(hits) <= seeds
    assert hits.sum() < len(levels) * seeds  # an interval that is never wrong would be too wide


@pytest.mark.parametrize("probability", [1e-2, 1e-4, 1e-6])
def test_subset_simulation_finds_gaussian_quantiles(probability):
    direction = np.full(20, 20**-0.5)
    runs = [
        subset_sample(lambda u: u @ direction, 20, probability, 1000, np.random.default_rng(seed)) for seed in range(12)
    ]
    (result,) = estimates(runs, [probability], confidence=0.999)
    assert result.low <= norm.ppf(probability) <= result.high
    assert result.high - result.low < 0.6


def test_subset_simulation_has_the_stated_cost():
    for probability, samples in ((1.0, 20), (0.1, 50), (1e-2, 57), (3e-4, 100), (1e-6, 209)):
        evaluations = 0

        def performance(u):
            nonlocal evaluations
            evaluations += len(u)
            return u[:, 0]

        sample = subset_sample(performance, 3, probability, samples, np.random.default_rng(1))
        assert evaluations == subset_cost(probability, samples)
        assert sample.weights.sum() == pytest.approx(1.0)


def test_weights_average_to_one_and_sampled_moments_are_normal():
    points = worst_points(lambda u: u[:, :1] + 0.3 * u[:, 1:2] ** 2, 3, 4)
    assert np.linalg.norm(points, axis=1) == pytest.approx([0, 1, 2, 3, 4])
    u, weights = importance_sample(lambda u: u, points, 100_000, np.random.default_rng(3))
    # a thousand times the standard error of 1e5 plain draws is 3; weighted ones scatter up to twice as much
    assert weights.sum() == pytest.approx(1.0, abs=0.02)
    assert weights @ u == pytest.approx(np.zeros(3), abs=0.03)
    assert weights @ u**2 == pytest.approx(np.ones(3), abs=0.05)


numbers = st.lists(st.floats(-10, 10), min_size=1, max_size=60)


@settings(max_examples=60)
@given(values=numbers, probability=st.floats(1e-6, 1.0))
def test_the_quantile_of_equal_weights_is_that_of_the_empirical_distribution(values, probability):
    result = Sample(np.array(values), np.full(len(values), 1 / len(values))).quantile(probability)
    below, upto = np.mean(np.array(values) < result), np.mean(np.array(values) <= result)
    assert below <= probability + 1e-12
    assert upto >= probability - 1e-12


@settings(max_examples=60)
@given(first=numbers, second=numbers, share=st.floats(0.0, 1.0), probability=st.floats(0.01, 0.99))
def test_the_quantile_of_a_mixture_is_between_those_of_its_parts(first, second, share, probability):
    parts = [Sample(np.array(v), np.full(len(v), 1 / len(v))) for v in (first, second)]
    quantiles = sorted(part.quantile(probability) for part in parts)
    result = pool_samples(parts, [share, 1 - share]).quantile(probability)
    low, high = (Sample(part.values, part.weights) for part in parts)
    assert min(low.values[0], high.values[0]) <= result
    # rounding of the sums of weights may shift it to the next value
    assert result <= min([v for v in [*first, *second] if v > quantiles[1]], default=quantiles[1])


def test_a_quantile_as_small_as_the_omitted_probability_is_refused():
    sample = Sample(np.arange(10.0), np.full(10, 0.1))
    with pytest.raises(ValueError, match="left out"):
        estimates([sample, sample], [1e-9], neglected=1e-9)
