"""The unscented Kalman filter in numpy: sigma points of the belief are propagated in place of Jacobians."""

from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from railgrip.base.errors import FilterDiverged
from railgrip.estimators.belief import GaussianEstimate, Matrix, Vector, seal
from railgrip.estimators.design import FilterKind
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


def sigma_points(belief: GaussianEstimate, alpha: float, beta: float) -> SigmaPoints:
    """Return the points of the scaled unscented transform with κ = 0: the mean, then 2n points at ±α√n L.

    With α = 1 and β = 0 the mean has no weight; without it the points are those of the cubature rule of degree 3.

    Args:
        belief: Belief of n states.
        alpha: Distance of the points from the mean, over that of the cubature points.
        beta: Knowledge of the fourth moment.

    Sources: Wan and van der Merwe, The Unscented Kalman Filter for Nonlinear Estimation (2000), eq. 15; Arasaratnam and
        Haykin, Cubature Kalman Filters, IEEE Trans. Automatic Control 54 (2009) 1254.

    Raises:
        FilterDiverged: The covariance is not positive definite.
    """
    n = len(belief.mean)
    try:
        factor = np.asarray(np.linalg.cholesky(belief.covariance), dtype=np.float64)
    except np.linalg.LinAlgError:
        raise FilterDiverged("Filter: the covariance of the states is not positive definite.") from None
    scaled, weights = alpha * np.sqrt(n) * np.eye(n), np.full(2 * n, 0.5 / (n * alpha**2))
    units, of_mean, of_covariance = np.vstack([scaled, -scaled]), weights, weights
    if (weight := 1.0 - 1.0 / alpha**2) or beta:
        units = np.vstack([np.zeros(n), units])
        of_mean = np.append(weight, weights)
        of_covariance = np.append(weight + 1.0 - alpha**2 + beta, weights)
    return SigmaPoints(
        mean=belief.mean, units=units, mean_weights=of_mean, covariance_weights=of_covariance, factor=factor
    )


class SigmaPointFilter(GaussianFilter):
    """A filter whose moments come from sigma points; a subclass chooses α and β of `sigma_points`.

    The readings are linearised statistically: the matrix and the extra noise of the linear regression of the output
    over the points make the update of the extended Kalman filter equal to that by moments.

    Source: Särkkä, Bayesian Filtering and Smoothing (2013), §5.5 and §5.6; García-Fernández et al., Posterior
    Linearization Filter, IEEE Trans. Signal Processing 63 (2015) 5561, for the regression.
    """

    alpha: ClassVar[float]
    beta: ClassVar[float]

    def predict(self, prior: GaussianEstimate, inputs: Vector) -> GaussianEstimate:
        """Return the estimate one period later, before the readings."""
        free, sigma = self.free(inputs), sigma_points(prior, self.alpha, self.beta)
        moved = self.advance(sigma.points, inputs, free)
        mean = sigma.mean_weights @ moved
        deviations = moved - mean
        covariance = (deviations.T * sigma.covariance_weights) @ deviations
        covariance += self.design.process_noise * np.outer(free, free)
        return seal(mean, 0.5 * (covariance + covariance.T))

    def innovation(self, forecast: GaussianEstimate, inputs: Vector, readings: Vector) -> Innovation:
        """Return the innovation of the readings against `forecast`, without missing readings and outliers."""
        sigma = sigma_points(forecast, self.alpha, self.beta)
        outputs = np.array([self.prediction.output(point, inputs) for point in sigma.points])
        expected = sigma.mean_weights @ outputs
        weighted = (outputs - expected).T * sigma.covariance_weights
        # Regression on the units. The solver of scipy for triangular matrices starts threads, which take longer.
        half = (weighted @ sigma.units).T
        jacobian = np.asarray(np.linalg.solve(sigma.factor.T, half).T, dtype=np.float64)
        covariance = weighted @ (outputs - expected) + self.design.reading_noise
        noise = covariance - half.T @ half
        return self.select(readings, expected, jacobian, noise, covariance)


class UnscentedKalmanFilter(SigmaPointFilter, FilterKind):
    """Sigma-point filter with `ALPHA` and `BETA`."""

    alpha, beta = ALPHA, BETA
