"""Contact forces of the library compared with Kalker's simplified theory in strips, at longitudinal creepage."""

import numpy as np
import pytest
from fastsim import closed_form, creep_force

from railgrip.fmus.native import lower
from railgrip.simulate.contact import compiled_contact

EPSILONS = np.array([0.02, 0.1, 0.3, 0.6, 1.0, 1.5, 2.0, 8 / 3, 4.0, 10.0])
"""Polach's gradient of the tangential stress; at 8/3 FASTSIM slides everywhere."""


def rise_of(epsilon):
    """ε = G π a b c11 s/(4 Q μ), and the rise is 2 a s/(L μ p0) with L = 8 a/(3 G c11), p0 = 2 Q/(π a b)."""
    return 2 * 3 / 8 * (np.pi / 2) * (4 / np.pi) * epsilon


def of_library(epsilon, point="ContactPoint"):
    """Return force over friction times load from the library, at slips with these gradients."""
    shape = {"k_A": 1.0, "k_S": 1.0, "A_falling": 1.0, "B_falling": 0.0}
    contact = compiled_contact(lower(f"RailBraking.FMUs.{point}"), {}, shape)
    mu0, load = 0.3, np.full(1, 137e3)
    small = np.full(1, 1e-7)
    # For vanishing slip the force is 4 ε/π times friction times load, which yields ε over slip of this wheel.
    slope = contact(small, np.ones(1), load, np.full(1, mu0)) / small / mu0 * np.pi / 4
    slip = epsilon / slope
    same = np.ones_like(slip)
    return contact(slip, same, load * same, mu0 * same) / mu0


def test_the_stepped_strips_agree_with_the_closed_form():
    """First order in the step of a strip, 1/400 of its length."""
    for epsilon in EPSILONS:
        assert creep_force(rise_of(epsilon)) == pytest.approx(closed_form(rise_of(epsilon)), rel=5e-3)


def test_polach_is_above_fastsim_in_partial_slip_and_below_it_near_full_slip():
    """Polach bounds stress by Hertz's ellipsoid, Kalker by a paraboloid, which is lower at the edges of the contact."""
    ratio = of_library(EPSILONS) / [creep_force(rise_of(epsilon)) for epsilon in EPSILONS]
    assert np.all(np.abs(ratio - 1) < 0.085)
    assert np.all(ratio[EPSILONS <= 1.0] > 1.0)
    assert np.all(ratio[(EPSILONS > 1.4) & (EPSILONS < 9)] < 1.0)


def test_the_simplified_contact_agrees_with_fastsim():
    """Strips of the reference have an error of 1/4000 of the small axis, which is larger for the narrowest."""
    expected = [closed_form(rise_of(epsilon)) for epsilon in EPSILONS]
    assert of_library(EPSILONS, "SimplifiedContactPoint") == pytest.approx(expected, rel=2e-5)
