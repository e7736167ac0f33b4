"""The predictions of rig and wagon satisfy the contract, as functions and as FMUs, with either pad law."""

import numpy as np
import pytest
from contracts.prediction import prediction_contract

from railgrip.estimation.models import of_class

POINTS = {
    "RollerRigPrediction": ([65.0, 32.0, 0.37, 0.06], [2.1e4]),
    "WagonPrediction": ([65.0, 64.0, 31.0, 0.37, 0.33, 0.06], [2.1e4, 1.4e4, -700.0, -60.0, -50.0]),
}


@pytest.mark.parametrize("relaxes", [0.0, 1.0])
@pytest.mark.parametrize("name", POINTS)
def test_the_fmu_equals_the_function(name, relaxes):
    function, by_fmu = (of_class(name).prediction({"mu_b_relaxes": relaxes}, kind=kind) for kind in ("compiled", "fmu"))
    x, u = (np.array(values) for values in POINTS[name])
    with by_fmu as unit:
        prediction_contract(unit, x, u)
        # The same expressions from another code generator: rounding of terms up to a thousand times the result.
        assert unit.derivative(x, u) == pytest.approx(function.derivative(x, u), rel=1e-12, abs=1e-12)
        jacobian = function.derivative_jacobian(x, u)
        np.testing.assert_allclose(unit.derivative_jacobian(x, u), jacobian, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("mu_b", [0.2, 0.05, 0.0, -0.1])
def test_relaxation_is_equation_9_and_stays_finite_below_its_guard(mu_b):
    rig = of_class("RollerRigPrediction").prediction({"mu_b_relaxes": 1.0, "T_mu": 20.0, "mu_b_rest": 0.35})
    rate = rig.derivative(np.array([60.0, 30.0, mu_b, 0.05]), np.array([2e4]))[2]
    # The corner is rounded by a friction of 0.5e-3, one hundredth of the guard at 0.05.
    assert rate == pytest.approx((0.35 - mu_b) / (20.0 * max(mu_b, 0.05)), rel=0.011)
