import numpy as np
import pytest
from scipy.linalg import expm
from small_models import OSCILLATOR, WHEELSET, oscillator, small_model, wheelset

from railgrip.errors import EstimatorError
from railgrip.estimators.observability import along, gramian, observability, readings_and_rates
from railgrip.estimators.prediction import CasadiPrediction

WAGON = {"m": 40e3, "J": 130.0, "r_wheel": 0.46, "r_friction": 0.25, "h": 1.0, "a": 12.0, "k_d": -5.0}
WAGON_SCALE = np.array([50.0, 50.0, 20.0, 0.3, 0.3, 0.1])


def wagon():
    """Equations (12)-(15) of Schwarz and Keck (2020) as printed, with the signs of the paper."""

    def f(t, x, u, p):
        m, J, r_wheel, r_friction, h, a, k_d = (p[i] for i in range(7))
        drag = u[2] + k_d * x[2] ** 2
        front, rear = m * 9.81 / 2 + h * drag / a, m * 9.81 / 2 - h * drag / a
        return [
            (r_friction * x[3] * u[0] + r_wheel * x[5] * front) / J,
            (r_friction * x[4] * u[1] + r_wheel * x[5] * rear) / J,
            (m * 9.81 / 2 * x[5] + drag) / m,
            0 * x[3],
            0 * x[4],
            0 * x[5],
        ]

    return small_model(
        "w_f w_r v mu_f mu_r mu_w",
        "F_f F_r F_TR",
        " ".join(WAGON),
        "w_f w_r v",
        f,
        lambda t, x, u, p: [x[0], x[1], x[2]],
    )


def wagon_inverse(z, u):
    """Equations (17) and (18): the states from readings and their first derivatives."""
    m, J, r_wheel, r_friction, h, a, k_d = WAGON.values()
    drag = u[2] + k_d * z[2] ** 2
    f_sub = m * z[5] - drag
    shift = 2 * h * drag / (a * m * 9.81)
    return np.array(
        [
            z[0],
            z[1],
            z[2],
            (J * z[3] - r_wheel * f_sub * (1 + shift)) / (r_friction * u[0]),
            (J * z[4] - r_wheel * f_sub * (1 - shift)) / (r_friction * u[1]),
            2 / (m * 9.81) * f_sub,
        ]
    )


@pytest.fixture(scope="module")
def rolling():
    return CasadiPrediction(wheelset(), WHEELSET)


@pytest.fixture(scope="module")
def car():
    return CasadiPrediction(wagon(), WAGON)


X = np.array([48.0, 47.0, 21.0, -0.33, -0.36, -0.07])


def test_readings_and_rates_are_what_the_closed_form_inverts(car):
    u = np.array([2e4, 1.5e4, -800.0])
    z, _ = readings_and_rates(car, 1, X, u)
    # Terms of 1e4 N cancel to what mu is worth: three digits of sixteen.
    assert wagon_inverse(z, u) == pytest.approx(X, rel=1e-12)


def test_braked_wagon_is_observable_with_first_derivatives(car):
    found = observability(car, X, np.array([2e4, 1.5e4, -800.0]), WAGON_SCALE)
    assert (found.complete, found.rank, found.order, found.undetermined) == (True, 6, 1, ())


@pytest.mark.parametrize(
    ("forces", "lost"),
    [
        ((0.0, 1.5e4), ("mu_f",)),
        ((2e4, 0.0), ("mu_r",)),
        ((0.0, 0.0), ("mu_f", "mu_r")),
    ],
)
def test_released_pads_hide_their_friction_and_nothing_else(car, forces, lost):
    found = observability(car, X, np.array([*forces, -800.0]), WAGON_SCALE)
    assert found.rank == 6 - len(lost)
    assert found.undetermined == lost


def test_a_hidden_direction_names_all_that_take_part_in_it():
    """Only the sum of two forces is seen: neither is determined, the third state is."""
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


def test_linear_rank_is_that_of_the_kalman_matrix():
    prediction = CasadiPrediction(oscillator(), OSCILLATOR)
    origin, nothing = np.zeros(4), np.zeros(1)
    A, C = prediction.derivative_jacobian(origin, nothing), prediction.output_jacobian(origin, nothing)
    kalman = np.concatenate([C @ np.linalg.matrix_power(A, k) for k in range(4)])
    assert readings_and_rates(prediction, 3, origin, nothing)[1] == pytest.approx(kalman, rel=1e-9)
    found = observability(prediction, origin, nothing, np.array([1e-3, 1e-3, 0.1, 0.1]))
    assert found.complete


def test_gramian_of_a_linear_model_is_the_sum_over_its_exponential():
    prediction = CasadiPrediction(oscillator(), OSCILLATOR)
    origin, nothing = np.zeros(4), np.zeros(1)
    A, C = prediction.derivative_jacobian(origin, nothing), prediction.output_jacobian(origin, nothing)
    R = np.diag([1e-8, 1e-2])
    expected = np.zeros((4, 4))
    for k in range(100):
        seen = C @ expm(A * k * 1e-3)
        expected += seen.T @ np.linalg.inv(R) @ seen
    ours = gramian(prediction, np.zeros((100, 4)), np.zeros((100, 1)), 1e-3, np.diag(R))
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


def test_pad_friction_is_lost_where_the_pads_are_released_and_back_where_they_press(rolling):
    samples = 400
    x = np.tile([22.0, 57.0, 0.36, 0.06], (samples, 1))
    u = np.zeros((samples, 2))
    u[200:, 0] = 2e4
    scale = np.array([20.0, 50.0, 0.35, 0.1])
    start, smallest, deviation = along(rolling, x, u, 1e-3, np.array([1e-4, 1e-4, 1e-3]), scale, 100, 100)
    assert start.tolist() == [0, 100, 200, 300]
    # Released, pad friction still moves the wheelset through nothing: the readings cannot tell it.
    assert np.all(deviation[:2, 2] == np.inf)
    assert np.all(deviation[2:, 2] < 0.1)
    assert np.all(np.isfinite(deviation[:, [0, 1, 3]]))
    assert np.all(smallest[:2] < 1e-9 * smallest[2:])


def test_questions_without_an_answer_get_a_sentence(rolling):
    x, u = np.array([22.0, 57.0, 0.36, 0.06]), np.array([2e4, 0.0])
    with pytest.raises(EstimatorError, match="scale wants a positive size for each of v, w, mu_b, alpha"):
        observability(rolling, x, u, np.array([1.0, 1.0, 0.0, 1.0]))
    with pytest.raises(EstimatorError, match="wants 4 states and 2 inputs"):
        observability(rolling, x[:3], u, np.ones(4))
    with pytest.raises(EstimatorError, match="window wants 1 to 5 samples"):
        along(rolling, np.tile(x, (5, 1)), np.tile(u, (5, 1)), 1e-3, np.ones(3), np.ones(4), 6, 1)
