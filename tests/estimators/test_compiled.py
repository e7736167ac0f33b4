import ctypes

import numpy as np
import pytest
from small_models import (
    DENSITY,
    FIRST_MEAN,
    FIRST_VARIANCE,
    PERIOD,
    READING,
    WHEELSET,
    wheelset,
)

from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.design import Gate
from railgrip.estimators.ekf import ExtendedKalmanFilter
from railgrip.estimators.model_in_c import generate
from railgrip.estimators.prediction import CasadiPrediction
from railgrip.fmus.native.toolchain import shared_library

GATE = Gate(states=("mu_b",), inputs=("pad_force",), threshold=1500.0)


@pytest.fixture
def fast(rolling):
    return CompiledFilter(rolling, DENSITY, READING, PERIOD)


HELD, SEEN = np.array([1e4, 0.0]), np.array([22.1, 58.0, -0.7])


def assert_same(one, other, tolerance):
    """Means in units of the states' deviation or size, covariances as correlations."""
    size = np.maximum(np.abs(one.mean), one.deviation)
    assert np.max(np.abs(one.mean - other.mean) / size) < tolerance
    spread = np.outer(one.deviation, one.deviation)
    assert np.max(np.abs(one.covariance - other.covariance) / spread) < tolerance


def test_compiled_equals_python_with_dropouts_outliers_and_gates(rolling):
    """The two filters are compared at every step; neither uses the other's estimate."""
    parts = (rolling, DENSITY, READING, PERIOD, GATE, [5.0, np.inf, 8.0])
    plain, fast = ExtendedKalmanFilter(*parts), CompiledFilter(*parts)
    one = two = plain.start(FIRST_MEAN, FIRST_VARIANCE)
    random = np.random.default_rng(7)
    left_out = 0
    for k in range(6_000):
        held = np.array([max(0.0, 2e4 * np.sin(k / 900.0)), 500.0 * np.cos(k / 3000.0)])
        seen = rolling.output(one.mean, held) + np.sqrt(READING) * random.standard_normal(3)
        if k % 5:
            seen[1] = np.nan
        if k % 100 == 0:
            seen[0] += 3.0
        if k % 250 == 0:
            seen[1] += 20.0 * np.sqrt(READING[1])  # as far off, but used: this reading has no limit
        if k % 100 == 51:
            nis = plain.innovation(plain.predict(one, held), held, seen).nis
        one, two = plain.step(one, held, seen), fast.step(two, held, seen)
        if k % 100 == 51:
            assert fast.squared_innovation == pytest.approx(nis, rel=1e-8)
            assert fast.selection.tolist() == [1.0, 0.0, 1.0]
        left_out += int(fast.selection[0] == 0.0)
        if k % 100 == 0:
            assert_same(one, two, 1e-9)
    assert_same(one, two, 1e-9)
    assert left_out > 50  # the outliers occurred and were rejected


def test_compiled_equals_python_with_correlated_noise(linear):
    density, reading = np.diag([0.0, 0.0, 1e-2, 1e-2]), np.diag([1e-8, 1e-3])
    density[2, 3] = density[3, 2] = 6e-3
    reading[0, 1] = reading[1, 0] = -2e-6
    parts = (linear, density, reading, PERIOD)
    plain, fast = ExtendedKalmanFilter(*parts), CompiledFilter(*parts)
    one = two = plain.start(np.zeros(4), np.array([1e-6, 1e-6, 1e-2, 1e-2]))
    random = np.random.default_rng(8)
    for _ in range(500):
        held, seen = random.normal(0.0, 1e4, 1), random.normal(0.0, [1e-3, 1.0])
        one, two = plain.step(one, held, seen), fast.step(two, held, seen)
        assert_same(one, two, 1e-9)


def test_it_continues_from_any_given_estimate(fast):
    """Estimates are values: a step depends on its arguments, not on earlier steps."""
    first = fast.start(FIRST_MEAN, FIRST_VARIANCE)
    once = fast.step(first, HELD, SEEN)
    fast.step(once, HELD, SEEN)
    again = fast.step(first, HELD, SEEN)
    assert np.array_equal(again.mean, once.mean)
    assert np.array_equal(again.covariance, once.covariance)
    with pytest.raises(ValueError, match="read-only"):
        once.mean[0] = 0.0


def test_advance_in_place_equals_step(fast):
    belief = fast.start(FIRST_MEAN, FIRST_VARIANCE)
    for _ in range(3):
        belief = fast.step(belief, HELD, SEEN)
    fast.start(FIRST_MEAN, FIRST_VARIANCE)
    for _ in range(3):
        fast.inputs[:], fast.readings[:] = HELD, SEEN
        fast.advance()
    assert np.array_equal(fast.mean, belief.mean)
    assert np.array_equal(fast.covariance, belief.covariance)


def test_parameters_change_without_compiling_again(own_cache, fast):
    worn = CasadiPrediction(wheelset(), WHEELSET | {"r_wheel": 0.36})
    built = sorted(own_cache.rglob("*.*"))
    other = CompiledFilter(worn, DENSITY, READING, PERIOD)
    assert sorted(own_cache.rglob("*.*")) == built
    first = fast.start(FIRST_MEAN, FIRST_VARIANCE)
    expected = ExtendedKalmanFilter(worn, DENSITY, READING, PERIOD).step(first, HELD, SEEN)
    assert_same(expected, other.step(first, HELD, SEEN), 1e-12)
    fast.parameters[:] = worn.parameters
    assert np.array_equal(fast.step(first, HELD, SEEN).mean, other.step(first, HELD, SEEN).mean)


def test_a_machine_without_wide_vectors_gets_the_same_bits(rolling):
    """The step compiled for any machine, called directly, compared with the variant for this machine."""
    fast = CompiledFilter(rolling, DENSITY, READING, PERIOD, GATE)
    design = fast.design
    code = generate(rolling.in_c(), design.gated_states, design.gating_inputs, design.order)
    plain = "int step_plain(double *block);\n" + (
        "int dispatch(double *block) { return step_plain(block); }\n"
        '__attribute__((visibility("default"))) int step(double *block) { return dispatch(block); }\n'
    )
    library = shared_library(code.sources | {"dispatch.c": plain}, "plain", flags=("-O3",))
    step_plain = ctypes.CDLL(str(library)).step
    step_plain.argtypes = [ctypes.c_void_p]
    fast.start(FIRST_MEAN, FIRST_VARIANCE)
    block = fast._block.copy()
    random = np.random.default_rng(9)
    for k in range(300):
        fast.inputs[:] = [2e4 * (k % 40 > 10), 500.0]
        fast.readings[:] = [22.0, 57.0, -0.7] + np.sqrt(READING) * random.standard_normal(3)
        block[code.layout["INPUT"]], block[code.layout["READING"]] = fast.inputs, fast.readings
        fast.advance()
        assert step_plain(block.ctypes.data) == 0
    assert np.array_equal(block, fast._block)
