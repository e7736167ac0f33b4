"""Rao-Blackwellised particle filter: some states are sampled, the others have a Kalman filter for each sample."""

from collections.abc import Sequence
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import EstimatorError, FilterDiverged
from railgrip.estimators.belief import GaussianEstimate, Matrix, Vector, seal
from railgrip.estimators.design import FilterContext, FilterKind
from railgrip.estimators.ekf import ExtendedKalmanFilter, NumpyFilter
from railgrip.estimators.filters.interacting import combine, log_likelihood

PARTICLES: Final = 12
"""Number of particles of a scenario; every one costs as much as an extended Kalman filter."""

RESAMPLE_BELOW: Final = 0.5
"""Effective number of particles over their number below which they are drawn again."""

SEED: Final = 1


def systematic_resample(weights: Vector, uniform: float) -> NDArray[np.intp]:
    """Return the indices of particles that are kept, shape (k,), by one draw in [0, 1).

    Source: Kitagawa, Monte Carlo Filter and Smoother, J. Computational and Graphical Statistics 5 (1996) 1.
    """
    count = len(weights)
    ends = np.cumsum(weights)
    # Rounding must not leave the last position without a particle.
    return np.minimum(np.searchsorted(ends, (np.arange(count) + uniform) / count, side="right"), count - 1)


class ParticleFilter(NumpyFilter, FilterKind):
    """Particles of states that are random walks, each with an extended Kalman filter for all other states.

    A particle's filter knows its sampled states, so that they have neither variance nor gain. Its weight is multiplied
    by the likelihood of the readings. Gated states do not move.

    Args:
        filter_: Filter of all states; its process noise is diagonal.
        sampled: Indices of the sampled states, with a derivative of zero.
        first: First belief; the sampled states are drawn from their variances.
        count: Number of particles.
        seed: Of the draws.

    Attributes:
        mean, covariance, inputs, readings, selection: As of `railgrip.estimators.ekf.NumpyFilter`.
        squared_innovation: Normalised innovation squared of the last step, the mean over the particles.
        weights: Of the particles after the last step, shape (count,).

    Raises:
        EstimatorError: Particles or sampled states are missing.

    Source: Schön, Gustafsson, Nordlund, Marginalized Particle Filters for Mixed Linear/Nonlinear State-Space Models,
    IEEE Trans. Signal Processing 53 (2005) 2279.
    """

    def __init__(
        self, filter_: ExtendedKalmanFilter, sampled: Sequence[int], first: GaussianEstimate, count: int, seed: int
    ) -> None:
        if not sampled or count < 1:
            raise EstimatorError(f"ParticleFilter: needs sampled states and particles, got {len(sampled)} and {count}.")
        super().__init__(filter_, first)
        self._kalman, self._sampled, self._random = filter_, np.array(sampled), np.random.default_rng(seed)
        noise = np.diagonal(filter_.design.process_noise).copy()
        self._deviation = np.sqrt(noise[self._sampled])
        covariance = _without(first.covariance, self._sampled)
        draws = self._random.normal(size=(count, len(sampled))) * first.deviation[self._sampled]
        self._beliefs = [seal(_moved(first.mean, self._sampled, draw), covariance.copy()) for draw in draws]
        self.weights = np.full(count, 1.0 / count)

    @classmethod
    def of_context(cls, context: FilterContext) -> Self:
        """Return the filter of a scenario: pad friction is sampled, which multiplies the pad force."""
        filter_ = ExtendedKalmanFilter.without_estimate(context)
        sampled = [k for k, name in enumerate(context.prediction.states) if name.startswith("pad_friction")]
        return cls(filter_, sampled, filter_.start(context.mean, context.covariance), PARTICLES, SEED)

    def advance(self) -> None:
        """Move the belief on by one period, from the arrays `inputs` and `readings`.

        Raises:
            FilterDiverged: No particle explains the readings, or a filter diverged.
        """
        sampled, steps = self._sampled, self._deviation * self._kalman.free(self.inputs)[self._sampled]
        logarithms, nis = np.log(np.maximum(self.weights, np.finfo(float).tiny)), 0.0
        beliefs, rows = list[GaussianEstimate](), list[NDArray[np.intp]]()
        for k, belief in enumerate(self._beliefs):
            forecast = self._kalman.predict(belief, self.inputs)
            walked = _moved(forecast.mean, sampled, steps * self._random.normal(size=len(sampled)))
            forecast = seal(walked, _without(forecast.covariance, sampled))
            innovation = self._kalman.innovation(forecast, self.inputs, self.readings)
            beliefs.append(self._kalman.condition(forecast, self.inputs, innovation))
            logarithms[k] += log_likelihood(innovation)
            nis += self.weights[k] * innovation.nis
            rows.append(innovation.rows)
        weights = np.exp(logarithms - logarithms.max())
        if not np.isfinite(weights).all():
            raise FilterDiverged("Filter: no particle explains the readings.")
        self._beliefs, self.weights = beliefs, weights / weights.sum()
        self._publish(combine(self._beliefs, self.weights), rows[0], nis)
        self._resample()

    def _resample(self) -> None:
        count = len(self.weights)
        if 1.0 / np.sum(self.weights**2) < RESAMPLE_BELOW * count:
            kept = systematic_resample(self.weights, self._random.uniform())
            self._beliefs = [self._beliefs[k] for k in kept]
            self.weights = np.full(count, 1.0 / count)


def _without(covariance: Matrix, known: NDArray[np.intp]) -> Matrix:
    """Return a covariance in which some states are known."""
    result = covariance.copy()
    result[known] = 0.0
    result[:, known] = 0.0
    return result


def _moved(mean: Vector, places: NDArray[np.intp], steps: Vector) -> Vector:
    result = mean.copy()
    result[places] += steps
    return result
