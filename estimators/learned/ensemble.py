"""One estimator for all speeds: networks trained on resampled runs, with an interval that was right nine times in ten.

The interval is conformal: each training run is estimated by the networks that did not see it, and the half-width, in
units of the networks' disagreement, is the quantile of those errors. It promises coverage for runs like those of the
training; on others its coverage is measured, not promised.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.learned.network import Network, train

Array = NDArray[np.float64]

LEAST_SPREAD: Final = 0.01
"""Friction; disagreement below what a tribometer resolves says nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimates:
    """Friction with a 90 % interval, each of shape (n,)."""

    friction: Array
    lower: Array
    upper: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Ensemble:
    """Networks behind one standardisation.

    Attributes:
        centre, spread: Of the features in training, shape (features,).
        networks: Their mean is the estimate.
        half_width: Of the interval, in units of √(disagreement² + LEAST_SPREAD²).
    """

    centre: Array
    spread: Array
    networks: tuple[Network, ...]
    half_width: float

    def scaled(self, features: Array) -> Array:
        """Return standardised features, clipped to ±4 standard deviations: nothing is known beyond."""
        return np.clip((features - self.centre) / self.spread, -4, 4) / 2

    def __call__(self, features: Array) -> Estimates:
        """Return estimates for features of shape (n, features)."""
        each = np.stack([network(self.scaled(features)) for network in self.networks])
        friction = each.mean(axis=0)
        half = self.half_width * _disagreement(each)
        return Estimates(
            friction=friction, lower=np.maximum(friction - half, 0.0), upper=np.minimum(friction + half, 1.0)
        )


def fit(
    features: Array,
    friction: Array,
    run: NDArray[np.int64],
    *,
    generator: np.random.Generator,
    members: int = 20,
    hidden: int = 6,
    decay: float = 1e-4,
    steps: int = 40,
    confidence: float = 0.9,
) -> Ensemble:
    """Train an ensemble, each member on runs drawn with replacement.

    Args:
        features: Shape (n, features).
        friction: Labels, shape (n,).
        run: Number of the run each sample belongs to, shape (n,): samples of one run are never split.
        generator: Draws runs and starts.
        decay: Weight of the squared weights, see `network.train`.
        confidence: Of the interval.
    """
    centre, spread = features.mean(axis=0), features.std(axis=0) + 1e-12
    bare = Ensemble(centre=centre, spread=spread, networks=(), half_width=0.0)
    x, runs = bare.scaled(features), np.unique(run)
    networks: list[Network] = []
    said = np.full((members, len(friction)), np.nan)
    for k, draw in enumerate(generator.spawn(members)):
        drawn = draw.choice(runs, runs.size)
        rows = np.concatenate([np.flatnonzero(run == one) for one in drawn])
        network = train(x[rows], friction[rows], hidden=hidden, bias="inside", generator=draw, decay=decay, steps=steps)
        networks.append(network)
        out = ~np.isin(run, drawn)
        said[k, out] = network(x[out])
    judged = (~np.isnan(said)).sum(axis=0) >= 3  # fewer say nothing about disagreement
    mean = np.nanmean(said[:, judged], axis=0)
    ratio = np.abs(mean - friction[judged]) / np.sqrt(np.nanvar(said[:, judged], axis=0) + LEAST_SPREAD**2)
    return Ensemble(
        centre=centre, spread=spread, networks=tuple(networks), half_width=float(np.quantile(ratio, confidence))
    )


def _disagreement(each: Array) -> Array:
    return np.sqrt(each.var(axis=0) + LEAST_SPREAD**2)
