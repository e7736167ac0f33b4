"""Interacting multiple models (IMM): filters over one prediction, weighted by the likelihood of the readings."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Self

import numpy as np
from numpy.typing import ArrayLike

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import GaussianEstimate, Matrix, Vector
from railgrip.estimators.design import FilterContext, FilterKind
from railgrip.estimators.ekf import ExtendedKalmanFilter, GaussianFilter, Innovation, NumpyFilter

NOISE_FACTORS: Final = (1.0 / 9.0, 9.0)
"""Process noise of adhesion in each model over that of the filter: a third and three times the standard deviation, the
range within which noises.toml found braking distances insensitive."""

DWELL: Final = 1.0
"""Mean time in a model [s]: adhesion changes within about a second where rail conditions meet."""


class InteractingFilters(NumpyFilter, FilterKind):
    """IMM estimator of a loop: mixes the beliefs of its filters, steps each of them, and combines the results.

    A reading that one filter rejects as an outlier is used by none, so that likelihoods compare the same readings.

    Args:
        filters: Filters with the same states, inputs and readings.
        transition: Probability of the change from filter i to filter j in one period, shape (k, k), rows sum to 1.
        probabilities: Of the filters at first, shape (k,).
        first: Belief at first.

    Attributes:
        mean, covariance, inputs, readings, selection: As of `railgrip.estimators.ekf.NumpyFilter`.
        squared_innovation: Normalised innovation squared of the last step, the mean over the filters.
        probabilities: Of the filters after the last step, shape (k,).

    Raises:
        EstimatorError: Shapes do not fit, or probabilities do not sum to 1.

    Source: Blom and Bar-Shalom, The Interacting Multiple Model Algorithm for Systems with Markovian Switching
    Coefficients, IEEE Trans. Automatic Control 33 (1988) 780.
    """

    def __init__(
        self,
        filters: Sequence[GaussianFilter],
        transition: ArrayLike,
        probabilities: ArrayLike,
        first: GaussianEstimate,
    ) -> None:
        self._filters = tuple(filters)
        self._transition = np.array(transition, dtype=np.float64)
        self.probabilities = np.array(probabilities, dtype=np.float64)
        count = len(self._filters)
        if self._transition.shape != (count, count) or self.probabilities.shape != (count,):
            raise EstimatorError(
                f"InteractingFilters: {count} filters require probabilities of shape ({count},) and a transition of "
                f"shape ({count}, {count}), got {self.probabilities.shape} and {self._transition.shape}."
            )
        if not np.allclose([*self._transition.sum(axis=1), self.probabilities.sum()], 1.0):
            raise EstimatorError("InteractingFilters: probabilities must sum to 1, in every row of the transition too.")
        super().__init__(self._filters[0], first)
        self._beliefs = [first] * count

    @classmethod
    def of_context(cls, context: FilterContext) -> Self:
        """Return the filter of a scenario: models that differ by the process noise of adhesion, `NOISE_FACTORS`.

        The predictions have no creep curve, adhesion is a random walk in them; its noise is what can differ.
        """
        is_adhesion = np.array([name.startswith("group_adhesion") for name in context.prediction.states])
        noises = [np.where(is_adhesion, factor, 1.0) * context.process_noise for factor in NOISE_FACTORS]
        filters = [ExtendedKalmanFilter.without_estimate(replace(context, process_noise=noise)) for noise in noises]
        count, change = len(filters), context.period / DWELL
        transition = np.full((count, count), change / (count - 1))
        np.fill_diagonal(transition, 1.0 - change)
        first = filters[0].start(context.mean, context.covariance)
        return cls(filters, transition, np.full(count, 1.0 / count), first)

    def advance(self) -> None:
        """Move the belief on by one period, from the arrays `inputs` and `readings`.

        Raises:
            FilterDiverged: A filter diverged; the estimate is unchanged.
        """
        joint = self._transition * self.probabilities[:, np.newaxis]
        expected = joint.sum(axis=0)
        mixed = [combine(self._beliefs, weights) for weights in (joint / expected).T]
        pairs = list(zip(self._filters, mixed, strict=True))
        forecasts = [filter_.predict(belief, self.inputs) for filter_, belief in pairs]
        innovations = self._innovations(forecasts)
        self._beliefs = [
            filter_.condition(forecast, self.inputs, innovation)
            for filter_, forecast, innovation in zip(self._filters, forecasts, innovations, strict=True)
        ]
        logarithms = np.log(expected) + [log_likelihood(innovation) for innovation in innovations]
        weights = np.exp(logarithms - logarithms.max())
        self.probabilities = weights / weights.sum()
        nis = float(self.probabilities @ [innovation.nis for innovation in innovations])
        self._publish(combine(self._beliefs, self.probabilities), innovations[0].rows, nis)

    def _innovations(self, forecasts: Sequence[GaussianEstimate]) -> list[Innovation]:
        """Return the innovation of each filter, over the readings that all filters accept."""
        readings = self.readings
        pairs = list(zip(self._filters, forecasts, strict=True))
        innovations = [filter_.innovation(forecast, self.inputs, readings) for filter_, forecast in pairs]
        common = set(innovations[0].rows.tolist()).intersection(*(one.rows.tolist() for one in innovations))
        if all(one.rows.size == len(common) for one in innovations):
            return innovations
        accepted = np.full(readings.size, np.nan)
        accepted[sorted(common)] = readings[sorted(common)]
        return [filter_.innovation(forecast, self.inputs, accepted) for filter_, forecast in pairs]


def combine(beliefs: Sequence[GaussianEstimate], weights: Vector) -> GaussianEstimate:
    """Return the Gaussian belief with the moments of a mixture of Gaussian beliefs with weights of shape (k,)."""
    means = np.array([belief.mean for belief in beliefs])
    mean = weights @ means
    deviations = means - mean
    within: Matrix = np.einsum("i,ijk->jk", weights, np.array([belief.covariance for belief in beliefs]))
    return replace(beliefs[0], mean=mean, covariance=within + (deviations.T * weights) @ deviations)


def log_likelihood(innovation: Innovation) -> float:
    """Return the logarithm of the density of the innovation, without the constant that all filters share."""
    if innovation.rows.size == 0:
        return 0.0
    return -0.5 * (innovation.nis + float(np.linalg.slogdet(innovation.covariance)[1]))
