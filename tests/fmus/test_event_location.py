"""Events occur at the right instant with the right effect, compared with closed forms."""

import ctypes
import math

import numpy as np
import pytest
from small_fmus import INTERFACES, trajectory

from railgrip.fmus.native.code import repeating_discretes
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.system import explicit


def last_bounce(end, e=0.7, g=9.81, h=1.0):
    """Return the number of a ball's bounces until a time, the instant of the last and its speed just after it."""
    count, speed = 0, math.sqrt(2 * g * h)
    time = following = speed / g
    while following <= end:
        count, time, speed = count + 1, following, e * speed
        following += 2 * speed / g
    return count, time, speed


@pytest.mark.parametrize(("step", "end"), [(1e-3, 1.6), (0.05, 1.6), (0.05, 2.5)])
def test_a_ball_bounces_at_the_end_of_its_parabola(feature, run, step, end):
    """Ballistic flight is integrated exactly; the remaining error is the location of each bounce, 1e-10 s.

    At 2.5 s it flies for 14 ms, less than a step: it leaves the ground and returns to it within an internal step.
    """
    instance = run(feature("BouncingBall"))
    instance.steps(round(end / step), step)
    count, t, v = last_bounce(end)
    assert instance.count("bounces") == count
    assert instance.get("v")[0] == pytest.approx(v - 9.81 * (end - t), abs=1e-8)
    assert instance.get("h")[0] == pytest.approx(v * (end - t) - 0.5 * 9.81 * (end - t) ** 2, abs=1e-8)


def test_friction_stops_holds_and_releases(feature, run):
    """v²/2 = (F/m) s until it stops; it stays; the pull exceeds friction at 5 s and accelerates it."""
    instance = run(feature("StickSlip"))
    instance.steps(400, 0.01)
    assert instance.get("s")[0] == pytest.approx(1.5**2 / (2 * 3 / 2), abs=1e-9)
    assert instance.get("v")[0] == 0.0
    instance.steps(200, 0.01, first=400)
    # From 5 s m dv/dt = t − 5, so that v(6 s) = 1/(2m).
    assert instance.get("v")[0] == pytest.approx(0.25, abs=1e-8)


def test_a_jump_of_an_input_triggers_its_event_at_once(feature, run):
    fmu = feature("Driven")
    instance = run(fmu, start={"k": 1.0})
    instance.steps(10, 0.1)
    assert instance.count("count") == 0
    instance.set(u=10.0)
    instance.steps(5, 0.1, first=10)
    assert instance.count("count") == 1
    instance.fmu.setBoolean([fmu.reference("frozen")], [True])
    before = instance.get("x")
    instance.steps(5, 0.1, first=15)
    assert instance.get("x") == before


COUNTER = """model M
  Boolean odd(start=false, fixed=true);
  discrete Real line[3](each start=0, each fixed=true);
  Integer count(start=0, fixed=true);
  Real x(start=0, fixed=true);
equation
  when sample(0.1, 0.1) then
    odd = not pre(odd);
    line = cat(1, {pre(line[1]) + 1}, pre(line[1:2]));
  end when;
  when pre(odd) then
    count = pre(count) + 1;
  end when;
  der(x) = line[3];
end M;
"""


def test_variables_read_only_by_clocked_equations_cause_no_second_pass(written):
    """Only clocked equations and a derivative read the delay line; another when clause also reads the flag."""
    system = explicit(read("M", written(COUNTER)))
    assert [system.variables.discretes[i].name for i in repeating_discretes(system)] == ["odd", "count"]


def test_a_clause_acts_at_the_tick_that_changes_its_variables(modelica, run):
    """The flag rises at the ticks of 0.1, 0.3 and 0.5 s."""
    instance = run(modelica(COUNTER))
    counts = []
    for k in range(55):
        instance.steps(1, 0.01, first=k)
        counts.append(instance.count("count"))
    assert [counts[k] for k in (8, 10, 28, 30, 48, 50)] == [0, 1, 1, 2, 2, 3]
    assert instance.get("line[1]", "line[2]", "line[3]") == [5.0, 4.0, 3.0]
    # line[3] was 1 from 0.3 s, 2 from 0.4 s and 3 from 0.5 s.
    assert instance.get("x")[0] == pytest.approx(0.1 * 1 + 0.1 * 2 + 0.05 * 3, abs=1e-9)


MULTIVIBRATOR = """model M "Relaxation oscillator: amplifier of gain 15000 between ±15 V with hysteresis"
  parameter Real tau = 0.05/log(3);
  Real c(start=1, fixed=true);
  Real v(start=-15);
equation
  v = noEvent(if 15000*(0.5*v - c) > 15 then 15 elseif 15000*(0.5*v - c) < -15 then -15 else 15000*(0.5*v - c));
  tau*der(c) = v - c;
end M;
"""


# The same with the current through two resistors of 1 kΩ, on which the amplified voltage depends with 1.5e7 V/A.
WITH_A_CURRENT = (
    MULTIVIBRATOR.replace("0.5*v", "1000*i")
    .replace("v = noEvent", "2000*i = noEvent")
    .replace("Real v(start=-15);", "Real v = 2000*i, i(start=-0.0075);")
)


@pytest.mark.parametrize("text", [MULTIVIBRATOR, WITH_A_CURRENT], ids=["voltage", "current"])
@pytest.mark.parametrize("step", [1e-3, 0.00625, 0.25])
def test_a_solution_of_a_loop_that_ceases_to_exist_is_left_at_that_instant(modelica, run, text, step):
    """A saturated branch ends where the input reaches ±(7.5 − 0.001) V; between these the capacitor relaxes to ±15 V.

    The tolerance is that of ten half periods integrated with a relative error of 1e-5; a switch that is late by a step
    of 1 ms would be an error of 0.3 V.
    """
    instance = run(modelica(text))
    tau, end, limit = 0.05 / math.log(3), 0.5, 7.5 - 0.001
    instance.steps(round(end / step), step)
    first, half = tau * math.log(16 / (15 - limit)), tau * math.log((15 + limit) / (15 - limit))
    count, rest = divmod(end - first, half)
    side = 1 if count % 2 == 0 else -1
    assert instance.get("c")[0] == pytest.approx(side * (15 - (15 + limit) * math.exp(-rest / tau)), abs=1e-3)
    assert instance.get("v")[0] == pytest.approx(side * 15, abs=1e-6)


@pytest.mark.parametrize("interface", INTERFACES)
def test_a_loop_through_a_limiter_is_solved_from_its_limits(modelica, interface):
    """A voltage follower of gain 15000; Newton's method alone changes between the limits of the amplifier, ±15 V.

    Its residual is below 1e-10 of the limits, times the gain.
    """
    fmu = modelica(
        "model M Real u(start=-8,fixed=true), v(start=14); equation der(u) = 16;"
        " v = noEvent(if 15000*(u - v) > 15 then 15 elseif 15000*(u - v) < -15 then -15 else 15000*(u - v)); end M;"
    )
    u, v = np.array(trajectory(fmu, interface, "u", "v"))
    assert np.ptp(u) == pytest.approx(16, rel=1e-6)
    assert v == pytest.approx(u * 15000 / 15001, abs=1e-6)


@pytest.mark.parametrize("start", [-5, 5])
@pytest.mark.parametrize("unknown", ["i", "p", "q"])
def test_a_declared_start_selects_the_solution_of_a_loop(modelica, start, unknown):
    """p² = 4 has the roots ±2; i = 2p and q = 3p have the sign of p."""
    declared = ", ".join(f"{name}(start={start})" if name == unknown else name for name in ("i", "p", "q"))
    fmu = modelica(
        f"model M Real {declared}; Real x(start=0,fixed=true); equation"
        " i = 2*p; q = 3*p + (i - 2*p); p*q + 5*(q - 3*p) = 12; der(x) = p; end M;"
    )
    x, i = trajectory(fmu, "CoSimulation", "x", "i")
    sign = math.copysign(1, start)
    assert [x[-1], i[-1]] == pytest.approx([2 * sign, 4 * sign], abs=1e-6)


@pytest.mark.parametrize("interface", INTERFACES)
def test_initial_equations_through_a_limiter_are_solved_from_its_limits(modelica, interface):
    fmu = modelica(
        "model M Real v(start=14), d = 15000*(2 - v); equation der(v) = 0;"
        " initial equation v = noEvent(if d > 15 then 15 elseif d < -15 then -15 else d); end M;"
    )
    (v,) = trajectory(fmu, interface, "v", stop=0.1)
    assert v == pytest.approx([2 * 15000 / 15001] * 2, abs=1e-6)


def test_model_exchange_locates_or_refuses_the_end_of_a_loops_solution(modelica, run):
    fmu = modelica(MULTIVIBRATOR)
    instance = run(fmu, "me")
    instance.fmu.newDiscreteStates()
    instance.fmu.enterContinuousTimeMode()
    instance.fmu.setTime(0.04)
    values = (ctypes.c_double * 1)(-8.0)
    instance.fmu.setContinuousStates(values, 1)
    assert instance.get("v")[0] == pytest.approx(15, abs=1e-6)
    # A trial step beyond the end of the branch has not selected the other one.
    values[0] = -5.0
    instance.fmu.setContinuousStates(values, 1)
    assert instance.get("v")[0] == pytest.approx(-15, abs=1e-6)


@pytest.mark.parametrize("interface", INTERFACES)
def test_a_relation_changes_where_its_sides_become_equal(modelica, interface):
    """max(x, 0) > 0 ends when x becomes 0 at 0.5 s, although the difference of its sides never becomes negative."""
    fmu = modelica(
        "model M Real x(start=1,fixed=true); Real y = max(x, 0); Boolean more = y > 0, none = y <= 0;"
        " Integer n(start=0,fixed=true); equation der(x) = -2; when y <= 0 then n = pre(n) + 1; end when; end M;"
    )
    assert [v[-1] for v in trajectory(fmu, interface, "more", "none", "n")] == [0, 1, 1]


@pytest.mark.parametrize("interface", INTERFACES)
def test_pre_in_a_loop_and_a_derivative_is_the_value_since_the_last_event(modelica, interface):
    """y³ + y is 2 for y = 1 and 10 for y = 2."""
    fmu = modelica(
        "model M Integer n(start=1,fixed=true); Real y(start=1), x(start=0,fixed=true), z(start=0,fixed=true);"
        " equation y^3 + y = 1 + pre(n); der(x) = y; der(z) = pre(n); when time > 0.5 then n = pre(n) + 8; end when;"
        " end M;"
    )
    assert [v[-1] for v in trajectory(fmu, interface, "x", "y", "z")] == pytest.approx([1.5, 2, 5], abs=1e-4)
