"""Sigma-point filters: unscented and cubature, which propagate points of the belief in place of Jacobians."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Final

import numpy as np

from railgrip.base.errors import FilterDiverged
from railgrip.estimators.belief import GaussianEstimate, Matrix, Vector, seal
from railgrip.estimators.ekf import GaussianFilter, Innovation

ALPHA: Final = 0.1
"""Distance of the unscented points from the mean over that of the cubature points.

Wan and van der Merwe take 1e-4 to 1. The weight of the central point is 1 − 1/ALPHA²: −99 here loses two digits of
sixteen, 1e-3 would lose six.
"""

BETA: Final = 2.0
"""Knowledge of the fourth moment: 2 is exact for a Gaussian belief."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SigmaPoints:
    """Points that represent a belief.

    Attributes:
        mean: Mean of the belief, shape (n,).
        units: Points in standard normal coordinates, L⁻¹(point − mean), shape (p, n).
        mean_weights: Weights of the points in a mean, shape (p,), with a sum of 1.
        covariance_weights: Weights of the points in a covariance, shape (p,).
        factor: Lower Cholesky factor L of the covariance, shape (n, n).
    """

    mean: Vector
    units: Matrix
    mean_weights: Vector
    covariance_weights: Vector
    factor: Matrix

    @property
    def points(self) -> Matrix:
        """The points, shape (p, n)."""
        return self.mean + self.units @ self.factor.T


def unscented_points(belief: GaussianEstimate) -> SigmaPoints:
    """Return the 2n + 1 points of the scaled unscented transform with κ = 0, the mean first.

    Source: Wan and van der Merwe, The Unscented Kalman Filter for Nonlinear Estimation (2000), eq. 15.

    Raises:
        FilterDiverged: The covariance is not positive definite.
    """
    n = len(belief.mean)
    factor = _factor(belief)
    scaled = ALPHA * np.sqrt(n) * np.eye(n)
    units = np.vstack([np.zeros(n), scaled, -scaled])
    mean_weights = np.full(2 * n + 1, 0.5 / (n * ALPHA**2))
    mean_weights[0] = 1.0 - 1.0 / ALPHA**2
    covariance_weights = mean_weights.copy()
    covariance_weights[0] += 1.0 - ALPHA**2 + BETA
    return SigmaPoints(
        mean=belief.mean,
        units=units,
        mean_weights=mean_weights,
        covariance_weights=covariance_weights,
        factor=factor,
    )


def cubature_points(belief: GaussianEstimate) -> SigmaPoints:
    """Return the 2n points of the spherical-radial cubature rule of degree 3.

    Source: Arasaratnam and Haykin, Cubature Kalman Filters, IEEE Trans. Automatic Control 54 (2009) 1254.

    Raises:
        FilterDiverged: The covariance is not positive definite.
    """
    n, factor = len(belief.mean), _factor(belief)
    scaled = np.sqrt(n) * np.eye(n)
    units = np.vstack([scaled, -scaled])
    weights = np.full(2 * n, 0.5 / n)
    return SigmaPoints(
        mean=belief.mean,
        units=units,
        mean_weights=weights,
        covariance_weights=weights,
        factor=factor,
    )


class SigmaPointFilter(GaussianFilter):
    """A filter whose moments come from sigma points; a subclass chooses the points.

    The readings are linearised statistically: the matrix and the extra noise of the linear regression of the output
    over the points make the update of the extended Kalman filter equal to that by moments.

    Source: Särkkä, Bayesian Filtering and Smoothing (2013), §5.5 and §5.6; García-Fernández et al., Posterior
    Linearization Filter, IEEE Trans. Signal Processing 63 (2015) 5561, for the regression.
    """

    @staticmethod
    @abstractmethod
    def points_of(belief: GaussianEstimate) -> SigmaPoints:
        """Return the points of a belief."""

    def predict(self, prior: GaussianEstimate, inputs: Vector) -> GaussianEstimate:
        """Return the estimate one period later, before the readings."""
        free, sigma = self.free(inputs), self.points_of(prior)
        moved = self.advance(sigma.points, inputs, free)
        mean = sigma.mean_weights @ moved
        deviations = moved - mean
        covariance = (deviations.T * sigma.covariance_weights) @ deviations
        covariance += self.design.process_noise * np.outer(free, free)
        return seal(mean, 0.5 * (covariance + covariance.T))

    def innovation(self, forecast: GaussianEstimate, inputs: Vector, readings: Vector) -> Innovation:
        """Return the innovation of the readings against `forecast`, without missing readings and outliers."""
        sigma = self.points_of(forecast)
        outputs = np.array([self.prediction.output(point, inputs) for point in sigma.points])
        expected = sigma.mean_weights @ outputs
        weighted = (outputs - expected).T * sigma.covariance_weights
        # Regression on the units. The solver of scipy for triangular matrices starts threads, which take longer.
        half = (weighted @ sigma.units).T
        jacobian = np.asarray(np.linalg.solve(sigma.factor.T, half).T, dtype=np.float64)
        covariance = weighted @ (outputs - expected) + self.design.reading_noise
        noise = covariance - half.T @ half
        return self.select(readings, expected, jacobian, noise, covariance)


class UnscentedKalmanFilter(SigmaPointFilter):
    """Sigma-point filter with `unscented_points`."""

    points_of = staticmethod(unscented_points)


class CubatureKalmanFilter(SigmaPointFilter):
    """Sigma-point filter with `cubature_points`."""

    points_of = staticmethod(cubature_points)


def _factor(belief: GaussianEstimate) -> Matrix:
    """Return the lower Cholesky factor of the covariance, shape (n, n)."""
    try:
        return np.asarray(np.linalg.cholesky(belief.covariance), dtype=np.float64)
    except np.linalg.LinAlgError:
        raise FilterDiverged("Filter: the covariance of the states is not positive definite.") from None
