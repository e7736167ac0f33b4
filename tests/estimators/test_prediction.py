import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_models import OSCILLATOR, WHEELSET, Name, SmallModel, oscillator, small_model, wheelset

from estimators.errors import EstimatorError
from estimators.prediction import CasadiPrediction, Prediction


class Pendulum:
    """A prediction in plain numpy: nothing but the protocol."""

    states = ("angle", "rate")
    inputs = ("torque",)
    outputs = ("angle", "acceleration")

    def derivative(self, x, u):
        return np.array([x[1], -9.81 * np.sin(x[0]) + u[0]])

    def output(self, x, u):
        return np.array([x[0], -9.81 * np.sin(x[0]) + u[0]])

    def derivative_jacobian(self, x, u):
        return np.array([[0.0, 1.0], [-9.81 * np.cos(x[0]), 0.0]])

    def output_jacobian(self, x, u):
        return np.array([[1.0, 0.0], [-9.81 * np.cos(x[0]), 0.0]])


CASES = {
    "wheelset": (CasadiPrediction(wheelset(), WHEELSET), [22.0, 58.0, 0.36, 0.06], [2e4, 300.0]),
    "oscillator": (CasadiPrediction(oscillator(), OSCILLATOR), [1e-3, 2e-3, 0.1, -0.1], [1e4]),
    "pendulum": (Pendulum(), [0.3, -0.2], [1.0]),
}


@pytest.fixture(params=list(CASES))
def case(request):
    return CASES[request.param]


def test_it_is_a_prediction(case):
    prediction, x, u = case
    assert isinstance(prediction, Prediction)
    assert (len(x), len(u)) == (len(prediction.states), len(prediction.inputs))


def test_shapes_are_those_of_the_names(case):
    prediction, x, u = case[0], np.array(case[1]), np.array(case[2])
    n, m = len(prediction.states), len(prediction.outputs)
    assert prediction.derivative(x, u).shape == (n,)
    assert prediction.output(x, u).shape == (m,)
    assert prediction.derivative_jacobian(x, u).shape == (n, n)
    assert prediction.output_jacobian(x, u).shape == (m, n)


def test_what_was_returned_stays_what_it_was(case):
    """The buffers inside are not handed out."""
    prediction, x, u = case[0], np.array(case[1]), np.array(case[2])
    for ask in (
        prediction.derivative,
        prediction.output,
        prediction.derivative_jacobian,
        prediction.output_jacobian,
    ):
        first = ask(x, u)
        before = first.copy()
        ask(x * 1.1, u * 0.9)
        assert np.array_equal(first, before)
        assert np.array_equal(ask(x, u), before)


@pytest.mark.parametrize("name", list(CASES))
@given(data=st.data())
@settings(max_examples=25, deadline=None)
def test_jacobians_are_the_slopes_of_the_functions(name, data):
    prediction, middle, held = CASES[name]
    factor = st.floats(0.3, 1.7)
    x = np.array([value * data.draw(factor) for value in middle])
    u = np.array([value * data.draw(factor) for value in held])
    for function, jacobian in (
        (prediction.derivative, prediction.derivative_jacobian(x, u)),
        (prediction.output, prediction.output_jacobian(x, u)),
    ):
        size = np.abs(function(x, u))
        for j in range(x.size):
            step = 1e-5 * max(abs(x[j]), 1e-3)
            nudge = np.zeros(x.size)
            nudge[j] = step
            slope = (function(x + nudge, u) - function(x - nudge, u)) / (2.0 * step)
            # Central differences: rounding of terms up to 1000 times the value; h²/6 of a third derivative.
            rounding = 1e3 * 2e-16 * (size + np.abs(jacobian[:, j] * x[j])) / step
            assert np.all(np.abs(jacobian[:, j] - slope) <= rounding + 1e-8 * np.abs(slope) + 1e-7)


def test_a_parameter_that_is_missing_or_unknown_is_named():
    with pytest.raises(EstimatorError, match="no value for the parameters J, n_units"):
        CasadiPrediction(wheelset(), {k: v for k, v in WHEELSET.items() if k not in ("J", "n_units")})
    with pytest.raises(EstimatorError, match="no parameters r_whel; it has m, J, r_wheel"):
        CasadiPrediction(wheelset(), WHEELSET | {"r_whel": 0.4})


def test_parameters_go_where_their_names_say():
    """Order of the mapping does not matter, values do."""
    x, u = np.array([22.0, 58.0, 0.36, 0.06]), np.array([2e4, 300.0])
    turned = dict(reversed(WHEELSET.items()))
    expected = CASES["wheelset"][0].derivative(x, u)
    assert np.array_equal(CasadiPrediction(wheelset(), turned).derivative(x, u), expected)
    heavier = CasadiPrediction(wheelset(), WHEELSET | {"J": 2 * WHEELSET["J"]}).derivative(x, u)
    # The torque is the same, the inertia twice: half the spin, and nothing else.
    assert heavier[1] == pytest.approx(expected[1] / 2, rel=1e-14)
    assert np.array_equal(heavier[[0, 2, 3]], expected[[0, 2, 3]])


def test_a_model_that_changes_with_time_is_no_prediction():
    clock = small_model("x", "", "", "y", lambda t, x, u, p: [ca.sin(t) - x], lambda t, x, u, p: [x])
    with pytest.raises(EstimatorError, match="depends on time"):
        CasadiPrediction(clock, {})


def test_a_model_whose_functions_do_not_fit_its_names_is_refused():
    good = wheelset()
    names = (Name("v"), Name("w"))
    bad = SmallModel(names, good.inputs, good.parameters, good.outputs, good.derivative, good.output)
    with pytest.raises(
        EstimatorError, match=r"derivative must map \(t, x, u, p\) of sizes \[1, 2, 2, 6\] to 2"
    ):
        CasadiPrediction(bad, WHEELSET)
