"""From a differential equation to one period of a filter.

Both filters share these choices, at order p = 4 unless a filter requests order 1:

Mean
    Classical Runge–Kutta of order 4 (RK4), or forward Euler, one step per period with the inputs held.
Transition matrix
    Φ = Σ_{k=0..p} (TA)ᵏ/k! with A = ∂f/∂x at the prior mean. This is the derivative of the map of the mean when f
    is linear in x, so mean and covariance of the linear case follow the same map, and
    ‖Φ − exp(TA)‖ ≤ ‖TA‖ᵖ⁺¹/(p+1)!·exp(‖TA‖) in any operator norm (the Taylor remainder).
Process noise
    A density q in (unit of the state)²/s; what one period adds is q·T, all at its end. Halving the period
    keeps the meaning of the numbers: a random walk spreads by q·t whatever the period.

Why order 4: the fastest modes of the train predictions are 6–10 Hz (bounce and pitch on the primary suspension,
|λ| ≈ 60 1/s), so |λT| ≈ 0.06 at 1 ms. A step of the explicit midpoint rule loses |λT|³/6 ≈ 4e-5 of such a mode, one of
RK4 |λT|⁵/120 ≈ 6e-9. Measured on `TrainPrediction` over 0.5 s from 2 mm of deflection: 6e-4 of the states' typical size
by midpoint, 8e-8 by RK4; and Φ is off by 4e-9, by 3e-5 with two terms. The price is two evaluations of f of 0.1 µs and
two sparse products. Order 1 is for filters that were published with it: Φ = I + TA and a mean to match.
"""

from collections.abc import Callable
from typing import Literal

import numpy as np

from railgrip.estimators.belief import Matrix, Vector

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
    for k in range(order - 1, 0, -1):  # Horner, at order 4: I + TA/1 (I + TA/2 (I + TA/3 (I + TA/4)))
        phi = identity + exponent @ phi / k
    return phi
