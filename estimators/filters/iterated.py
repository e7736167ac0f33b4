"""The iterated extended Kalman filter: outputs are linearised at the estimate that follows from them."""

from typing import Final

import numpy as np

from railgrip.estimators.belief import GaussianEstimate, Vector
from railgrip.estimators.design import FilterKind
from railgrip.estimators.ekf import ExtendedKalmanFilter, Innovation

ITERATIONS: Final = 10
"""Maximum number of linearisations; Gauss-Newton converges quadratically near the solution."""

CONVERGED: Final = 1e-9
"""Change of the mean, in standard deviations of the forecast, below which the iteration ends."""


class IteratedKalmanFilter(ExtendedKalmanFilter, FilterKind):
    """Extended Kalman filter whose update maximises the posterior density of the state by Gauss-Newton steps.

    With linear outputs it is the extended Kalman filter. Outliers are judged at every linearisation.

    Source: Bell and Cathey, The Iterated Kalman Filter Update as a Gauss-Newton Method, IEEE Trans. Automatic Control
    38 (1993) 294.
    """

    def innovation(self, forecast: GaussianEstimate, inputs: Vector, readings: Vector) -> Innovation:
        """Return the innovation with outputs linearised at the updated mean."""
        point = forecast.mean
        innovation = self.linearise(forecast, point, inputs, readings)
        for _ in range(ITERATIONS - 1):
            updated = self.condition(forecast, inputs, innovation).mean
            if np.all(np.abs(updated - point) <= CONVERGED * forecast.deviation):
                break
            point = updated
            innovation = self.linearise(forecast, point, inputs, readings)
        return innovation
