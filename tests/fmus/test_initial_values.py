"""Initial values of discrete variables, and fixed start values of variables that are not states."""

import pytest
from small_fmus import INTERFACES, trajectory
from wrong import table

from railgrip.fmus.native.dae import read
from railgrip.fmus.native.system import explicit

PULSE = """model M "High for the first half of each period, counted from the start time; T may be changed"
  parameter Real T = 0.3, start_time = 0.05;
  output Real y;
protected
  Real begin "of the present period";
  Integer count;
initial {section}
equation
  when integer((time - start_time)/T) > pre(count) then
    count = pre(count) + 1;
    begin = time;
  end when;
  y = if time < start_time or time >= begin + T/2 then 0 else 1;
end M;
"""
SECTIONS = (
    "algorithm count := integer((time - start_time)/T); begin := start_time + count*T;",
    "equation pre(count) = integer((time - start_time)/T); pre(begin) = start_time + pre(count)*T;",
)


@pytest.mark.parametrize("interface", INTERFACES)
@pytest.mark.parametrize("section", SECTIONS)
@pytest.mark.parametrize("T", [0.33, 0.47])
def test_a_periodic_pulse_starts_within_its_period(modelica, interface, section, T):
    """The form of the standard library's pulse source; the reference is its definition, between its edges."""
    (y,) = trajectory(modelica(PULSE.format(section=section)), interface, "y", T=T, step=0.07, stop=1.4)
    expected = [float(t >= 0.05 and (t - 0.05) % T < T / 2) for t in (0.07 * k for k in range(21))]
    assert y == expected


@pytest.mark.parametrize("interface", INTERFACES)
def test_the_start_of_a_discrete_variable_follows_its_parameter(modelica, interface):
    fmu = modelica(
        "model M parameter Real p = 2; discrete Real d(start=2*p, fixed=true); Real x(start=0, fixed=true); equation"
        " der(x) = d; when time > 0.5 then d = pre(d) + 1; end when; end M;"
    )
    d, x = trajectory(fmu, interface, "d", "x", p=3.0)
    assert (d[0], d[-1]) == (6, 7)
    assert x[-1] == pytest.approx(0.5 * 6 + 0.5 * 7, abs=1e-5)


@pytest.mark.parametrize("interface", INTERFACES)
def test_a_state_starts_at_the_value_that_when_initial_gives(modelica, interface):
    fmu = modelica(
        "model M discrete Real d; Integer n(start=1,fixed=true); Real x; initial equation x = 2*d; equation der(x) = 0;"
        " when initial() then d = 3; n = pre(n) + 4; end when; end M;"
    )
    d, n, x = trajectory(fmu, interface, "d", "n", "x")
    assert (d[0], n[-1], x[0], x[-1]) == (3, 5, 6, 6)


@pytest.mark.parametrize("interface", INTERFACES)
def test_a_step_of_a_state_graph_is_left_at_its_transition(modelica, interface):
    """pre() of Booleans that other equations determine: active until the transition fires at 0.55 s."""
    fmu = modelica(
        "model M Boolean active, next, fire; initial equation pre(next) = true; equation fire = active and time > 0.55;"
        " active = pre(next); next = active and not fire; end M;"
    )
    (active,) = trajectory(fmu, interface, "active")
    assert active == [1.0] * 6 + [0.0] * 5


# Declarations and equations → initial value of x.
FIXED = table(__file__, "tables.toml")["fixed"]


@pytest.mark.parametrize("interface", INTERFACES)
@pytest.mark.parametrize("case", FIXED)
def test_a_fixed_start_is_an_initial_equation(modelica, interface, case):
    """MLS 3.6, section 8.6, for all continuous variables, states or not."""
    declarations, equations, x = FIXED[case]
    (found,) = trajectory(modelica(f"model M {declarations} equation {equations} end M;"), interface, "x")
    assert found[0] == pytest.approx(x, abs=1e-9)


@pytest.mark.parametrize("interface", INTERFACES)
def test_initial_equations_depend_on_fixed_values_that_the_importer_sets(modelica, interface):
    """x + d and z·z = x at the start, with the importer's values; y and z are constant afterwards."""
    fmu = modelica(
        "model M parameter Real p = 2; Real x(start=1,fixed=true), w(start=p,fixed=true), y, z(start=1); "
        "discrete Real d(start=1,fixed=true); initial equation y = x + w + pre(d); z*z = x; "
        "equation der(x) = 0; der(w) = 0; der(y) = 0; der(z) = 0; when time > 5 then d = 0; end when; end M;"
    )
    assert [v[-1] for v in trajectory(fmu, interface, "y", "z")] == pytest.approx([4, 1], abs=1e-12)
    values = trajectory(fmu, interface, "y", "z", x=9, p=7)
    assert [v[-1] for v in values] == pytest.approx([17, 3], abs=1e-12)


def test_an_assertion_of_an_initial_equation_is_checked_at_the_start_only(written):
    """Section 8.6; the state violates it later."""
    file = written(
        "model M\n Real x(start=1, fixed=true);\ninitial equation // not in the equation below\n"
        ' assert(x > 0.5, "initial equation");\nequation\n der(x) = -3*x;\n assert(x > 0.3, "equation");\n'
        'initial algorithm\n assert(x > 0.9, "initial algorithm");\nend M;\n',
    )
    system = explicit(read("M", file))
    assert {a.message[0] for a in system.checks("start")} == {"initial equation", "initial algorithm"}
    assert [a.message[0] for a in system.checks("running")] == ["equation"]
