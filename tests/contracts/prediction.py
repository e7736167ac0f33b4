"""The contract of every prediction, whatever its origin; the tests of each prediction call `prediction_contract`."""

import numpy as np

from railgrip.estimators.prediction import Prediction


def prediction_contract(prediction, x, u):
    """Check the contract of `railgrip.estimators.prediction.Prediction` at a point in the middle of its range."""
    assert isinstance(prediction, Prediction)
    x, u = np.asarray(x, dtype=float), np.asarray(u, dtype=float)
    assert (x.shape, u.shape) == ((len(prediction.states),), (len(prediction.inputs),))
    has_the_shapes_of_its_names(prediction, x, u)
    hands_out_arrays_to_keep(prediction, x, u)
    has_jacobians_that_are_slopes(prediction, x, u)


def has_the_shapes_of_its_names(prediction, x, u):
    n, m = len(prediction.states), len(prediction.outputs)
    assert prediction.derivative(x, u).shape == (n,)
    assert prediction.output(x, u).shape == (m,)
    assert prediction.derivative_jacobian(x, u).shape == (n, n)
    assert prediction.output_jacobian(x, u).shape == (m, n)


def hands_out_arrays_to_keep(prediction, x, u):
    """A later call does not change an earlier result, and equal arguments give equal results."""
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


def has_jacobians_that_are_slopes(prediction, x, u):
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
