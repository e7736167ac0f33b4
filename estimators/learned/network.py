"""Networks with one hidden layer of tanh and one logistic output, their training, and an ensemble for all speeds.

The ensemble is trained on resampled runs. Where a simulation provides the slope of the creep curve of every training
run, networks estimate that slope, because motions of wheelsets below saturation depend on it, and a second stage maps
it to friction. Without slopes, the networks estimate friction directly.

The interval is conformal: each training run is estimated by the networks not trained on it, and the half-width, in
units of the networks' disagreement, is the quantile of these errors. The coverage is guaranteed for runs like those of
the training only; on others it must be measured.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import Array
from railgrip.estimators.learned.preprocessing import StoredArray

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

    hidden_weights: StoredArray
    hidden_bias: StoredArray
    output_weights: StoredArray
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


MIN_DEVIATION: Final = 0.03
"""Friction added to the disagreement: even if the networks agree, friction varies at the same slope."""
QUANTILE: Final = 1.6449
"""Standard deviations from the mean of a Gaussian to either end of its 90 % interval."""
SLOPE_CENTRE: Final = 0.3
SLOPE_HALF: Final = 0.5
"""Slopes from 0 to 0.8, clean contacts to the softest films, are scaled to about [−1, 1] for the second stage."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionEstimates:
    """Friction with a 90 % interval, each of shape (n,)."""

    friction: Array
    lower: Array
    upper: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Ensemble:
    """Networks with a common standardisation of their inputs.

    Attributes:
        centre, spread: Mean and standard deviation of the features in training, shape (features,).
        networks: Networks from features to slope, or to friction without a second stage.
        second: Networks from slope to friction, whose mean is used; empty without a second stage.
        half_width: Half width of the interval, in units of √(disagreement² + LEAST_SPREAD²).
    """

    centre: StoredArray
    spread: StoredArray
    networks: tuple[Network, ...]
    second: tuple[Network, ...]
    half_width: float

    def standardise(self, features: Array) -> Array:
        """Return standardised features, clipped to ±4 standard deviations, about the range of the training data."""
        return np.clip((features - self.centre) / self.spread, -4, 4) / 2

    def friction_of(self, first: Array) -> Array:
        """Return the friction for outputs of the first stage, any shape."""
        if not self.second:
            return first
        flat = ((first.ravel() - SLOPE_CENTRE) / SLOPE_HALF)[:, None]
        return np.mean([network(flat) for network in self.second], axis=0).reshape(first.shape)

    def __call__(self, features: Array) -> FrictionEstimates:
        """Return estimates for features of shape (n, features)."""
        first = np.stack([network(self.standardise(features)) for network in self.networks])
        friction = self.friction_of(first.mean(axis=0))
        half = self.half_width * np.sqrt(self.friction_of(first).var(axis=0) + MIN_DEVIATION**2)
        return FrictionEstimates(
            friction=friction, lower=np.maximum(friction - half, 0.0), upper=np.minimum(friction + half, 1.0)
        )


def fit(
    features: Array, friction: Array, run: NDArray[np.int64], *, generator: np.random.Generator,
    slope: Array | None = None, members: int = 20, hidden: int = 4, decay: float = 1e-4, steps: int = 40,
    confidence: float = 0.9,
) -> Ensemble:  # fmt: skip
    """Train an ensemble, each member on runs drawn with replacement.

    Args:
        features: Shape (n, features).
        friction: Labels, shape (n,).
        run: Number of the run of each sample, shape (n,): samples of one run are never split.
        slope: Slope of the creep curve, shape (n,), if it is known; adds the second stage.

    Raises:
        EstimatorError: There are too few runs or networks for an interval.
    """
    centre, spread = features.mean(axis=0), features.std(axis=0) + 1e-12
    ensemble = Ensemble(centre=centre, spread=spread, networks=(), second=(), half_width=0.0)
    x, runs, target = ensemble.standardise(features), np.unique(run), friction if slope is None else slope
    networks: list[Network] = []
    opinions = np.full((members, len(friction)), np.nan)
    for k, draw in enumerate(generator.spawn(members)):
        resample = draw.choice(runs, runs.size)
        rows = np.concatenate([np.flatnonzero(run == sample) for sample in resample])
        network = train(x[rows], target[rows], hidden=hidden, bias="inside", generator=draw, decay=decay, steps=steps)
        networks.append(network)
        out = ~np.isin(run, resample)
        opinions[k, out] = network(x[out])
    ensemble = replace(ensemble, networks=tuple(networks))
    # Only estimates of runs outside of the training are representative of new runs.
    countable = (~np.isnan(opinions)).sum(axis=0) >= FEWEST_OPINIONS
    if not countable.any():
        raise EstimatorError(
            f"an interval needs a run outside of the training of {FEWEST_OPINIONS} of the {members} networks, and none "
            f"of the {runs.size} runs is; train on more runs or more networks."
        )
    mean = np.nanmean(opinions[:, countable], axis=0)
    if slope is not None:
        inner = ((mean - SLOPE_CENTRE) / SLOPE_HALF)[:, None]
        ensemble = replace(
            ensemble,
            second=tuple(
                train(inner, friction[countable], hidden=3, bias="inside", generator=draw, decay=1e-5, steps=60)
                for draw in generator.spawn(3)
            ),
        )
    error = np.abs(ensemble.friction_of(mean) - friction[countable])
    disagreement = np.nanvar(ensemble.friction_of(opinions[:, countable]), axis=0)
    ratio = error / np.sqrt(disagreement + MIN_DEVIATION**2)
    return replace(ensemble, half_width=float(np.quantile(ratio, confidence)))


FEWEST_OPINIONS: Final = 3
"""Number of networks not trained on a run that are required to measure their disagreement on it."""
