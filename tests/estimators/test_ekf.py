import numpy as np
import pytest
from small_models import DENSITY, FIRST_MEAN, FIRST_VARIANCE, PERIOD, READING

from railgrip.base.errors import EstimatorError, FilterDiverged
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.design import Gate
from railgrip.estimators.ekf import ExtendedKalmanFilter


@pytest.fixture
def ours(rolling):
    return ExtendedKalmanFilter(rolling, DENSITY, READING, PERIOD)


@pytest.fixture
def first(ours):
    return ours.start(FIRST_MEAN, FIRST_VARIANCE)


@pytest.fixture
def gated(rolling):
    gate = Gate(states=("mu_b",), inputs=("pad_force",), threshold=1500.0)
    return ExtendedKalmanFilter(rolling, DENSITY, READING, PERIOD, gate)


def test_a_missing_reading_is_a_filter_without_that_sensor(rolling, ours, first):
    """NaN leaves the row out: equivalent to a reading of practically infinite variance."""
    held = np.array([1e4, 0.0])
    seen = rolling.output(FIRST_MEAN, held) + np.array([0.01, 0.02, 0.1])
    worthless = ExtendedKalmanFilter(rolling, DENSITY, READING * np.array([1.0, 1e20, 1.0]), PERIOD)
    without = ours.step(first, held, np.where([False, True, False], np.nan, seen))
    other = worthless.step(first, held, seen)
    # A variance of 1e16 against one of 0.1 is a weight of 1e-17, below rounding.
    assert without.mean == pytest.approx(other.mean, rel=1e-12)
    assert without.covariance == pytest.approx(other.covariance, rel=1e-9, abs=1e-15)


def test_without_any_reading_it_only_predicts(ours, first):
    held = np.array([1e4, 0.0])
    blind = ours.step(first, held, np.full(3, np.nan))
    predicted = ours.predict(first, held)
    assert np.array_equal(blind.mean, predicted.mean)
    assert np.array_equal(blind.covariance, predicted.covariance)


def test_an_outlier_is_left_out_and_only_it(rolling, ours, first):
    careful = ExtendedKalmanFilter(rolling, DENSITY, READING, PERIOD, outlier_limit=6.0)
    held = np.array([1e4, 0.0])
    seen = rolling.output(FIRST_MEAN, held)
    thrown = careful.step(first, held, seen + np.array([0.0, 300.0, 0.0]))
    expected = ours.step(first, held, np.where([False, True, False], np.nan, seen))
    assert np.array_equal(thrown.mean, expected.mean)
    assert np.array_equal(thrown.covariance, expected.covariance)
    other = ExtendedKalmanFilter(rolling, DENSITY, READING, PERIOD, outlier_limit=[6.0, np.inf, 6.0])
    believing = other.step(first, held, seen + np.array([0.0, 300.0, 0.0]))
    assert np.array_equal(believing.mean, ours.step(first, held, seen + np.array([0.0, 300.0, 0.0])).mean)


def test_the_gate_opens_at_its_threshold(rolling, gated, first):
    seen = rolling.output(FIRST_MEAN, np.zeros(2)) + 0.05
    assert gated.step(first, np.array([1499.9, 0.0]), seen).mean[2] == first.mean[2]
    assert gated.step(first, np.array([1500.0, 0.0]), seen).mean[2] != first.mean[2]


def test_a_frozen_state_is_a_consider_state(rolling, gated):
    """Schmidt: the others' gain is optimal for the joint covariance; the frozen one keeps its own."""
    held = np.zeros(2)
    joint = np.diag(FIRST_VARIANCE)
    joint[1, 2] = joint[2, 1] = 0.8 * np.sqrt(joint[1, 1] * joint[2, 2])
    predicted = gated.predict(gated.start(FIRST_MEAN, joint), held)
    assert (predicted.mean[2], predicted.covariance[2, 2]) == (FIRST_MEAN[2], joint[2, 2])
    innovation = gated.innovation(predicted, held, rolling.output(predicted.mean, held) + np.sqrt(READING))
    after = gated.condition(predicted, held, innovation)
    H, P, others = innovation.jacobian, predicted.covariance, [0, 1, 3]
    S = H @ P @ H.T + np.diag(READING)
    optimal = P - P @ H.T @ np.linalg.inv(S) @ H @ P
    # P loses four of its sixteen digits to the readings; the rest is margin.
    assert after.covariance[np.ix_(others, others)] == pytest.approx(
        optimal[np.ix_(others, others)], rel=1e-7, abs=1e-12
    )
    assert after.covariance[2, others] == pytest.approx(optimal[2, others], rel=1e-7, abs=1e-12)
    assert after.covariance[2, 2] == P[2, 2] > 1.1 * optimal[2, 2]
    assert after.mean[2] == FIRST_MEAN[2]
    assert np.all(after.mean[others] != predicted.mean[others])


def test_covariance_stays_definite_and_symmetric_for_any_readings(rolling):
    """10 s of near-perfect sensors, huge noise, dropouts and gates, from a badly scaled start."""
    gate = Gate(states=("mu_b",), inputs=("pad_force",), threshold=1500.0)
    density, reading = np.array([1e-12, 1e3, 1e-9, 1e2]), np.array([1e-14, 1e-14, 1e-10])
    ours = ExtendedKalmanFilter(rolling, density, reading, PERIOD, gate)
    belief = ours.start(FIRST_MEAN, np.array([1e6, 1e-12, 1e4, 1e-12]))
    random = np.random.default_rng(4)
    for k in range(10_000):
        held = np.array([random.choice([0.0, 1.4e3, 3e4]), random.normal(0.0, 1e4)])
        seen = rolling.output(belief.mean, held) + random.standard_t(3, 3) * np.array([1e-7, 1e-7, 1e-5])
        seen[random.random(3) < 0.3] = np.nan
        belief = ours.step(belief, held, seen)
        if k < 50 or k % 50 == 0:
            assert np.array_equal(belief.covariance, belief.covariance.T)
            # Correlations, because variances of 1e4 and 1e-14 next to each other hide each other's sign.
            correlation = belief.covariance / np.outer(belief.deviation, belief.deviation)
            assert np.min(np.linalg.eigvalsh(correlation)) > 0.0


@pytest.mark.parametrize(("kind", "predicted"), [(ExtendedKalmanFilter, "v, w"), (CompiledFilter, "mean")])
def test_a_mean_that_is_not_finite_is_a_diverged_filter(rolling, kind, predicted):
    """A compiled filter keeps its estimate."""
    filter_ = kind(rolling, DENSITY, READING, PERIOD)
    first = filter_.start(FIRST_MEAN, FIRST_VARIANCE)
    with pytest.raises(FilterDiverged, match=f"predicted {predicted}"):
        filter_.step(first, np.array([np.nan, np.nan]), np.zeros(3))
    with pytest.raises(FilterDiverged, match="readings"):
        filter_.step(first, np.zeros(2), np.array([np.inf, 0.0, 0.0]))
    if kind is CompiledFilter:
        assert np.array_equal(filter_.mean, FIRST_MEAN)
        assert np.array_equal(filter_.covariance, np.diag(FIRST_VARIANCE))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"process_noise": -np.ones(4)}, "negative eigenvalue"),
        ({"reading_noise": np.array([1.0, 0.0, 1.0])}, "not positive definite; give every reading"),
        ({"reading_noise": np.arange(9.0).reshape(3, 3)}, "not symmetric"),
        ({"reading_noise": np.full(3, np.nan)}, "not a finite number"),
        ({"period": 0.0}, "period must be a positive number of seconds, got 0.0"),
        ({"outlier_limit": -1.0}, "outlier_limit"),
        ({"outlier_limit": [5.0, 5.0]}, r"outlier_limit must have shape \(3,\)"),
        (
            {"gate": Gate(states=("mu",), inputs=("pad_force",), threshold=1.0)},
            "no state 'mu'; there are v, w",
        ),
        ({"gate": Gate(states=("mu_b",), inputs=("force",), threshold=1.0)}, "no input 'force'"),
    ],
)
def test_an_invalid_filter_is_refused(rolling, change, sentence):
    parts = {"process_noise": DENSITY, "reading_noise": READING, "period": PERIOD} | change
    with pytest.raises(EstimatorError, match=sentence):
        ExtendedKalmanFilter(rolling, **parts)


@pytest.mark.parametrize("kind", [ExtendedKalmanFilter, CompiledFilter])
def test_arguments_of_wrong_shape_are_refused(rolling, kind):
    filter_ = kind(rolling, DENSITY, READING, PERIOD)
    first = filter_.start(FIRST_MEAN, FIRST_VARIANCE)
    with pytest.raises(EstimatorError, match=r"inputs requires 2 inputs .*pad_force, track_force"):
        filter_.step(first, np.zeros(3), np.zeros(3))
    with pytest.raises(EstimatorError, match=r"readings requires 3 readings .* write NaN"):
        filter_.step(first, np.zeros(2), np.zeros(2))
    with pytest.raises(EstimatorError, match="process_noise must have shape"):
        kind(rolling, np.ones(3), READING, PERIOD)


@pytest.mark.parametrize(
    ("mean", "variance", "sentence"),
    [
        (np.zeros(5), FIRST_VARIANCE, "mean requires 4 states"),
        (np.array([1.0, 1.0, np.nan, 1.0]), FIRST_VARIANCE, "mean of mu_b is not"),
        (FIRST_MEAN, np.zeros(4), "covariance is not positive definite"),
    ],
)
def test_a_start_without_an_estimate_is_refused(ours, mean, variance, sentence):
    with pytest.raises(EstimatorError, match=sentence):
        ours.start(mean, variance)


def test_a_gate_names_one_input_for_each_state():
    with pytest.raises(EstimatorError, match="Gate: 1 states require as many inputs, got 0"):
        Gate(states=("mu_b",), inputs=(), threshold=1.0)
    with pytest.raises(EstimatorError, match="named once"):
        Gate(states=("mu_b", "mu_b"), inputs=("a", "b"), threshold=1.0)
