"""The co-simulation solvers have their nominal order, meet their tolerance, and are stable for stiff problems."""

import math
from itertools import pairwise

import fmpy
import numpy as np
import pytest
from scipy.integrate import solve_ivp

RODAS3, RODAS4 = 3, 4


@pytest.mark.parametrize(("solver", "order"), [(RODAS3, 3), (RODAS4, 4)])
def test_the_error_falls_with_the_order_of_the_method(feature, run, solver, order):
    """With a loose tolerance every communication step is one internal step; halving it divides the error by 2^order."""
    errors = []
    for steps in (20, 40, 80):
        instance = run(feature("Oscillator"), start={"_solver": solver, "_tolerance": 0.5})
        instance.steps(steps, 2.0 / steps)
        assert instance.count("_steps") == steps
        errors.append(math.hypot(instance.get("x")[0] - math.cos(2.0), instance.get("v")[0] + math.sin(2.0)))
    observed = [math.log2(a / b) for a, b in pairwise(errors)]
    # The leading error term does not yet dominate at these step sizes.
    assert min(observed) > order - 0.25


@pytest.mark.parametrize("solver", [RODAS3, RODAS4])
def test_a_stiff_reaction_keeps_its_tolerance(feature, run, solver):
    """Robertson's problem over 40 s against Radau; stiffness ratio 1e9."""

    def rates(_t, y):
        a, b, c = y
        return [-0.04 * a + 1e4 * b * c, 0.04 * a - 1e4 * b * c - 3e7 * b * b, 3e7 * b * b]

    exact = solve_ivp(rates, (0, 40), [1, 0, 0], method="Radau", rtol=1e-11, atol=1e-14).y[:, -1]
    instance = run(feature("Stiff"), start={"_solver": solver, "_tolerance": 1e-6})
    instance.steps(4, 10.0)
    # Global error of an L-stable method on a contracting problem: of the order of the local tolerance.
    assert np.allclose(instance.get("a", "b", "c"), exact, rtol=1e-5)
    assert instance.count("_steps") < 400


def test_a_smooth_phase_takes_one_internal_step_per_communication_step(feature, run):
    instance = run(feature("Oscillator"), start={"_tolerance": 1e-5})
    instance.steps(1000, 1e-3)
    assert instance.count("_steps") == 1000
    assert instance.count("_rejected") == 0


def test_the_answer_does_not_depend_on_the_communication_step(feature, run):
    ends = []
    for count in (10, 1000):
        instance = run(feature("Stiff"), start={"_tolerance": 1e-8})
        instance.steps(count, 10.0 / count)
        ends.append(instance.get("a", "b", "c"))
    assert np.allclose(ends[0], ends[1], rtol=1e-6)


def test_a_cancelled_pivot_is_avoided_by_pivoting(modelica, run):
    """With J = 2/h on the diagonal, I·c − J of RODAS3 has a zero there; the solution is a known rotation."""
    fmu = modelica(
        "model M Real x(start=1,fixed=true); Real y(start=0,fixed=true);"
        " equation der(x)=200*x+1000*y; der(y)=-1000*x+200*y; end M;"
    )
    instance = run(fmu, start={"_solver": RODAS3, "_tolerance": 0.9})
    instance.steps(1, 0.01)
    assert all(math.isfinite(v) for v in instance.get("x", "y"))
    tight = run(fmu, start={"_solver": RODAS3, "_tolerance": 1e-8})
    tight.steps(1, 0.01)
    growth = math.exp(2.0)
    assert tight.get("x", "y") == pytest.approx([growth * math.cos(10), -growth * math.sin(10)], rel=1e-5)


@pytest.mark.parametrize(("declared", "written"), [("0", None), ("-250", "250.0"), ("250", "250.0")])
def test_the_nominal_value_of_a_state_is_positive_in_the_description(modelica, declared, written):
    """FMI 2.0 requires it; importers divide by it, or take it times the relative tolerance."""
    fmu = modelica(f"model M Real x(start=1,fixed=true,nominal={declared}); equation der(x)=-x; end M;")
    (x,) = [v for v in fmpy.read_model_description(str(fmu.path)).modelVariables if v.name == "x"]
    assert x.nominal == written
