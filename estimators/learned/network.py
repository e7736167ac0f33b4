"""A network with one hidden layer of tanh and one logistic output, and its training by Levenberg-Marquardt."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from railgrip.estimators.belief import Array

Bias = Literal["inside", "outside"]

DAMPING: Final = 1e-3
LARGEST_DAMPING: Final = 1e10
"""First and largest damping of a step; steps with more damping have no effect."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Network:
    """mu = 1/(1 + exp(−w2·g − b2)) or, as equation (4) is printed, 1/(1 + exp(−w2·g)) + b2; g = tanh(W1 x + b1).

    Attributes:
        hidden_weights: W1, shape (hidden, inputs).
        hidden_bias: b1, shape (hidden,).
        output_weights: w2, shape (hidden,).
        output_bias: b2.
        bias: Place of b2, inside or outside of the logistic function.
    """

    hidden_weights: Array
    hidden_bias: Array
    output_weights: Array
    output_bias: float
    bias: Bias

    @property
    def size(self) -> int:
        """Number of weights and biases; 37 for 4 inputs and 6 hidden neurons."""
        return self.hidden_weights.size + self.hidden_bias.size + self.output_weights.size + 1

    def __call__(self, x: Array) -> Array:
        """Return the friction for inputs of shape (n, inputs), shape (n,)."""
        hidden = np.tanh(x @ self.hidden_weights.T + self.hidden_bias)
        if self.bias == "inside":
            return _logistic(hidden @ self.output_weights + self.output_bias)
        return _logistic(hidden @ self.output_weights) + self.output_bias


def train(
    x: Array, y: Array, *, hidden: int, bias: Bias, generator: np.random.Generator, decay: float = 0.0, steps: int = 100
) -> Network:
    """Fit a network by least squares from a random start.

    Args:
        x: Inputs, scaled to about [−1, 1], shape (n, inputs).
        y: Friction, shape (n,).
        bias: Place of the output bias.
        decay: Weight of the squared weights relative to the mean squared error; 0 without regularisation.
        steps: Largest number of Levenberg-Marquardt steps.
    """
    inputs = x.shape[1]
    start = np.concatenate(
        [
            generator.standard_normal(hidden * inputs) / np.sqrt(inputs),
            generator.standard_normal(hidden),
            # Small, and around the mean label, because a saturated logistic has no gradient.
            0.1 * generator.standard_normal(hidden) / np.sqrt(hidden),
            [np.log(y.mean() / (1 - y.mean())) if bias == "inside" else y.mean() - 0.5],
        ]
    )
    ridge = np.sqrt(decay * len(y))

    def residuals(p: Array) -> Array:
        error = _unpack(p, inputs, hidden, bias)(x) - y
        return np.concatenate([error, ridge * p]) if decay else error

    def jacobian(p: Array) -> Array:
        data = _jacobian(p, x, hidden, bias)
        return np.vstack([data, ridge * np.eye(p.size)]) if decay else data

    return _unpack(levenberg_marquardt(residuals, jacobian, start, steps), inputs, hidden, bias)


def levenberg_marquardt(
    residuals: Callable[[Array], Array], jacobian: Callable[[Array], Array], start: Array, steps: int
) -> Array:
    """Return parameters that minimise the sum of squared residuals, after `steps` steps or fewer.

    It solves the normal equations: for a few dozen parameters and thousands of residuals, MINPACK's factorisation of
    the whole Jacobian takes ten times as long and finds the same minimum.

    Source of the damping schedule: Hagan and Menhaj, IEEE Transactions on Neural Networks 5 (1994) 989.
    """
    point, damping = start, DAMPING
    error = residuals(point)
    cost = float(error @ error)
    for _ in range(steps):
        slope = jacobian(point)
        curvature, gradient = slope.T @ slope, slope.T @ error
        while damping < LARGEST_DAMPING:
            step = np.linalg.solve(curvature + damping * np.eye(point.size), gradient)
            new_error = residuals(point - step)
            new_cost = float(new_error @ new_error)
            if new_cost < cost:
                break
            damping *= 10
        else:
            return point  # no step reduces the cost
        is_flat = cost - new_cost < 1e-9 * cost
        point, error, cost, damping = point - step, new_error, new_cost, max(damping / 10, 1e-12)
        if is_flat:
            return point
    return point


def _unpack(p: Array, inputs: int, hidden: int, bias: Bias) -> Network:
    cut = hidden * inputs
    return Network(
        hidden_weights=p[:cut].reshape(hidden, inputs),
        hidden_bias=p[cut : cut + hidden],
        output_weights=p[cut + hidden : cut + 2 * hidden],
        output_bias=float(p[-1]),
        bias=bias,
    )


def _jacobian(p: Array, x: Array, hidden: int, bias: Bias) -> Array:
    """Return d(output)/d(parameter), shape (n, parameters)."""
    net = _unpack(p, x.shape[1], hidden, bias)
    g = np.tanh(x @ net.hidden_weights.T + net.hidden_bias)
    inner = g @ net.output_weights + (net.output_bias if bias == "inside" else 0.0)
    out = _logistic(inner)
    slope = out * (1 - out)
    by_bias = slope[:, None] * net.output_weights * (1 - g**2)
    by_weight = (by_bias[:, :, None] * x[:, None, :]).reshape(len(x), -1)
    last = slope if bias == "inside" else np.ones(len(x))
    return np.hstack([by_weight, by_bias, slope[:, None] * g, last[:, None]])


def _logistic(value: Array) -> Array:
    return 1 / (1 + np.exp(-value))
