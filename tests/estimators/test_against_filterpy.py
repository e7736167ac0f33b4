"""Filters, sigma points, smoother and reference estimators against filterpy and closed forms."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from filterpy.kalman import (
    IMMEstimator,
    KalmanFilter,
    MerweScaledSigmaPoints,
)
from filterpy.kalman import (
    UnscentedKalmanFilter as ReferenceUnscented,
)
from filterpy.monte_carlo import systematic_resample as reference_resample
from sampling import FUZZ
from scipy.linalg import expm, solve_discrete_are
from scipy.optimize import least_squares, minimize
from small_models import DENSITY, FIRST_MEAN, FIRST_VARIANCE, PERIOD, READING, small_model

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import advance, transition
from railgrip.estimators.design import FilterContext, Gate
from railgrip.estimators.ekf import ExtendedKalmanFilter, NumpyFilter
from railgrip.estimators.filters.cubature import CubatureKalmanFilter
from railgrip.estimators.filters.disturbance_observer import DisturbanceEstimator
from railgrip.estimators.filters.force_balance import ForceBalanceEstimator
from railgrip.estimators.filters.interacting import InteractingFilters
from railgrip.estimators.filters.iterated import IteratedKalmanFilter
from railgrip.estimators.filters.moving_horizon import HorizonFilter, MovingHorizonEstimator
from railgrip.estimators.filters.particle import PARTICLES, ParticleFilter, systematic_resample
from railgrip.estimators.filters.sage_husa import SageHusaFilter
from railgrip.estimators.filters.unscented import ALPHA, BETA, UnscentedKalmanFilter
from railgrip.estimators.observability import linearised_bound, posterior_bound
from railgrip.estimators.prediction import CasadiPrediction
from railgrip.estimators.rail import estimate_slope
from railgrip.estimators.smoother import iterate_smoother, smooth

LINEAR = {"density": np.array([0.0, 0.0, 1e-2, 1e-2]), "noise": np.array([1e-8, 1e-3])}
START = np.array([1e-3, 0.0, 0.1, 0.0]), np.array([1e-6, 1e-6, 1e-2, 1e-2])
ROUNDING = 1e-10
"""Mean in standard deviations, covariance relative to their product.

300 steps of rounding, 1e-16 each, of deflections and speeds a thousand standard deviations large.
"""


class Frozen(SageHusaFilter):
    """Sage-Husa with an infinite memory."""

    memory = float("inf")


def reference_filter(prediction, density=LINEAR["density"]):
    """Return filterpy's linear filter of the oscillator under the same discretisation, and D of y = Hx + Du."""
    origin, one = np.zeros(4), np.ones(1)
    filter_ = KalmanFilter(dim_x=4, dim_z=2, dim_u=1)
    filter_.F = transition(prediction.derivative_jacobian(origin, one), PERIOD)
    filter_.B = advance(lambda x: prediction.derivative(x, one), origin, PERIOD)[:, np.newaxis]
    filter_.H = prediction.output_jacobian(origin, one)
    filter_.Q, filter_.R = np.diag(density) * PERIOD, np.diag(LINEAR["noise"])
    filter_.x, filter_.P = START[0].copy(), np.diag(START[1])
    return filter_, prediction.output(origin, one)


def drives(steps, seed=1):
    random = np.random.default_rng(seed)
    return random.normal(0.0, 1e4, (steps, 1)), random.normal(0.0, [1e-3, 1.0], (steps, 2))


def both(stepped, reference, feedthrough, steps):
    """Step a filter and its reference with the same inputs and readings, and yield after each step."""
    for held, seen in zip(*drives(steps), strict=True):
        stepped.inputs[:], stepped.readings[:] = held, seen
        stepped.advance()
        reference.predict(u=held)
        reference.update(seen - feedthrough * held[0])
        yield


def assert_equal(mean, covariance, reference):
    sd = np.sqrt(np.diag(reference.P))
    assert np.max(np.abs(mean - reference.x) / sd) < ROUNDING
    assert np.max(np.abs(covariance - reference.P) / np.outer(sd, sd)) < ROUNDING


def stepped_by(kind, prediction, estimator=NumpyFilter, **options):
    """Return an estimator of the oscillator that is stepped in place by a kind of filter."""
    filter_ = kind(prediction, LINEAR["density"], LINEAR["noise"], PERIOD)
    return estimator(filter_, filter_.start(*START), **options)


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        *((kind, {}) for kind in (ExtendedKalmanFilter, IteratedKalmanFilter, UnscentedKalmanFilter)),
        *((kind, {}) for kind in (CubatureKalmanFilter, Frozen)),
        (ExtendedKalmanFilter, {"estimator": MovingHorizonEstimator, "window": 12, "every": 5}),
    ],
)
def test_on_a_linear_model_every_filter_is_the_kalman_filter(linear, kind, options):
    """The last states of a horizon too: their density given start and readings is that of the filter."""
    stepped = stepped_by(kind, linear, **options)
    reference, feedthrough = reference_filter(linear)
    for _ in both(stepped, reference, feedthrough, 300):
        assert_equal(stepped.mean, stepped.covariance, reference)


def test_the_discretisation_is_exact_up_to_its_taylor_remainder(linear):
    """The matrix exponential of van Loan is exact with inputs held."""
    origin, one = np.zeros(4), np.ones(1)
    A = linear.derivative_jacobian(origin, one)
    exact = expm(PERIOD * np.block([[A, linear.derivative(origin, one)[:, np.newaxis]], [np.zeros((1, 5))]]))
    # In units in which position and velocity of a mode have equal size, the Taylor remainder of a step is |exp(TA) -
    # Phi| <= |TA|^5/120 exp(|TA|).
    frequency = np.max(np.abs(np.linalg.eigvals(A)))
    scale = np.array([1.0, 1.0, frequency, frequency])
    size = np.linalg.norm(PERIOD * A * scale / scale[:, np.newaxis], 2)
    bound = size**5 / 120.0 * np.exp(size)
    assert bound < 1e-6  # so that the comparison is meaningful, also after the memory of a filter of 1000 steps
    assert np.linalg.norm((transition(A, PERIOD) - exact[:4, :4]) * scale / scale[:, np.newaxis], 2) < bound
    response = advance(lambda x: linear.derivative(x, one), origin, PERIOD)
    # The response is an integral of the exponential, whose series ends a power earlier.
    assert np.linalg.norm((response - exact[:4, 4]) / scale) < bound / size * np.linalg.norm(exact[:4, 4] / scale)


PENDULUM = {"g": 9.81}


def pendulum_model():
    """Särkkä (2013), example 3.7: the reading is the sine of the angle of a noisy pendulum."""
    model = small_model(
        "angle rate", "torque", "g", "sine",
        lambda t, x, u, p: [x[1], -p[0] * ca.sin(x[0]) + u[0]],
        lambda t, x, u, p: [ca.sin(x[0])],
    )  # fmt: skip
    return CasadiPrediction(model, PENDULUM)


@pytest.fixture(scope="module")
def pendulum():
    return pendulum_model()


def swing(x, step):
    """Return the pendulum after a step of the classical Runge-Kutta method, written out."""

    def slope(x):
        return np.array([x[1], -9.81 * np.sin(x[0])])

    k1 = slope(x)
    k2 = slope(x + 0.5 * step * k1)
    k3 = slope(x + 0.5 * step * k2)
    k4 = slope(x + step * k3)
    return x + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


def pendulum_readings(steps=200, step=0.0125):
    random, x, seen = np.random.default_rng(7), np.array([1.5, 0.0]), np.empty((steps, 1))
    for k in range(steps):
        x = swing(x, step) + random.normal(0.0, [0.0, np.sqrt(0.01 * step)])
        seen[k] = np.sin(x[0]) + random.normal(0.0, np.sqrt(0.1))
    return seen


@pytest.mark.parametrize(
    ("kind", "points"),
    [
        (UnscentedKalmanFilter, MerweScaledSigmaPoints(2, ALPHA, BETA, 0.0)),
        # Without a central point the unscented transform is the cubature rule.
        (CubatureKalmanFilter, MerweScaledSigmaPoints(2, 1.0, 0.0, 0.0)),
    ],
)
def test_sigma_point_filters_of_the_pendulum_are_those_of_filterpy(pendulum, kind, points):
    step, density = 0.0125, np.array([1e-4, 0.01])
    filter_ = kind(pendulum, density, np.array([0.1]), step)
    belief = filter_.start(np.array([1.5, 0.0]), np.array([0.1, 0.1]))
    reference = ReferenceUnscented(2, 1, step, lambda x: np.sin(x[:1]), swing, points)
    reference.x, reference.P = belief.mean.copy(), belief.covariance.copy()
    reference.Q, reference.R = np.diag(density) * step, np.array([[0.1]])
    for seen in pendulum_readings():
        belief = filter_.step(belief, np.zeros(1), seen)
        reference.predict()
        reference.update(seen)
        # Weights of ±100 lose two digits in each of 200 steps.
        assert belief.mean == pytest.approx(reference.x, abs=1e-9)
        assert belief.covariance == pytest.approx(reference.P, abs=1e-9)


def test_the_iterated_update_maximises_the_posterior_density(pendulum):
    filter_ = IteratedKalmanFilter(pendulum, np.array([1e-4, 0.01]), np.array([0.01]), 0.0125)
    forecast = filter_.start(np.array([0.9, 0.2]), np.array([[0.2, 0.05], [0.05, 0.1]]))
    seen, nothing = np.array([0.35]), np.zeros(1)
    updated = filter_.condition(forecast, nothing, filter_.innovation(forecast, nothing, seen))
    information = np.linalg.inv(forecast.covariance)

    def cost(x):
        off = x - forecast.mean
        return 0.5 * off @ information @ off + 0.5 * (seen[0] - np.sin(x[0])) ** 2 / 0.01

    best = minimize(cost, forecast.mean, method="BFGS", options={"gtol": 1e-9})
    # BFGS with differences finds a minimum of width 0.1 to about the root of 1e-16.
    assert updated.mean == pytest.approx(best.x, abs=1e-6)
    single = ExtendedKalmanFilter(pendulum, np.array([1e-4, 0.01]), np.array([0.01]), 0.0125)
    once = single.condition(forecast, nothing, single.innovation(forecast, nothing, seen))
    assert cost(updated.mean) < cost(once.mean)


@pytest.fixture(scope="module")
def window():
    """Inputs and readings of 25 steps of the pendulum, and the filter with its start."""
    filter_ = ExtendedKalmanFilter(pendulum_model(), np.array([1e-3, 0.05]), np.array([0.01]), 0.05)
    return filter_, filter_.start(np.array([1.2, 0.4]), np.array([0.1, 0.3])), pendulum_readings(25, 0.05)


def residuals(window, states):
    """Return the terms of the cost of a window of the pendulum, from all its states."""
    filter_, first, seen = window
    states = states.reshape(-1, 2)
    moved = np.array([swing(x, 0.05) for x in states[:-1]])
    return np.concatenate(
        [
            (states[0] - first.mean) / first.deviation,
            ((states[1:] - moved) / np.sqrt(np.diag(filter_.design.process_noise))).ravel(),
            (seen[:, 0] - np.sin(states[1:, 0])) / 0.1,
        ]
    )


def test_the_states_of_a_horizon_are_the_least_squares_solution_of_its_window(window):
    filter_, first, seen = window
    start = smooth(filter_, first, np.zeros((25, 1)), seen).mean
    best = least_squares(
        lambda x: residuals(window, x), start.ravel(), jac="3-point", xtol=1e-14, ftol=1e-14, gtol=1e-14
    )
    found = iterate_smoother(HorizonFilter(filter_), first, np.zeros((25, 1)), seen, 50)
    horizon = MovingHorizonEstimator(filter_, first, window=25, every=25, iterations=50)
    for reading in seen:
        horizon.readings[:] = reading
        horizon.advance()
    assert np.abs(start.ravel() - best.x).max() > 1e-2  # the extended smoother is another one
    # Differences of third order determine a solution of size 1 to some 1e-8.
    assert found.mean.ravel() == pytest.approx(best.x, abs=1e-7)
    assert horizon.mean == pytest.approx(best.x[-2:], abs=1e-7)
    covariance = np.linalg.inv(best.jac.T @ best.jac)[-2:, -2:]
    assert horizon.covariance == pytest.approx(covariance, rel=1e-5)


def test_a_horizon_uses_no_reading_that_its_filter_rejects(pendulum):
    filter_ = ExtendedKalmanFilter(pendulum, np.array([1e-3, 0.05]), np.array([0.01]), 0.05, outlier_limit=5.0)
    first, means = filter_.start(np.array([0.5, 0.0]), np.array([0.01, 0.01])), []
    for reading in (np.nan, 5.0):
        horizon = MovingHorizonEstimator(filter_, first, window=8, every=4)
        for value in (0.5, 0.5, reading, 0.5):
            horizon.readings[:] = value
            horizon.advance()
        means.append(horizon.mean)
    np.testing.assert_array_equal(*means)


def test_interacting_filters_are_those_of_filterpy(linear):
    densities = LINEAR["density"], 25.0 * LINEAR["density"]
    filters = [ExtendedKalmanFilter(linear, density, LINEAR["noise"], PERIOD) for density in densities]
    change = np.array([[0.97, 0.03], [0.1, 0.9]])
    ours = InteractingFilters(filters, change, [0.3, 0.7], filters[0].start(*START))
    references, feedthrough = zip(*(reference_filter(linear, density) for density in densities), strict=True)
    reference = IMMEstimator(list(references), np.array([0.3, 0.7]), change)
    for _ in both(ours, reference, feedthrough[0], 100):
        # filterpy multiplies densities; railgrip adds logarithms.
        assert ours.probabilities == pytest.approx(reference.mu, abs=1e-9)
        assert_equal(ours.mean, ours.covariance, reference)


def test_a_reading_rejected_by_one_filter_is_used_by_no_other(linear):
    densities = LINEAR["density"], 1e8 * LINEAR["density"]
    filters = [ExtendedKalmanFilter(linear, each, LINEAR["noise"], PERIOD, outlier_limit=6.0) for each in densities]
    ours = InteractingFilters(filters, np.eye(2), [0.5, 0.5], filters[0].start(*START))
    ours.readings[:] = [0.0, 30.0]
    ours.advance()
    assert list(ours.selection) == [1.0, 0.0]


@pytest.mark.parametrize(("change", "weights"), [(np.eye(3), [0.5, 0.5]), (np.eye(2), [0.5, 0.6])])
def test_inconsistent_probabilities_are_refused(linear, change, weights):
    filters = [ExtendedKalmanFilter(linear, LINEAR["density"], LINEAR["noise"], PERIOD) for _ in range(2)]
    with pytest.raises(EstimatorError, match="InteractingFilters"):
        InteractingFilters(filters, change, weights, filters[0].start(*START))


def test_the_adaptive_filter_finds_the_noise_of_its_readings(linear):
    # Uncertain states hide the noise of the readings; with a hundredth of the process noise they are certain.
    density, noise = 1e-2 * LINEAR["density"], LINEAR["noise"]
    random, truth = np.random.default_rng(5), START[0]
    filter_ = SageHusaFilter(linear, density, 9.0 * noise, PERIOD)
    belief, found, nothing = filter_.start(*START), [], np.zeros(1)
    for _ in range(6000):
        truth = advance(lambda x: linear.derivative(x, nothing), truth, PERIOD)
        truth = truth + np.sqrt(density * PERIOD) * random.standard_normal(4)
        seen = linear.output(truth, nothing) + np.sqrt(noise) * random.standard_normal(2)
        belief = filter_.step(belief, nothing, seen)
        found.append(np.diag(filter_.design.reading_noise))
    # The variance of 4000 readings has a deviation of 2 %; residuals determine it less well than the noise itself.
    assert np.mean(found[2000:], axis=0) == pytest.approx(noise, rel=0.1)


def test_the_smoother_is_that_of_filterpy(linear):
    inputs, readings = drives(200)
    filter_ = ExtendedKalmanFilter(linear, LINEAR["density"], LINEAR["noise"], PERIOD)
    first = filter_.start(*START)
    smoothed = smooth(filter_, first, inputs, readings)
    reference, feedthrough = reference_filter(linear)
    means, covariances = [first.mean], [first.covariance]
    for held, seen in zip(inputs, readings, strict=True):
        reference.predict(u=held)
        reference.update(seen - feedthrough * held[0])
        means.append(reference.x.copy())
        covariances.append(reference.P.copy())
    # filterpy's smoother has no inputs, so the response to the inputs alone is subtracted before and added after it.
    response = [np.zeros(4)]
    for held in inputs:
        response.append(reference.F @ response[-1] + reference.B @ held)
    free = np.array(means) - response
    mean, covariance, _, _ = reference.rts_smoother(free, np.array(covariances))
    sd = np.sqrt(np.einsum("kii->ki", covariance))
    assert np.max(np.abs(smoothed.mean - mean - response) / sd) < 1e3 * ROUNDING  # inverses of condition 1e6
    assert np.max(np.abs(smoothed.covariance - covariance) / (sd[:, :, None] * sd[:, None, :])) < 1e3 * ROUNDING


def test_a_fixed_lag_is_the_smoother_of_the_readings_until_then(linear):
    inputs, readings = drives(60)
    filter_ = ExtendedKalmanFilter(linear, LINEAR["density"], LINEAR["noise"], PERIOD)
    first = filter_.start(*START)
    lagged = smooth(filter_, first, inputs, readings, lag=10)
    for k in (0, 20, 50, 55):
        end = min(k + 10, 60)
        whole = smooth(filter_, first, inputs[:end], readings[:end])
        assert lagged.mean[k] == pytest.approx(whole.mean[k], rel=1e-12, abs=1e-15)
        assert lagged.covariance[k] == pytest.approx(whole.covariance[k], rel=1e-12, abs=1e-20)
    with pytest.raises(EstimatorError, match="lag"):
        smooth(filter_, first, inputs, readings, lag=-1)


def test_sigma_points_do_not_move_a_gated_state(rolling):
    gate = Gate(states=("mu_b",), inputs=("pad_force",), threshold=1500.0)
    for kind in (UnscentedKalmanFilter, CubatureKalmanFilter):
        filter_ = kind(rolling, DENSITY, READING, PERIOD, gate)
        belief = filter_.start(FIRST_MEAN, FIRST_VARIANCE)
        for _ in range(50):
            belief = filter_.step(belief, np.zeros(2), np.array([21.9, 57.0, -0.6]))
        assert belief.mean[2] == pytest.approx(FIRST_MEAN[2], rel=1e-12)
        assert belief.covariance[2, 2] == pytest.approx(FIRST_VARIANCE[2], rel=1e-9)


@pytest.fixture(scope="module")
def wheel():
    """A wheelset of a train whose names are those of the train predictions."""
    model = small_model(
        "speed wheelset_speed[1] pad_friction[1] group_adhesion[1]", "cylinder_pressure[1]", "m J r",
        "speed wheelset_speed[1]",
        lambda t, x, u, p: [-9.81 * x[3], (x[3] * p[0] * 9.81 * p[2] - x[2] * u[0]) / p[1], ca.SX(0), ca.SX(0)],
        lambda t, x, u, p: [x[0], x[1]],
    )  # fmt: skip
    return CasadiPrediction(model, {"m": 14_500.0, "J": 209.0, "r": 0.38})


def wheel_context(prediction):
    return FilterContext(
        prediction=prediction,
        process_noise=np.array([1e-4, 1e-4, 1e-8, 1e-2]),
        reading_noise=np.array([1e-2, 1e-4]),
        period=0.01,
        gate=Gate(states=(), inputs=(), threshold=0.0),
        outlier_limit=None,
        mean=np.array([30.0, 30.0 / 0.38, 0.35, 0.02]),
        covariance=np.diag([1e-2, 1e-1, 1e-12, 1e-3]),
    )


def test_particles_of_a_known_pad_friction_are_one_kalman_filter(wheel):
    """Pad friction is the sampled state of a train; with hardly any variance each particle has the same belief."""
    context = wheel_context(wheel)
    context = replace(context, process_noise=context.process_noise * [1, 1, 1e-8, 1])
    particles, single = (kind.of_context(context) for kind in (ParticleFilter, ExtendedKalmanFilter))
    assert len(particles.weights) == PARTICLES
    for speed in np.linspace(30.0, 29.5, 50):
        for each in (particles, single):
            each.inputs[:], each.readings[:] = [9000.0], [speed, speed / 0.38]
            each.advance()
    assert particles.mean == pytest.approx(single.mean, rel=1e-4)
    assert particles.weights == pytest.approx(1.0 / PARTICLES, rel=1e-2)


@pytest.fixture(params=[ForceBalanceEstimator, DisturbanceEstimator])
def reference(request, wheel):
    return request.param.of_context(wheel_context(wheel))


def test_a_reference_finds_a_constant_adhesion(wheel, reference):
    held = np.array([9000.0])
    truth = np.array([30.0, 30.0 / 0.38, 0.35, 0.06])
    for _ in range(400):
        truth = advance(lambda x: wheel.derivative(x, held), truth, 0.01)
        reference.inputs[:], reference.readings[:] = held, wheel.output(truth, held)
        reference.advance()
    # More than twenty time constants of the low-pass.
    assert reference.mean[3] == pytest.approx(0.06, abs=1e-6)
    assert list(reference.selection) == [1.0, 1.0]


def test_a_wheelset_speed_that_falls_to_0_does_not_change_the_adhesion(reference):
    for speed in (30.0 / 0.38, 30.0 / 0.38, 0.0):
        before = reference.mean[3]
        reference.readings[:] = [30.0, speed]
        reference.advance()
    assert reference.mean[3] == before
    assert reference.mean[1] == 0.0


def test_the_deviation_of_a_reference_is_that_of_noise_and_delay(reference):
    """Adhesion is a random walk, observed with noise through the speed of a wheel without torque."""
    random, found = np.random.default_rng(2), []
    effect = 14_500.0 * 9.81 * 0.38 / 209.0
    speed, adhesion = 30.0 / 0.38, 0.0
    for _ in range(20_000):
        adhesion += np.sqrt(1e-2 * 0.01) * random.standard_normal()
        speed += 0.01 * effect * adhesion
        reference.readings[:] = [30.0, speed + 0.01 * random.standard_normal()]
        reference.advance()
        found.append(reference.mean[3] - adhesion)
    # Some thousand independent values: 2 %, and twice that.
    assert np.std(found[1000:]) == pytest.approx(np.sqrt(reference.covariance[3, 3]), rel=0.05)


def test_the_corner_is_that_of_the_stationary_kalman_filter(wheel):
    """The observer has both poles at the frequency of the filter's pair, whose damping is 1/√2."""
    context = wheel_context(wheel)
    corner = DisturbanceEstimator.of_context(context).corner[0]
    effect, fine = 14_500.0 * 9.81 * 0.38 / 209.0, 1e-4
    F, H = np.array([[1.0, effect * fine], [0.0, 1.0]]), np.array([[1.0, 0.0]])
    noise = 1e-4 * 0.01 / fine  # the same density of the reading
    P = solve_discrete_are(F.T, H.T, np.diag([0.0, 1e-2 * fine]), [[noise]])
    closed = (np.eye(2) - P @ H.T @ H / (P[0, 0] + noise)) @ F
    poles = np.log(np.linalg.eigvals(closed)) / fine
    assert np.abs(poles) == pytest.approx([corner, corner], rel=0.01)  # the finer period is not quite continuous


def test_the_slope_is_that_of_weighted_least_squares():
    random, count = np.random.default_rng(3), 400
    slip = 0.02 + 0.01 * random.standard_normal(count)
    adhesion = 0.1 - 0.5 * slip + 1e-3 * random.standard_normal(count)
    found = estimate_slope(adhesion, slip, 0.01, memory=0.5)
    weights = np.exp(-0.01 / 0.5) ** np.arange(count)[::-1]
    expected = np.polyfit(slip, adhesion, 1, w=np.sqrt(weights))[0]
    assert found.slope[-1] == pytest.approx(expected, rel=1e-9)
    assert found.available[-1] <= adhesion.max()
    rising = estimate_slope(0.1 + 0.5 * slip, slip, 0.01)
    assert np.isnan(rising.available[-1])


def test_the_posterior_bound_of_a_linear_model_is_the_riccati_solution(linear):
    density = np.array([1e-8, 1e-8, 1e-2, 1e-2])
    reference, _ = reference_filter(linear, density)
    inputs, readings = drives(200)
    is_read = np.ones(readings.shape, dtype=bool)
    bound = posterior_bound(
        linear, density, LINEAR["noise"], PERIOD, np.diag(START[1]), np.zeros((1, 201, 4)), inputs, is_read
    )
    for k in range(200):
        reference.predict()
        reference.update(readings[k])
        sd = np.sqrt(np.diag(reference.P))
        # Information and covariance form differ by the condition of the information, 1e6.
        assert np.max(np.abs(bound[k + 1] - reference.P) / np.outer(sd, sd)) < 1e-8


def test_the_bound_along_one_trajectory_has_a_covariance_and_an_information_form(pendulum):
    density, noise, step = np.array([1e-3, 0.05]), np.array([0.01]), 0.05
    truth = np.empty((61, 2))
    truth[0] = 0.6, 0.0
    for k in range(60):
        truth[k + 1] = swing(truth[k], step)
    rest = np.diag([0.05, 0.05]), truth, np.zeros((60, 1))
    information = posterior_bound(
        pendulum, density, noise, step, rest[0], truth[np.newaxis], rest[2], np.ones((60, 1), dtype=bool)
    )
    # Both forms in double precision; their condition is below 1e4.
    np.testing.assert_allclose(linearised_bound(pendulum, density, noise, step, *rest), information[1:], rtol=1e-9)
    every = linearised_bound(pendulum, density, noise, step, *rest, every=20)
    np.testing.assert_allclose(every, information[20::20], rtol=1e-9)
    # A state without process noise is the limit of one with little.
    little = posterior_bound(
        pendulum, np.array([1e-9, 0.05]), noise, step, rest[0], truth[np.newaxis], rest[2], np.ones((60, 1), dtype=bool)
    )
    none = linearised_bound(pendulum, np.array([0.0, 0.05]), noise, step, *rest)
    np.testing.assert_allclose(none, little[1:], rtol=1e-4)


def test_no_filter_of_the_pendulum_is_better_than_the_posterior_bound(pendulum):
    draws, steps, step = 300 if FUZZ else 100, 60, 0.05
    density, noise, start = np.array([1e-3, 0.05]), np.array([0.01]), np.array([0.05, 0.05])
    random = np.random.default_rng(11)
    nothing = np.zeros((steps, 1))
    filter_ = ExtendedKalmanFilter(pendulum, density, noise, step)
    truth, estimates = np.empty((draws, steps + 1, 2)), np.empty((draws, steps + 1, 2))
    for draw in range(draws):
        belief = filter_.start(np.array([0.6, 0.0]), start)
        truth[draw, 0] = belief.mean + np.sqrt(start) * random.standard_normal(2)
        estimates[draw, 0] = belief.mean
        for k in range(steps):
            x = swing(truth[draw, k], step) + np.sqrt(density * step) * random.standard_normal(2)
            belief = filter_.step(belief, nothing[k], np.sin(x[:1]) + 0.1 * random.standard_normal(1))
            truth[draw, k + 1], estimates[draw, k + 1] = x, belief.mean
    is_read = np.ones((steps, 1), dtype=bool)
    bound = posterior_bound(pendulum, density, noise, step, np.diag(start), truth, nothing, is_read)
    squares = np.mean((estimates - truth)[:, 1:] ** 2, axis=(0, 1))
    expected = np.mean(np.einsum("kii->ki", bound[1:]), axis=0)
    # Draws of some ten independent instants each determine a mean square to √(2/(10 draws)), 3 % with 300; four times.
    assert np.all(squares > (1 - 4 * np.sqrt(0.2 / draws)) * expected)
    assert np.all(squares < 1.5 * expected)  # within 0.6 rad the sine is nearly straight, and the bound nearly reached


@pytest.mark.parametrize("seed", range(5))
def test_systematic_resampling_keeps_the_particles_of_filterpy(seed):
    weights = np.random.default_rng(seed).dirichlet(np.full(40, 0.3))
    np.random.seed(seed)
    uniform = np.random.random()
    np.random.seed(seed)
    np.testing.assert_array_equal(systematic_resample(weights, uniform), reference_resample(weights))


def walk():
    """A position whose rate is a random walk; the position is read."""
    model = small_model(
        "x rate", "u", "p", "y", f=lambda t, x, u, p: [x[1] + u[0], ca.SX(0)], h=lambda t, x, u, p: [x[0] + 0.0 * p[0]]
    )
    return CasadiPrediction(model, {"p": 0.0})


def test_particles_of_a_known_state_equal_the_kalman_filter():
    prediction = walk()
    filter_ = ExtendedKalmanFilter(prediction, [1e-3, 0.0], [1e-2], 0.1)
    first = filter_.start([0.0, 1.0], [0.5, 1e-30])
    stepped = ParticleFilter(filter_, [1], first, 7, seed=1)
    for reading in np.random.default_rng(2).normal(size=50):
        stepped.inputs[:], stepped.readings[:] = 0.3, reading
        stepped.advance()
        first = filter_.step(first, np.array([0.3]), np.array([reading]))
        np.testing.assert_allclose(stepped.mean, first.mean, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(stepped.covariance, first.covariance, rtol=1e-12, atol=1e-14)


def test_many_particles_approximate_the_kalman_filter():
    prediction = walk()
    filter_ = ExtendedKalmanFilter(prediction, [1e-3, 1e-2], [1e-2], 0.1)
    belief = filter_.start([0.0, 0.0], [0.1, 0.2])
    stepped = ParticleFilter(filter_, [1], belief, 400, seed=1)
    errors = []
    for k in range(40):
        reading = np.array([0.05 * k])
        stepped.inputs[:], stepped.readings[:] = 0.0, reading
        stepped.advance()
        belief = filter_.step(belief, np.zeros(1), reading)
        errors.append((stepped.mean - belief.mean) / belief.deviation)
    # The error of a mean of 400 draws is 1/20 of a deviation; weights and resampling double it.
    assert np.sqrt(np.mean(np.square(errors))) < 0.15


def test_a_particle_filter_needs_particles_and_sampled_states():
    filter_ = ExtendedKalmanFilter(walk(), [1e-3, 1e-2], [1e-2], 0.1)
    with pytest.raises(EstimatorError, match="sampled states and particles"):
        ParticleFilter(filter_, [], filter_.start([0.0, 0.0], [0.1, 0.2]), 4, seed=1)
