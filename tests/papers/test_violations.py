"""Equations 3, 9 and 12 to 15 of Schwarz, Posielek and Goetjes (2021): derivatives, and the stop with their law."""

import numpy as np
import pytest
from proof_terms import GROUP, course_of, inequalities, offset_of, slopes_of, violations
from table1_stops import ABC, FITS, scenario_of

from railgrip.simulate.run import run_stop
from railgrip.simulate.vehicle_data import VehicleData


def test_slopes_are_those_of_a_curve_whose_derivatives_are_known():
    """α = μ 2 s c/(s² + c²) e^(−v/b); steps of 1e-5 in slip are a thousandth of the narrowest peak."""
    c, b = 0.01, 30.0
    slip, speed, mu0 = np.linspace(0.003, 0.3, 40), np.linspace(5.0, 22.0, 40), np.full(40, 0.1)

    def contact(s, v, load, mu0):
        return mu0 * 2 * s * c / (s**2 + c**2) * np.exp(-v / b)

    slopes = slopes_of(contact, slip, speed, np.ones(40), mu0)
    alpha, square = contact(slip, speed, None, mu0), slip**2 + c**2
    by_slip = mu0 * 2 * c * (c**2 - slip**2) / square**2 * np.exp(-speed / b)
    curvature = mu0 * 4 * c * slip * (slip**2 - 3 * c**2) / square**3 * np.exp(-speed / b)
    # Relative to the largest of each: some values are close to a change of sign.
    for found, exact in ((slopes.by_slip, by_slip), (slopes.curvature, curvature),
                         (slopes.by_speed, -alpha / b), (slopes.cross, -by_slip / b)):  # fmt: skip
        assert found.to_numpy() == pytest.approx(exact, rel=1e-4, abs=1e-4 * np.abs(exact).max())


@pytest.fixture(scope="module")
def stop():
    return run_stop(scenario_of(FITS["identified"], "trapezoid", ABC))


@pytest.fixture(scope="module")
def course(stop):
    return course_of(stop)


def test_a_brake_that_satisfies_equation_9_suffices_where_the_curve_is_concave(course):
    sufficient = inequalities(course)["(15) dV/dt < 0 with u of (9)"]
    concave = course.judged & (course.curvature < 0)
    assert concave.sum() > 1000
    assert sufficient[concave].mean() > 0.99
    assert sufficient[course.judged & ~concave].mean() < 0.01


def test_the_equilibrium_lies_on_either_side_of_the_peak(stop):
    """While slip rises and speed falls, both terms of equation 12 cancel on one side of the peak; while it falls, on
    the other. The offset follows from the curvature: (∂α/∂v · v̇/ṡ) / |∂²α/∂s²|, here below a tenth of the slip."""
    found = offset_of(stop)
    low, high = sorted((found["rising"], found["falling"]))
    assert low <= found["peak"] <= high
    assert high - low < 0.1 * found["peak"]
    assert 0.0 <= found["loss"] < 1e-3
    assert 0.005 < found["peak"] < 0.05


def test_pressure_raises_the_slip_rate_by_its_torque(stop, course):
    """From J ω̇ = r F − T, where the torque is an output of the plant, which rounds the corner at the spring's force."""
    brake, trace = VehicleData(stop.scenario).true.brakes[GROUP], stop.trace
    torque = trace["brake_torque"].values[1:, GROUP]
    speed = (trace["speed"].values[1:] + trace["speed"].values[:-1]) / 2
    change, expected = (
        (course.slip_rate - course.lowest).to_numpy(),
        torque * brake.wheel_radius / (brake.inertia * speed),
    )
    pressed = course.judged.to_numpy() & (torque > 0.1 * torque.max())
    assert pressed.sum() > 1000
    assert change[pressed] == pytest.approx(expected[pressed], rel=1e-3)
    assert (course.gain > 0).all()


def test_violations_are_shares_of_the_evaluated_samples(course):
    first = np.arange(len(course))
    some = course.assign(curvature=np.where(first < 3, 1.0, -1.0), applied=np.nan)
    found = violations(some, first < 10)
    assert (found["samples"], found["∂²α/∂s² < 0"]) == (10, 0.3)
    assert np.isnan(found["(9) u has the sign of σ"])
