"""The comparison of FMUs of two compilers, tested on two built-in FMUs with the differences of two compilers."""

import numpy as np
import pytest
from agreement import Pair, disagreement, integrated, nudged, stepped, turns

from railgrip.fmi import describe

MODEL = """
model M
  model Spring
    parameter Real c = 2;
    Real x(start=1, fixed=true);
  equation
    der(x) = -c*x;
  end Spring;
  parameter Real k = 3;
  input Real speed(unit="1", start=0);
OUTPUTS
VISIBILITY
  Spring spring;
equation
  y = k*spring.x;
  z = y + speed;
end M;
"""
Y, Z = "  output Real y;\n", "  output Real z;\n"


@pytest.fixture(scope="module")
def pair(modelica) -> Pair:
    """The same equations: outputs in another order, and a component that the second class protects."""
    ours = MODEL.replace("OUTPUTS\n", Y + Z).replace("VISIBILITY\n", "")
    theirs = MODEL.replace("OUTPUTS\n", Z + Y).replace("VISIBILITY\n", "protected\n")
    return Pair(describe(modelica(ours).path), describe(modelica(theirs).path))


def test_the_pair_has_the_intended_differences(pair):
    assert pair.ours.names("output") == ("y", "z")
    assert pair.theirs.names("output") == ("z", "y")
    assert {"k", "spring.c"} <= set(pair.ours.names("parameter"))


def test_protected_variables_are_hidden_except_for_states(pair):
    """As in omc (getExportVar in its SimCodeUtil.mo, with --fmiFilter=protected, its default)."""
    assert "k" in pair.theirs.variables
    assert "spring.c" not in pair.theirs.variables
    assert pair.theirs.states == pair.ours.states == ("spring.x",)
    assert {"spring.x", "der(spring.x)"} <= set(pair.theirs.variables)


def test_only_parameters_that_both_offer_are_perturbed(pair):
    assert nudged(pair) == pytest.approx({"k": 2.97, "_tolerance": 0.99e-6}, rel=1e-12)


def test_steps_are_compared_by_name(pair):
    ours, theirs = (stepped(d, {"speed": 10.0}, {}, 0.1) for d in (pair.ours, pair.theirs))
    assert sorted(ours) == sorted(theirs) == ["y", "z"]
    for n in ours:
        np.testing.assert_allclose(theirs[n], ours[n], rtol=1e-12)
    np.testing.assert_allclose(ours["y"][-1], 3 * np.exp(-0.2), rtol=1e-6)
    np.testing.assert_allclose(ours["z"] - ours["y"], 10.0, rtol=1e-12)


def test_trajectories_are_compared_by_name_and_a_difference_is_found(pair):
    ours, theirs = (integrated(d, {"speed": 10.0}, {"k": 2.97}, 0.3) for d in (pair.ours, pair.theirs))
    assert max(disagreement(ours, theirs, ()).values()) < 1e-9
    other = integrated(pair.theirs, {"speed": 10.0}, {"k": 2.97 * 1.001}, 0.3)
    worst = disagreement(ours, other, ())
    assert worst["y"] == pytest.approx(1e-3, rel=1e-3)
    assert 1e-4 < worst["z"] < 1e-3


def test_rows_next_to_an_event_are_excluded():
    kinds = [("locked", bool), ("speed", float)]
    ours = np.array([(False, 1.0), (False, 1.0), (True, 0.0), (True, 0.0), (True, 0.0)], dtype=kinds)
    late = np.array([(False, 1.0), (False, 1.0), (False, 1.0), (True, 0.0), (True, 0.0)], dtype=kinds)
    assert disagreement(ours, late, ("locked",)) == {"locked": 0.0, "speed": 0.0}
    assert disagreement(ours, late, ())["speed"] == 1.0


def test_a_train_that_creeps_at_4e_21_is_at_standstill():
    assert turns(np.array([3.0, 1.0, 4e-21, 4e-21])) == turns(np.array([3.0, 1.0, 0.0, 0.0])) == 2
    assert turns(np.array([3.0, 1.0, 1e-9, 0.0])) == 3
