"""K_wet_rst from stops on dry and wet rail."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from railgrip.trace.k_wet import corrected_distance, equivalent_time, k_wet

SPEED, TIME = 33.3, 1.0


def test_a_dry_distance_of_four_fifths_is_a_k_of_four_fifths():
    dry, wet = [SPEED * TIME + 400.0] * 4, [SPEED * TIME + 500.0] * 4
    k = k_wet(dry, wet, SPEED, TIME)
    assert (k.value, k.low, k.high) == pytest.approx((0.8, 0.8, 0.8), rel=1e-12)


distances = st.lists(st.floats(100.0, 1000.0), min_size=2, max_size=6)


@given(dry=distances, wet=distances, scale=st.floats(0.5, 2.0))
def test_k_is_one_for_equal_stops_and_inverts_when_exchanged(dry, wet, scale):
    k, same = k_wet(dry, wet, SPEED, TIME), k_wet(dry, dry, SPEED, TIME)
    back = k_wet(wet, dry, SPEED, TIME)
    larger = k_wet([scale * d for d in dry], [scale * w for w in wet], SPEED, scale * TIME)
    assert k.low <= k.value <= k.high
    assert same.value == pytest.approx(1.0)
    assert (back.low, back.high) == pytest.approx((1 / k.high, 1 / k.low))
    assert larger.value == pytest.approx(k.value)


def test_the_interval_contains_the_true_k_at_its_nominal_rate():
    random, count = np.random.default_rng(7), 2000
    draw = lambda mean: SPEED * TIME + mean * (1 + 0.03 * random.standard_normal(4))
    k = [k_wet(draw(400.0), draw(500.0), SPEED, TIME) for _ in range(count)]
    hits = sum(one.low <= 0.8 <= one.high for one in k)
    # Welch's degrees of freedom are an approximation: 94 to 97 % with four stops each
    assert binom.ppf(1e-4, count, 0.94) <= hits <= binom.ppf(1 - 1e-4, count, 0.97)


def test_the_equivalent_time_is_dead_time_plus_time_constant():
    time = np.linspace(0.0, 20.0, 20_001)
    pressure = np.where(time < 0.4, 0.0, 3.4e5 * (1 - np.exp(-(time - 0.4) / 0.5)))
    assert equivalent_time(time, pressure) == pytest.approx(0.9, abs=1e-4)
    assert equivalent_time(time, np.stack([pressure, 0.5 * pressure], axis=1)) == pytest.approx(0.9, abs=1e-4)


def test_a_stop_is_corrected_to_its_nominal_speed():
    deceleration = 1.1
    stop = lambda v: v * TIME + v**2 / (2 * deceleration)
    assert corrected_distance(stop(32.0), 32.0, SPEED, TIME) == pytest.approx(stop(SPEED))


@pytest.mark.parametrize("dry", [[500.0], [500.0, 20.0], [500.0, float("nan")]])
def test_stops_without_information_are_refused(dry):
    with pytest.raises(ValueError, match="dry stops"):
        k_wet(dry, [500.0, 510.0], SPEED, TIME)


def test_a_release_has_no_equivalent_time():
    with pytest.raises(ValueError, match="under pressure"):
        equivalent_time(np.arange(3.0), np.zeros(3))
