"""The quasi-static brake compared with the plant in the loop, with brute force, and with physical requirements."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sampling import FUZZ

from railgrip.simulate.run import braking_distance, run_stop
from railgrip.studies.k_factors import k_dry as brake_module
from railgrip.studies.k_factors.k_dry import brake_of, load_specification, quasi_static, scenario_of_draw
from railgrip.supervision.rare import estimates

PER_DRAW = 0.01
"""Share of the deceleration: pads settle over 0.2 MJ of 5 MJ of a unit, while friction rises by some 20 %."""


@pytest.fixture(scope="module")
def vt642():
    specification, scenario = load_specification(Path("vt642"))
    return specification, scenario, brake_of(specification, scenario)


@pytest.fixture(scope="module")
def brake(vt642):
    return vt642[2]


@pytest.fixture(scope="module")
def nominal(vt642):
    """The stop of the nominal train in the loop."""
    _, scenario, brake = vt642
    return run_stop(scenario_of_draw(scenario, brake, brake.units, None))


def test_the_nominal_stop_is_that_of_the_plant(brake, nominal):
    trace = nominal.trace
    speed, distance = trace.speed.values, trace.distance.values
    assert brake.distance == pytest.approx(distance[-1], rel=PER_DRAW)
    for nominal, low, high in zip(brake.nominal, (0.0, 40.0, 80.0), (40.0, 80.0, 115.0), strict=False):
        inside = np.flatnonzero((3.6 * speed >= low) & (3.6 * speed < high))  # the build-up ends above 115 km/h
        first, last = inside[0], inside[-1]
        mean = (speed[first] ** 2 - speed[last] ** 2) / (2 * (distance[last] - distance[first]))
        assert nominal == pytest.approx(mean, rel=1.5 * PER_DRAW)


@pytest.mark.parametrize("available", [(3, 2, 2, 3), (2, 2, 1, 3), (0, 2, 2, 3)])
def test_a_drawn_train_stops_in_the_loop_like_the_quasi_static_one(vt642, nominal, available):
    _, scenario, brake = vt642
    standard = 1.5 * np.random.default_rng(sum(available)).standard_normal(brake.dimension)
    drawn = braking_distance(scenario_of_draw(scenario, brake, available, standard))
    assert drawn is not None
    ratio = brake.equivalent_deceleration(drawn) / brake.equivalent_deceleration(nominal.braking_distance)
    # effects neglected in the nominal stop cancel, except for the part that depends on the draw
    assert brake.ratios(available, standard[None, :])[0, -1] == pytest.approx(ratio, rel=0.5 * PER_DRAW)


@pytest.mark.usefixtures("few_rates")
def test_brute_force_finds_the_same_k_at_one_in_ten_thousand(vt642, monkeypatch):
    """Failures drawn like all other quantities; one speed step and one part on both sides, to save time.

    Of trains without a failure, 99.9 % of all, one in eight is braked and counts eightfold: they determine the quantile
    of one in a thousand, those with failures the rarer ones.
    """
    specification, scenario, _ = vt642
    monkeypatch.setattr(brake_module, "PARTS", 1)
    specification = specification.model_copy(update={"speed_steps": ()})
    brake = brake_of(specification, scenario)
    result = quasi_static(specification, brake)
    random, count, chunk, share = np.random.default_rng(11), 10**7 if FUZZ else 10**6, 4_000, 8
    failures = specification.failures
    unit, valve = failures.isolated_unit, failures.stuck_valve
    together = unit.common_cause.beta * unit.probability
    alone = unit.probability - together
    # Failures of all trains first, because trains with the same units are braked together.
    places = np.array(brake.units) + 1
    trains = np.zeros(places.prod(), dtype=int)
    for _ in range(10):
        left = random.binomial(brake.units, 1 - alone, (count // 10, len(brake.units)))
        left[random.random(left.shape) < together] = 0
        left[random.random(left.shape) < (1 - valve.common_cause.beta) * valve.probability] = 0
        left[random.random(len(left)) < valve.common_cause.beta * valve.probability] = 0
        trains += np.bincount(np.ravel_multi_index(tuple(left.T), tuple(places)), minlength=trains.size)
    assert trains.sum() == count
    lowest: list[np.ndarray] = []
    for kind in np.flatnonzero(trains):
        available = tuple(int(units) for units in np.unravel_index(kind, tuple(places)))
        weight = share if available == tuple(brake.units) else 1
        draws = trains[kind] // weight
        for first in range(0, draws, chunk):
            standard = random.standard_normal((min(chunk, draws - first), brake.dimension))
            ratios = brake.ratios(available, standard)[:, 0]
            lowest.append(np.stack([ratios[ratios < 0.95], np.full(np.count_nonzero(ratios < 0.95), weight)]))
    ratios, weights = np.concatenate(lowest, axis=1)
    order = np.argsort(ratios)
    below, reach = np.cumsum(weights[order]), 3.3 * np.sqrt(np.cumsum(weights[order] ** 2))
    for level, probability in ((3, 1e-3), (4, 1e-4), (5, 1e-5))[: 3 if FUZZ else 2]:
        # The number of draws below a quantile is binomial: order statistics enclose it with 99.9 %.
        low, high = (
            ratios[order[np.argmax(number >= count * probability)]] for number in (below + reach, below - reach)
        )
        one = result.k[0][level]
        assert low <= one.high
        assert one.low <= high


def test_a_draw_without_deviation_is_the_nominal_train(vt642):
    specification, scenario, brake = vt642
    # All values are nominal at zero, except the wheels, which are nominal when new.
    around = [one for one in specification.dispersion if one.quantity != "wheel_radius"]
    same = brake_of(specification.model_copy(update={"dispersion": tuple(around)}), scenario)
    assert same.ratios(same.units, np.zeros((1, same.dimension))) == pytest.approx(np.ones((1, 4)), rel=1e-12)
    assert same.nominal == pytest.approx(brake.nominal)


@given(seed=st.integers(0, 2**32), group=st.integers(0, 3))
def test_fewer_units_brake_less_and_draws_together_equal_single_ones(brake, seed, group):
    standard = np.random.default_rng(seed).standard_normal((5, brake.dimension))
    available = [n - (g == group) for g, n in enumerate(brake.units)]
    whole, fewer = brake.ratios(brake.units, standard), brake.ratios(available, standard)
    assert (fewer < whole).all()
    one_by_one = np.concatenate([brake.ratios(brake.units, one[None, :]) for one in standard])
    assert whole == pytest.approx(one_by_one, rel=1e-12)


def test_a_brake_without_any_units_is_slowed_by_resistance(brake):
    """Over a step s = M/(2C) ln((A + C v₁²)/(A + C v₂²)) with resistance A + C v²."""
    new_wheels = np.where(np.arange(brake.dimension) < brake.dimension - 2, 8.0, 0.0)  # mass and build-up are last
    ratios = (brake.ratios([0, 0, 0, 0], new_wheels[None, :])[0] * brake.nominal)[:-1]
    mass, c = 84e3, 0.5 * 1.2 * 0.9 * 10
    a = mass * 9.81 * (0.0018 * 0.065 + 0.0004) / 0.385
    mass += (2 * 222 + 2 * 209) / 0.385**2
    limits = np.array([0.0, 40.0, 80.0, 120.0]) / 3.6
    exact = c * np.diff(limits**2) / (mass * np.diff(np.log(a + c * limits**2)))
    assert ratios == pytest.approx(exact, rel=0.005)  # four parts of a step


@pytest.mark.usefixtures("few_rates")
def test_intervals_shrink_with_the_runs(vt642):
    specification, _, brake = vt642
    effort = specification.estimate.model_copy(update={"runs": 12, "samples": 60})
    runs = quasi_static(specification.model_copy(update={"estimate": effort}), brake).runs[-1]
    few, many = (estimates(of, [1e-9], 1e-12)[0] for of in (runs[:4], runs))
    assert many.high - many.low < few.high - few.low
