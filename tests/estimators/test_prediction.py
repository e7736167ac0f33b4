import casadi as ca
import numpy as np
import pytest
from contracts.prediction import has_jacobians_that_are_slopes, prediction_contract
from hypothesis import given
from hypothesis import strategies as st
from small_models import OSCILLATOR, WHEELSET, oscillator, small_model, wheelset

from railgrip.base.errors import EstimatorError
from railgrip.estimators.prediction import CasadiPrediction

CASES = {
    "wheelset": (CasadiPrediction(wheelset(), WHEELSET), [22.0, 58.0, 0.36, 0.06], [2e4, 300.0]),
    "oscillator": (CasadiPrediction(oscillator(), OSCILLATOR), [1e-3, 2e-3, 0.1, -0.1], [1e4]),
}


@pytest.mark.parametrize("name", list(CASES))
def test_it_satisfies_the_contract_of_a_prediction(name):
    prediction_contract(*CASES[name])


@pytest.mark.parametrize("name", list(CASES))
@given(data=st.data())
def test_jacobians_are_slopes_everywhere(name, data):
    prediction, middle, held = CASES[name]
    factor = st.floats(0.3, 1.7)
    x = np.array([value * data.draw(factor) for value in middle])
    u = np.array([value * data.draw(factor) for value in held])
    has_jacobians_that_are_slopes(prediction, x, u)


def test_a_parameter_that_is_missing_or_unknown_is_named():
    with pytest.raises(EstimatorError, match="no value for the parameters J, n_units"):
        CasadiPrediction(wheelset(), {k: v for k, v in WHEELSET.items() if k not in ("J", "n_units")})
    with pytest.raises(EstimatorError, match="no parameters r_whel; it has m, J, r_wheel"):
        CasadiPrediction(wheelset(), WHEELSET | {"r_whel": 0.4})


def test_parameters_are_assigned_by_name():
    """The order of the mapping has no effect."""
    x, u = np.array([22.0, 58.0, 0.36, 0.06]), np.array([2e4, 300.0])
    turned = dict(reversed(WHEELSET.items()))
    expected = CASES["wheelset"][0].derivative(x, u)
    assert np.array_equal(CasadiPrediction(wheelset(), turned).derivative(x, u), expected)
    heavier = CasadiPrediction(wheelset(), WHEELSET | {"J": 2 * WHEELSET["J"]}).derivative(x, u)
    # The torque is the same, the inertia doubled: only the spin changes, to a half.
    assert heavier[1] == pytest.approx(expected[1] / 2, rel=1e-14)
    assert np.array_equal(heavier[[0, 2, 3]], expected[[0, 2, 3]])


def test_a_time_dependent_model_is_not_a_prediction():
    clock = small_model("x", "", "", "y", lambda t, x, u, p: [ca.sin(t) - x], lambda t, x, u, p: [x])
    with pytest.raises(EstimatorError, match="depends on time"):
        CasadiPrediction(clock, {})


def test_a_model_whose_functions_do_not_match_its_names_is_refused():
    bad = wheelset()
    bad.states = bad.states[:2]
    with pytest.raises(EstimatorError, match=r"derivative must map \(t, x, u, p\) of sizes \[1, 2, 2, 6\] to 2"):
        CasadiPrediction(bad, WHEELSET)
