"""Equations of a filter compared with a second program, runs with single steps, and accuracy."""

import mal
import numpy as np
import pytest

from railgrip.base.errors import EstimatorError, FmuError
from railgrip.estimation.lateral import run
from railgrip.estimation.lateral.information import errors_of_filter
from railgrip.estimation.lateral.run import (
    INTEGRALS,
    NAMES,
    STIFFNESS_NAMES,
    LateralCase,
    observer,
    prediction,
    simulate,
)
from railgrip.estimation.lateral.run_measures import beliefs_about, measure
from railgrip.estimation.lateral.wheelset import (
    DRY,
    INPUTS,
    PAPER_SENSORS,
    PERIOD,
    PLANTS,
    TESTS,
    WORST,
    SurfaceTest,
    course,
    wheelset,
)
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.ekf import ExtendedKalmanFilter

READING_NOISE = np.square(PAPER_SENSORS)


def test_the_reconstruction_equals_a_second_program_of_its_equations():
    """Derivative and readings at random states; tests/fmus compares its Jacobians with differences."""
    model, rng = prediction("reconstruction"), np.random.default_rng(1)
    speed, rail = 25.0, mal.Rail(DRY.mu0, DRY.A, DRY.B)
    for _ in range(20):
        x = np.array([0.02, -0.01, 4e-4, 0.45, 5e3]) * rng.uniform(0.5, 1.5, 5)
        y, psi, track, rate = rng.normal(scale=[1e-3, 2e-4, 2e-3, 2e-2])
        values = {"lateral_position": y, "yaw_angle": psi, "track": track, "track_rate": rate, "speed": speed,
                  "mu0": rail.u0, "A_falling": rail.A, "B_falling": rail.B}  # fmt: skip
        inputs = np.array([values[name] for name in model.inputs])
        slopes, ddy = mal.slopes(x, y, psi, track, rate, speed, rail)
        # Additions in another order, of terms up to a thousand times the result.
        assert model.derivative(x, inputs) == pytest.approx(slopes, rel=1e-11)
        assert model.output(x, inputs) == pytest.approx([ddy, x[1]], rel=1e-11)


@pytest.mark.parametrize(
    ("condition", "added"), [(DRY, [5e-14, 1e-14, 1e-14, 1e-14, 1e-14]), (WORST, [1e-13, 9e-17, 1e-12, 1e-12, 1e-12])]
)
def test_a_step_of_the_reconstruction_adds_the_noise_of_the_paper(condition, added):
    """Equations (38) to (40), for a step of 50 µs; from a state with hardly any variance, and without readings."""
    filter_, first = observer("reconstruction", condition)
    inputs = np.array([{"speed": 25.0, "mu0": condition.mu0}.get(name, 0.0) for name in filter_.design.inputs])
    after = filter_.step(filter_.start(first.mean, np.full(5, 1e-40)), inputs, np.full(2, np.nan))
    assert np.diag(after.covariance) == pytest.approx(added, rel=1e-9)


def test_order_1_is_forward_euler_in_both_filters():
    arguments = (prediction("known_track"), np.full(5, 1e-6), READING_NOISE, PERIOD)
    plain = ExtendedKalmanFilter(*arguments, order=1)
    fast = CompiledFilter(*arguments, order=1)
    first, covariance = np.array([1e-3, 0.02, 1e-4, 0.01, -1.2]), np.full(5, 1e-6)
    inputs, nothing = np.array([25.0, 2e-3]), np.full(2, np.nan)
    assert prediction("known_track").inputs == ("speed", "track")
    by_hand = first + PERIOD * prediction("known_track").derivative(first, inputs)
    phi = np.eye(5) + PERIOD * prediction("known_track").derivative_jacobian(first, inputs)
    with pytest.raises(EstimatorError, match=r"1 \(forward Euler\) or 4"):
        ExtendedKalmanFilter(*arguments, order=2)  # pyright: ignore
    for one in (plain, fast):
        after = one.step(one.start(first, covariance), inputs, nothing)
        # Without readings the step is the prediction alone: the same sums in another order.
        assert after.mean == pytest.approx(by_hand, rel=1e-13)
        assert after.covariance == pytest.approx(
            phi @ np.diag(covariance) @ phi.T + 1e-6 * PERIOD * np.eye(5), rel=1e-12
        )


def test_the_friction_of_the_worst_rail_is_estimated():
    """From 0.25 to 0.10 within a second, with a known track; a filter with a perfect model is consistent."""
    worst = SurfaceTest(name="worst", changes=((0.0, WORST),), duration=1.0)
    trace = simulate(LateralCase(test=worst, speed=25.0, plant="paper", seed=3), ("known_track",))
    beliefs = beliefs_about(trace, "known_track")
    late = trace.time > 0.5
    assert np.abs(beliefs["friction"].mean - trace.truth["friction"])[late].max() < 0.02
    for quantity in ("creep", "creep_force", "lateral_velocity"):
        share = np.mean(np.abs(beliefs[quantity].mean - trace.truth[quantity]) < 3 * beliefs[quantity].deviation)
        # 99.7 % for a Gaussian; the start at rest is deterministic and may be an exception.
        assert share > 0.97, quantity


@pytest.mark.parametrize("plant", ["stiffness -10 %", "stiffness +1 %"])
def test_friction_is_estimated_with_a_wrong_creep_stiffness(plant):
    worst = SurfaceTest(name="worst", changes=((0.0, WORST),), duration=1.5)
    trace = simulate(LateralCase(test=worst, speed=25.0, plant=plant, seed=3), STIFFNESS_NAMES)
    errors = {name: errors_of_filter(trace, name) for name in STIFFNESS_NAMES}
    for name in ("known_track_stiffness", "unknown_track_stiffness"):
        assert errors[name]["rmse"] < 0.02, name
        assert errors[name]["stiffness"] < 0.005, name
    assert errors["known_track_stiffness"]["coverage"] > 0.9
    assert errors["known_track"]["coverage"] < 0.1
    force, true = beliefs_about(trace, "known_track_stiffness")["creep_force"], trace.truth["creep_force"]
    late = trace.time > 0.5
    assert np.sqrt(np.mean((force.mean - true)[late] ** 2)) < 0.01 * np.sqrt(np.mean(true[late] ** 2))


def test_an_interval_of_friction_says_that_the_linear_part_of_the_curve_does_not_determine_it():
    case = LateralCase(test=TESTS[0].shorten(1.5), speed=25.0, plant="service sensors, 0.1 of the irregularity", seed=1)
    errors = errors_of_filter(simulate(case, ["known_track_stiffness"]), "known_track_stiffness")
    assert errors["used"] < 0.05
    assert errors["known"] == 0.0
    assert errors["coverage_unknown"] > 0.9
    assert np.isnan(errors["coverage_known"])
    assert errors["deviation"] > 0.5  # that of the start is 0.6


def test_the_reconstruction_keeps_its_friction_when_the_rail_changes():
    """Its friction depends only on the creep, not on the known condition of the rail."""
    change = SurfaceTest(name="change", changes=((0.0, DRY), (0.4, WORST)), duration=0.8)
    trace = simulate(LateralCase(test=change, speed=25.0, plant="paper", seed=1), ("reconstruction",))
    friction = beliefs_about(trace, "reconstruction")["friction"].mean
    assert friction[-1] > 0.4
    assert trace.truth["friction"][-1] < 0.11


@pytest.mark.parametrize(("plant", "lost"), [("paper", False), ("twisting", True)])
def test_innovations_reveal_a_lost_filter(plant, lost):
    """With a twisting axle its maximum friction is finite but beyond 1e9."""
    dry = SurfaceTest(name="dry", changes=((0.0, DRY),), duration=1.0)
    trace = simulate(LateralCase(test=dry, speed=25.0, plant=plant, seed=1), ("known_track",))
    measures = measure(trace, observe=False)
    assert trace.beliefs["known_track"].failure_sample is None
    assert np.isfinite(trace.beliefs["known_track"].mean).all()
    assert (beliefs_about(trace, "known_track")["mu0"].mean[-1] > 1e9) == lost
    assert (measures["lost"]["known_track"] is not None) == lost
    assert (measures["nis"]["known_track"] > 1e3) == lost


STEPS = 300
SPEED = 25.0
CASE = LateralCase(test=TESTS[0].shorten(STEPS * PERIOD), speed=SPEED, plant="paper", seed=5)


def test_one_call_and_single_steps_are_bit_identical(monkeypatch):
    """Two inputs of the reconstruction are integrals of its states before each step."""
    monkeypatch.setattr(run, "EVERY", 1)
    trace, drawn = simulate(CASE), course(CASE.test, 5)
    with wheelset(SPEED, PLANTS[CASE.plant]) as plant:
        plant.start(drawn.inputs[0])
        outputs = np.array([plant.step(row) for row in drawn.inputs])
    table = dict(zip(INPUTS, drawn.inputs.T, strict=True)) | {"track_rate": drawn.track_rate}
    for name in NAMES:
        filter_, _ = observer(name, DRY)
        for k in range(STEPS):
            for j, column in enumerate(filter_.design.inputs):
                integrals = INTEGRALS.get(name, {})
                if column in integrals:
                    state = filter_.design.states.index(integrals[column])
                    filter_.inputs[j] += PERIOD * filter_.mean[state]
                else:
                    filter_.inputs[j] = SPEED if column == "speed" else table[column][k]
            filter_.readings[:] = outputs[k, :2] + drawn.noise[k]
            filter_.advance()
            assert np.array_equal(filter_.mean, trace.beliefs[name].mean[k]), (name, k)
            assert np.array_equal(filter_.covariance, trace.beliefs[name].covariance[k]), (name, k)


def test_a_filter_that_diverges_is_a_result(monkeypatch):
    monkeypatch.setattr(run, "EVERY", 1)
    drawn = course(CASE.test, 5)
    drawn.noise[100, 1] = np.inf
    monkeypatch.setattr(run, "course", lambda *arguments, **more: drawn)
    belief = simulate(CASE, ["known_track"]).beliefs["known_track"]
    assert belief.failure_sample == 101
    assert np.isfinite(belief.mean[99]).all()
    assert np.isnan(belief.mean[100:]).all()


def test_tables_and_names_that_do_not_match_are_refused():
    rows = np.zeros((3, len(INPUTS)))
    with wheelset(SPEED) as plant:
        plant.start(rows[0])
        with pytest.raises(FmuError, match=r"rows of 5 finite inputs, got shape \(3, 4\)"):
            plant.follow(rows[:, :-1])
        with pytest.raises(FmuError, match="a value that is none"):
            plant.follow(np.where(rows == 0.0, np.nan, rows))
    filter_, first = observer("known_track", DRY)
    inputs, readings = np.zeros((3, filter_.inputs.size)), np.zeros((3, 2))
    with pytest.raises(EstimatorError, match="no input or state trakc"):
        filter_.follow(first, inputs, readings, integrals={"trakc": "dy"})
    with pytest.raises(EstimatorError, match="every"):
        filter_.follow(first, inputs, readings, every=0)
