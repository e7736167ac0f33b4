"""Braking curves against closed forms, against an integration of the equation of motion, and on impossible lines."""

import numpy as np
import pytest
from energy_balance import stopping_distance
from hypothesis import example, given
from hypothesis import strategies as st
from onboard import FAR, case_of, train_data
from scipy.integrate import solve_ivp

from railgrip.base.errors import InputError
from railgrip.supervision.curve import Deceleration, Steps, braking_curve, combine
from railgrip.supervision.limits import emergency_curve, gradient_deceleration, lowest_gradient, service_curve

INFINITE = -np.inf


def test_a_step_includes_its_end_and_not_its_start():
    """SUBSET-026 3.13.2.2.3.1.3: AD_0 for 0 ≤ V ≤ V1, AD_1 for V1 < V ≤ V2."""
    steps = Steps.of([(0.0, 1.0), (10.0, 2.0), (20.0, 3.0)])
    assert steps.at([0, 5, 10, 10.001, 20, 21]).tolist() == [1, 1, 1, 2, 2, 3]
    assert combine(np.multiply, steps, Steps.of([(0.0, 1.0), (15.0, 10.0)])).at([10, 15, 16, 21]).tolist() == [
        1, 2, 20, 30,
    ]  # fmt: skip


def test_a_curve_of_constant_deceleration_is_a_parabola():
    curve = service_curve(case := case_of(train_data(), ("EoA", FAR, 0)), case.line.target[0])
    speeds = np.array([0.0, 10.0, 55.0])
    assert curve.location(speeds) == pytest.approx(FAR - speeds**2 / (2 * 0.8), abs=1e-9)
    assert curve.speed(curve.location(speeds)) == pytest.approx(speeds, abs=1e-6)
    assert curve.speed(FAR + 1) == 0


steps_of_speed = st.lists(st.tuples(st.floats(1, 80), st.floats(0.3, 1.5)), max_size=6)
steps_of_place = st.lists(st.tuples(st.floats(-4000, 1000), st.floats(-0.25, 0.3)), max_size=6)


@given(first=st.floats(0.3, 1.5), brake=steps_of_speed, level=st.floats(-0.25, 0.3), gradient=steps_of_place,
       speed=st.floats(5, 40))  # fmt: skip
@example(first=1.0, brake=[(51.0, 0.375)], level=-0.25, gradient=[], speed=30.25)
def test_a_curve_solves_the_equation_of_motion(first, brake, level, gradient, speed):
    """d(v²)/ds = −2 A(v, s), by an integrator that stops where A changes; its own error is far below a millimetre."""
    by_speed, by_place = sorted({v: a for v, a in brake}.items()), sorted({d: a for d, a in gradient}.items())
    over_speed, over_place = Steps.of([(0.0, first), *by_speed]), Steps.of([(INFINITE, level), *by_place])
    curve = braking_curve(Deceleration.of(np.add, [over_speed], [over_place]), location=0.0, speed=speed, foot=2.0)

    def slope(place, square):
        return [-2 * float(over_speed.at(np.sqrt(max(square[0], 0.0))) + over_place.at(place))]

    for end in (-1500.0, float(curve.locations[-1])):
        # A is positive, so that the speed falls in the direction of travel and rises against it.
        way, place, square = np.sign(end), 0.0, speed**2
        for bound in sorted({*(d for d, _ in by_place if 0.0 < way * d < way * end), end}, key=abs):
            while way * place < way * bound:
                changes = [v**2 for v, _ in by_speed if way * v**2 < way * square]
                following = max(changes, key=lambda change: way * change, default=INFINITE)

                def reached(_, y, following=following):
                    return y[0] - following

                reached.terminal = True
                found = solve_ivp(slope, (place, bound), [square], events=reached, rtol=1e-9, atol=1e-9)
                # A little beyond the change, where A is that of the next part.
                place, square = found.t[-1] + way * 1e-9, found.y[0, -1] * (1 - way * 1e-12)
        assert float(curve.location(max(np.sqrt(square), 2.0))) == pytest.approx(end, abs=1e-3)


def test_the_lowest_gradient_under_the_train_counts():
    """SUBSET-026 3.13.4.2.1, by looking at every metre of the train."""
    sections = [{"begin": 1000, "slope": -0.01}, {"begin": 1150, "slope": 0.012}, {"begin": 1700, "slope": -0.002}]
    case = case_of(train_data(length=200), ("EoA", FAR, 0), gradient=sections)
    begins, slopes = [-1e9, 1000, 1150, 1700], [0.0, -0.01, 0.012, -0.002]

    def slope(place):
        return slopes[np.searchsorted(begins, place, side="right") - 1]

    lowest = lowest_gradient(case.line, 200)
    for front in np.arange(900.5, 2200, 7):
        assert lowest.at(front) == min(slope(front - back) for back in np.linspace(0, 200, 2001))


@pytest.mark.parametrize(("before", "behind"), [(0.02, -0.02), (-0.02, 0.02), (-0.015, -0.015), (0.0, -0.02)])
def test_a_curve_is_not_shorter_than_the_stop_by_the_balance_of_energy(before, behind):
    """On the lowest gradient under a train of 200 m it is as long only where that is the gradient everywhere."""
    gradient = [{"begin": 0, "slope": before}, {"begin": FAR - 300, "slope": behind}]
    case = case_of(train_data(rotating_mass=0.05), ("EoA", FAR, 0), gradient=gradient)
    begin = float(service_curve(case, case.line.target[0]).location(30.0))
    profile = ((-1e5, before), (FAR - 300 - begin, behind))
    places = np.arange(0.5, 200.0)
    # The specification has the tangent of the gradient in place of its sine, with the rotating mass.
    by_energy = stopping_distance(30.0, 0.8, places, np.full(200, 1 / 200), profile, gravity=9.81 / 1.05)
    assert FAR - begin > by_energy + 0.05 or before == behind
    assert FAR - begin == pytest.approx(by_energy, rel=2e-4 if before == behind else 0.4)


def test_gradients_act_as_in_the_figure_of_the_specification():
    """SUBSET-026 figure 35: accelerations of gradients with M_rotating_min downhill and M_rotating_max uphill."""
    for slope, acceleration in ((-0.009, -0.0865), (-0.018, -0.1729), (-0.008, -0.0769), (0.007, 0.05965), (0, 0)):
        case = case_of(train_data(), ("EoA", FAR, 0), gradient=[{"begin": 0, "slope": slope}])
        # The figure was drawn with 9.80 m/s2, where the text has 9.81, and has four decimals.
        assert float(gradient_deceleration(case).at(FAR)) == pytest.approx(9.81 / 9.8 * acceleration, abs=1e-4)
    known = case_of(train_data(rotating_mass=0.05), ("EoA", FAR, 0), gradient=[{"begin": 0, "slope": -0.01}])
    assert float(gradient_deceleration(known).at(FAR)) == pytest.approx(-9.81 * 0.01 / 1.05)


def test_an_emergency_curve_to_a_speed_crosses_its_ceiling_intervention_at_the_target():
    """SUBSET-026 3.13.8.3.1: through V_target + dV_ebi at the target, and on to V_target."""
    case = case_of(train_data(), ("LoA", FAR, 160))
    curve = emergency_curve(case, case.line.target[0])
    above = 160 + 7.5 + 7.5 * 50 / 100
    assert float(curve.location(above / 3.6)) == pytest.approx(FAR)
    assert curve.locations[-1] == pytest.approx(FAR + (above**2 - 160**2) / 3.6**2 / 2)


def test_reported_low_adhesion_limits_the_brake_until_the_train_has_left():
    """SUBSET-026 3.13.5.3, 3.13.6.2.1.3; two stretches, the second before the train has left the first."""
    stretches = [{"begin": 19_000, "end": 19_100}, {"begin": 19_200, "end": 19_300}]
    case = case_of(train_data(length=200), ("SvL", FAR, 0), low_adhesion=stretches)
    curve = emergency_curve(case, case.line.target[0])
    end, begin = 19_300 + 200, 19_000
    assert curve.speed(end) ** 2 == pytest.approx(2 * 1.0 * (FAR - end))
    assert curve.speed(begin) ** 2 == pytest.approx(2 * 1.0 * (FAR - end) + 2 * 0.7 * (end - begin))
    magnets = case_of(
        train_data(brakes_without_adhesion=True), ("SvL", FAR, 0), low_adhesion=stretches,
        national={"A_NVMAXREDADH1": 0.9},
    )  # fmt: skip
    faster = emergency_curve(magnets, magnets.line.target[0])
    assert faster.speed(begin) ** 2 == pytest.approx(2 * 1.0 * (FAR - end) + 2 * 0.9 * (end - begin))


def test_a_brake_that_does_not_hold_the_train_on_a_gradient_is_refused():
    case = case_of(
        train_data(service=((0.0, 0.8), (30.0, 0.1))), ("EoA", FAR, 0), gradient=[{"begin": 0, "slope": -0.03}]
    )
    with pytest.raises(InputError, match=r"train, SBD of EoA: .* at 19\d\d\d m: its deceleration at 108.0 km/h is -0"):
        service_curve(case, case.line.target[0])
