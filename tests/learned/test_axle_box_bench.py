"""Exponents of friction, and measures of the family of the comparison."""

import numpy as np
import pytest
from axle_box_runs import elasticity, figures_of


def test_an_exponent_is_found_with_its_interval():
    random = np.random.default_rng(3)
    friction, speed = np.exp(random.uniform(-3, -1, 80)), random.uniform(7, 27, 80)
    noise = np.exp(0.1 * random.standard_normal(80))
    found = elasticity(friction**-0.3 * speed**1.5 * noise, friction, np.log(speed)[:, np.newaxis])
    assert found["low"] < -0.3 < found["high"]
    # Standard error: 0.1 over √80 times 0.58, the deviation of log friction.
    assert found["high"] - found["low"] == pytest.approx(2 * 1.96 * 0.1 / (np.sqrt(80) * 0.58), rel=0.3)
    assert found["explained"] > 0.6
    none = elasticity(speed * noise, friction, np.log(speed)[:, np.newaxis])
    assert none["low"] < 0 < none["high"]
    assert none["explained"] < 0.1


def test_skill_is_over_the_constant_and_a_missing_claim_is_left_out():
    error = np.array([0.1, -0.1, 0.1, -0.1])
    learned, constant = figures_of({"learned": (0.5 * error, np.full(4, 0.05)), "constant": (error, None)})
    assert learned["skill over constant"] == pytest.approx(0.75)
    assert (learned["coverage"], learned["NEES"]) == (1.0, pytest.approx(1.0))
    assert np.isnan([constant[name] for name in ("coverage", "NEES", "skill over constant")]).all()
