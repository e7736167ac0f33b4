"""A Gaussian estimate, mean and covariance, and the discretisation of a prediction over one period of a filter.

Both filters use the following, at order p = 4 unless a filter requests order 1:

Mean
    Classical Runge–Kutta of order 4 (RK4), or forward Euler, one step per period with the inputs held.
Transition matrix
    Φ = Σ_{k=0..p} (TA)ᵏ/k! with A = ∂f/∂x at the prior mean. This is the derivative of the map of the mean when f
    is linear in x, so mean and covariance of the linear case follow the same map, and
    ‖Φ − exp(TA)‖ ≤ ‖TA‖ᵖ⁺¹/(p+1)!·exp(‖TA‖) in any operator norm (the Taylor remainder).
Process noise
    A density q in (unit of the state)²/s; one period adds q·T, all at its end. The density does not depend on the
    period: the variance of a random walk grows by q·t for any period.

Why order 4: the fastest modes of the train predictions are 6–10 Hz (bounce and pitch on the primary suspension,
|λ| ≈ 60 1/s), so |λT| ≈ 0.06 at 1 ms. The relative error of such a mode per step is |λT|³/6 ≈ 4e-5 for the explicit
midpoint rule and |λT|⁵/120 ≈ 6e-9 for RK4. Errors of `TrainPrediction` over 0.5 s from a deflection of 2 mm, relative
to the states' typical size: 6e-4 for the midpoint rule and 8e-8 for RK4; the error of Φ is 4e-9, or 3e-5 with two
terms. The price is two evaluations of f of 0.1 µs and two sparse products. Order 1 is for filters that were published
with it: Φ = I + TA and a mean to match.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from railgrip.base.arrays import Array as Array
from railgrip.base.arrays import Matrix as Matrix
from railgrip.base.arrays import Vector as Vector
from railgrip.base.errors import EstimatorError


@dataclass(frozen=True, slots=True, kw_only=True)
class GaussianEstimate:
    """Gaussian estimate of the vehicle's state at one instant.

    Attributes:
        mean: Shape (n,); order and units are those of the prediction's `states`.
        covariance: Covariance of the error of `mean`, shape (n, n), symmetric positive definite.

    Raises:
        EstimatorError: The shapes do not match.
    """

    mean: Vector
    covariance: Matrix

    def __post_init__(self) -> None:
        n = len(self.mean)
        # Definiteness costs a factorisation, so it is checked only where an estimate enters from outside (`start`).
        if self.covariance.shape != (n, n):
            raise EstimatorError(
                f"Estimate: a mean of {n} states requires a covariance of shape ({n}, {n}), "
                f"got {self.covariance.shape}; give both in the order of the prediction's states."
            )

    @property
    def deviation(self) -> Vector:
        """Standard deviation of each state, shape (n,), in the units of `mean`."""
        return np.sqrt(np.diagonal(self.covariance))


# Descriptors of the slots bypass the frozen __setattr__ and __post_init__: 0.3 µs instead of 0.8 µs, a relevant part of
# a filter step of 2 µs.
_write_mean = GaussianEstimate.__dict__["mean"].__set__
_write_covariance = GaussianEstimate.__dict__["covariance"].__set__


def seal(mean: Vector, covariance: Matrix) -> GaussianEstimate:
    """Return an estimate from arrays whose shapes match by construction, and make the arrays read-only.

    For filters: an estimate is a value that callers may keep, so it must not change later.
    """
    mean.setflags(write=False)
    covariance.setflags(write=False)
    estimate = object.__new__(GaussianEstimate)
    _write_mean(estimate, mean)
    _write_covariance(estimate, covariance)
    return estimate


Order = Literal[1, 4]
"""Order of both the Runge–Kutta step of the mean and the Taylor polynomial of Φ; 1 is forward Euler."""

ORDER: Order = 4
"""Default of a filter."""


def advance(derivative: Callable[[Vector], Vector], mean: Vector, period: float, order: Order = ORDER) -> Vector:
    """Return the mean one period [s] later; `derivative` maps (n,) to (n,) at held inputs."""
    slope_1 = derivative(mean)
    if order == 1:
        return mean + period * slope_1
    slope_2 = derivative(mean + 0.5 * period * slope_1)
    slope_3 = derivative(mean + 0.5 * period * slope_2)
    slope_4 = derivative(mean + period * slope_3)
    return mean + period / 6.0 * (slope_1 + 2.0 * slope_2 + 2.0 * slope_3 + slope_4)


def transition(jacobian: Matrix, period: float, order: Order = ORDER) -> Matrix:
    """Return Φ, shape (n, n), from A = `jacobian` [1/s] and the period [s]."""
    identity = np.eye(len(jacobian))
    exponent = period * jacobian
    phi = identity + exponent / order
    # Horner's scheme adds the smallest terms first, and needs one product per order.
    for k in range(order - 1, 0, -1):  # Horner, at order 4: I + TA/1 (I + TA/2 (I + TA/3 (I + TA/4)))
        phi = identity + exponent @ phi / k
    return phi


def tangent(
    derivative: Callable[[Vector], Vector], jacobian: Callable[[Vector], Matrix], mean: Vector, period: float
) -> Matrix:
    """Return the derivative of `advance` of order 4 by its mean, shape (n, n); `jacobian` is that of `derivative`."""
    identity = np.eye(len(mean))
    slope, by_mean = derivative(mean), jacobian(mean)
    total = by_mean.copy()
    for step, weight in ((0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
        point, moved = mean + step * period * slope, identity + step * period * by_mean
        slope, by_mean = derivative(point), jacobian(point) @ moved
        total += weight * by_mean
    return identity + period / 6.0 * total
