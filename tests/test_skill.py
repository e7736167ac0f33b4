import numpy as np
import pytest
from skill import error_95_of_constant, rmse_over_constant


def test_the_best_constant_has_no_skill_and_any_other_less():
    truth = np.random.default_rng(1).normal(0.35, 0.03, (1000, 2))
    assert rmse_over_constant(np.broadcast_to(truth.mean(axis=0), truth.shape), truth) == pytest.approx([1.0, 1.0])
    assert (rmse_over_constant(np.full_like(truth, 0.36), truth) > 1.0).all()
    assert rmse_over_constant(truth, truth) == pytest.approx([0.0, 0.0])


def test_the_best_constant_has_the_smallest_95_percent_error():
    truth = np.random.default_rng(2).gamma(2.0, 0.02, (2001, 1))
    tried = [np.quantile(np.abs(truth - c), 0.95) for c in np.linspace(0.0, 0.2, 2001)]
    assert error_95_of_constant(truth)[0] == pytest.approx(min(tried), rel=5e-3)
