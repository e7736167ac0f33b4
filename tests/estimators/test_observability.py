import numpy as np
import pytest
from scipy.linalg import expm
from small_models import small_model

from railgrip.base.errors import EstimatorError
from railgrip.estimators.observability import along, gramian, observability, readings_and_rates
from railgrip.estimators.prediction import CasadiPrediction


def test_a_hidden_direction_names_all_states_that_contribute():
    """Only the sum of two forces is observed: neither is determined, the third state is."""
    both = CasadiPrediction(
        small_model(
            "v a b",
            "",
            "",
            "speed",
            lambda t, x, u, p: [x[1] + x[2], 0 * x[1], 0 * x[2]],
            lambda t, x, u, p: [x[0]],
        ),
        {},
    )
    found = observability(both, np.array([1.0, 2.0, 3.0]), np.zeros(0), np.ones(3))
    assert (found.rank, found.undetermined) == (2, ("a", "b"))
    assert np.abs(found.null_space[0]) == pytest.approx([0.0, np.sqrt(0.5), np.sqrt(0.5)], abs=1e-12)


def test_linear_rank_is_that_of_the_kalman_matrix(linear):
    origin, nothing = np.zeros(4), np.zeros(1)
    A, C = linear.derivative_jacobian(origin, nothing), linear.output_jacobian(origin, nothing)
    kalman = np.concatenate([C @ np.linalg.matrix_power(A, k) for k in range(4)])
    assert readings_and_rates(linear, 3, origin, nothing)[1] == pytest.approx(kalman, rel=1e-9)
    found = observability(linear, origin, nothing, np.array([1e-3, 1e-3, 0.1, 0.1]))
    assert found.complete


def test_gramian_of_a_linear_model_is_the_sum_over_its_exponential(linear):
    origin, nothing = np.zeros(4), np.zeros(1)
    A, C = linear.derivative_jacobian(origin, nothing), linear.output_jacobian(origin, nothing)
    R = np.diag([1e-8, 1e-2])
    expected = np.zeros((4, 4))
    for k in range(100):
        seen = C @ expm(A * k * 1e-3)
        expected += seen.T @ np.linalg.inv(R) @ seen
    ours = gramian(linear, np.zeros((100, 4)), np.zeros((100, 1)), 1e-3, np.diag(R))
    # Φ to the power of 100 carries 100 times its Taylor remainder, (|λ|T)⁵/120 = 1e-8 with |λ| = 66 1/s.
    size = np.sqrt(np.diag(expected))
    assert np.max(np.abs(ours - expected) / np.outer(size, size)) < 4 * 100 * 1e-8


def test_deviation_is_that_of_least_squares(rolling):
    """The covariance of the best unbiased estimate from a window is the inverse of its Gramian."""
    x, u = np.tile([22.0, 57.0, 0.36, 0.06], (60, 1)), np.tile([2e4, 0.0], (60, 1))
    noise, scale = np.array([1e-4, 1e-4, 1e-3]), np.array([20.0, 50.0, 0.35, 0.1])
    _, _, deviation = along(rolling, x, u, 1e-3, noise, scale, window=60, stride=1)
    inverse = np.linalg.inv(gramian(rolling, x, u, 1e-3, noise))
    assert deviation[0] == pytest.approx(np.sqrt(np.diag(inverse)), rel=1e-6)


def test_arguments_without_an_answer_are_refused_with_a_sentence(rolling):
    x, u = np.array([22.0, 57.0, 0.36, 0.06]), np.array([2e4, 0.0])
    with pytest.raises(EstimatorError, match="scale requires a positive size for each of v, w, mu_b, alpha"):
        observability(rolling, x, u, np.array([1.0, 1.0, 0.0, 1.0]))
    with pytest.raises(EstimatorError, match="requires 4 states and 2 inputs"):
        observability(rolling, x[:3], u, np.ones(4))
    with pytest.raises(EstimatorError, match="window must be 1 to 5 samples"):
        along(rolling, np.tile(x, (5, 1)), np.tile(u, (5, 1)), 1e-3, np.ones(3), np.ones(4), 6, 1)
