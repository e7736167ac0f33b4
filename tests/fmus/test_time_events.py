"""Events of functions of time occur at each of their instants, in both interfaces, compared with closed forms."""

import math

import numpy as np
import pytest
from small_fmus import INTERFACES, SCOPE, trajectory
from wrong import table


def ends(fmu, interface, stop=1.0, step=0.25, **start):
    """Return the values of all variables at `stop`."""
    names = fmu.names("local") + fmu.names("output")
    found = trajectory(fmu, interface, *names, stop=stop, step=step, **start)
    return {name: values[-1] for name, values in zip(names, found, strict=True)}


TIMER = """model M
  parameter Real T = 0.5;
  parameter Real late = 0.7;
  Real s(start=1, fixed=true);
  discrete Real strict(start=5, fixed=true), inclusive(start=5, fixed=true), shifted(start=5, fixed=true);
  Boolean after = time > T, before = time <= T;
  Integer i = if time > T then 2 else 1;
  Integer order(start=0, fixed=true);
  Real x(start=0, fixed=true);
  Real y(start=0, fixed=true);
equation
  when time > late then
    order = pre(order) + 100;
  elsewhen time > T then
    order = pre(order) + 1;
  end when;
  der(s) = -s;
  der(x) = if time <= T then 1 else -1;
  der(y) = 1;
  when time > T then
    strict = 9;
    reinit(y, 10);
  end when;
  when time >= T then
    inclusive = 9;
  end when;
  when time - 0.1 > late - 0.1 then
    shifted = 9;
  end when;
end M;
"""


@pytest.mark.parametrize("interface", INTERFACES)
@pytest.mark.parametrize(("T", "late"), [(0.5, 0.7), (0.3, 0.6), (1 / 3, 0.9)])
def test_strict_and_inclusive_relations_of_time_change_at_the_same_instant(modelica, interface, T, late):
    """MLS 3.6, 8.5: `time > T` becomes true just after T, `time >= T` at T; x and y are straight lines between them."""
    end = ends(modelica(TIMER), interface, T=T, late=late)
    assert (end["strict"], end["inclusive"], end["shifted"]) == (9, 9, 9)
    assert (end["after"], end["before"], end["i"], end["order"]) == (1, 0, 2, 101)
    # Model Exchange: CVODE's default tolerance of FMPy is 1e-4.
    assert end["x"] == pytest.approx(T - (1 - T), abs=1e-5)
    assert end["y"] == pytest.approx(10 + 1 - T, abs=1e-5)


@pytest.mark.parametrize("interface", INTERFACES)
def test_a_relation_of_time_at_the_start(modelica, interface):
    """`time > 0` becomes true just after a start at 0, `time >= 0` is already true there and has no edge."""
    fmu = modelica(
        "model M Integer a(start=0,fixed=true), b(start=0,fixed=true), c(start=0,fixed=true); equation"
        " when time > 0 then a = pre(a) + 1; end when; when time >= 0 then b = pre(b) + 1; end when;"
        " when {initial(), time > 0} then c = pre(c) + 1; end when; end M;"
    )
    end = ends(fmu, interface)
    assert (end["a"], end["b"], end["c"]) == (1, 0, 2)


PIECEWISE = table(__file__, "tables.toml")["piecewise"]


def closed_form(expression):
    """Return duration and number of rising edges on a grid of 1 µs, whose instants are not those of the events."""
    t = np.concatenate([[0.0], (np.arange(1_000_000) + 0.4321) * 1e-6])
    scope = SCOPE | {"time": t, "T": 0.2, "where": np.where}
    python = expression.replace("(if time < 0.5 then time else time - 0.5)", "where(time < 0.5, time, time - 0.5)")
    holds = eval(python.replace("^", "**"), scope)
    return holds.mean(), int(np.sum(holds[1:] & ~holds[:-1]))


@pytest.mark.parametrize("interface", INTERFACES)
@pytest.mark.parametrize("expression", PIECEWISE)
def test_each_crossing_of_a_function_of_time_is_an_event(modelica, interface, expression):
    """Also with communication steps that contain several of them; the reference is the expression in numpy."""
    duration, edges = closed_form(expression)
    fmu = modelica(
        f"model M parameter Real T = 0.2; Boolean on = {expression}; Integer n(start=0,fixed=true);"
        " Integer read(start=0,fixed=true);"
        f" Real x(start=0,fixed=true), y(start=0,fixed=true); equation der(x) = if {expression} then 1 else 0;"
        " der(y) = if on then 1 else 0;"
        f" when {expression} then n = pre(n) + 1; end when; when on then read = pre(read) + 1; end when; end M;"
    )
    end = ends(fmu, interface)
    # CVODE with FMPy's tolerance of 1e-4, and the grid of the reference of 1e-6.
    assert (end["x"], end["y"]) == pytest.approx((duration, duration), abs=2e-5)
    assert (end["n"], end["read"]) == (edges, edges)


def test_functions_of_time_are_searched_in_a_model_without_states(modelica, run):
    """sin(20 t) > 0.5 holds from asin(0.5)/20 in each period of π/10 s; the location is accurate to 1e-10 s."""
    fmu = modelica(
        "model M discrete output Real at(start=0,fixed=true); equation when sin(20*time) > 0.5 then at = time;"
        " end when; end M;"
    )
    instance = run(fmu)
    instance.steps(1, 1.0)
    assert instance.get("at")[0] == pytest.approx(math.asin(0.5) / 20 + 3 * math.pi / 10, abs=2e-10)


@pytest.mark.parametrize("interface", INTERFACES)
def test_a_sine_compared_with_a_carrier_has_all_its_pulses(modelica, interface):
    """Pulse-width modulation of 50 Hz at 5 kHz; the shortest pulse lasts 48 ns, twelve points of the grid."""
    t = (np.arange(5_000_000) + 0.4321) * 4e-9
    wanted = np.sin(2 * np.pi * 50 * t) > 2 * np.abs(2 * np.mod(5000 * t, 1) - 1) - 1
    fmu = modelica(
        "model M Boolean on = sin(2*3.141592653589793*50*time) > 2*abs(2*mod(5000*time, 1) - 1) - 1;"
        " Integer n(start=0,fixed=true); Real x(start=0,fixed=true); equation der(x) = if on then 1 else 0;"
        " when on then n = pre(n) + 1; end when; end M;"
    )
    end = ends(fmu, interface, stop=0.02, step=0.01)
    assert end["n"] == np.sum(wanted[1:] & ~wanted[:-1])
    assert end["x"] == pytest.approx(0.02 * wanted.mean(), abs=1e-6)
