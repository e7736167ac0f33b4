"""The comparison of FMUs of two compilers, tested on two built-in FMUs with the differences of two compilers."""

import pytest
from agreement import Pair, disagreement, integrated

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


def test_protected_variables_are_hidden_except_for_states(pair):
    """As in omc (getExportVar in its SimCodeUtil.mo, with --fmiFilter=protected, its default)."""
    assert "k" in pair.theirs.variables
    assert "spring.c" not in pair.theirs.variables
    assert pair.theirs.states == pair.ours.states == ("spring.x",)
    assert {"spring.x", "der(spring.x)"} <= set(pair.theirs.variables)


def test_trajectories_are_compared_by_name_and_a_difference_is_found(pair):
    ours, theirs = (integrated(d, {"speed": 10.0}, {"k": 2.97}, 0.3) for d in (pair.ours, pair.theirs))
    assert max(disagreement(ours, theirs, ()).values()) < 1e-9
    other = integrated(pair.theirs, {"speed": 10.0}, {"k": 2.97 * 1.001}, 0.3)
    worst = disagreement(ours, other, ())
    assert worst["y"] == pytest.approx(1e-3, rel=1e-3)
    assert 1e-4 < worst["z"] < 1e-3
