"""One estimator for all speeds: networks trained on resampled runs, with a 90 % interval.

Where a simulation provides the slope of the creep curve of every training run, networks estimate that slope, because
motions of wheelsets below saturation depend on it, and a second stage maps it to friction. Without slopes, the networks
estimate friction directly.

The interval is conformal: each training run is estimated by the networks not trained on it, and the half-width, in
units of the networks' disagreement, is the quantile of these errors. The coverage is guaranteed for runs like those of
the training only; on others it must be measured.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import Array
from railgrip.estimators.learned.network import Network, train

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

    centre: Array
    spread: Array
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
