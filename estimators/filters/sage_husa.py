"""An adaptive extended Kalman filter that estimates the noise of its readings (Sage and Husa)."""

from dataclasses import replace
from typing import Final

import numpy as np

from railgrip.estimators.belief import GaussianEstimate, Vector
from railgrip.estimators.design import FilterKind
from railgrip.estimators.ekf import ExtendedKalmanFilter, Innovation

MEMORY: Final = 200
"""Readings over which the variance is averaged with exponential weights: its relative standard deviation is then
√(2/(2·MEMORY)), 7 %."""


class SageHusaFilter(ExtendedKalmanFilter, FilterKind):
    """Extended Kalman filter that adapts the variance of each reading to its residuals after the update.

    R ← (1 − d) R + d (ε² + h P⁺ hᵀ) with ε the reading minus the updated output and d = 1/`memory`. The form with
    residuals keeps every variance positive; the original form, with innovations, does not. Process noise is not
    adapted, because both together are not observable from innovations.

    Unlike other filters it changes from step to step: it is used for one recording.

    Attributes:
        memory: Number of readings; infinity for the extended Kalman filter.

    Sources: Sage and Husa, Adaptive Filtering with Unknown Prior Statistics (1969); Mohamed and Schwarz, Adaptive
    Kalman Filtering for INS/GPS, J. Geodesy 73 (1999) 193, for the residuals.
    """

    memory: float = MEMORY

    def condition(self, forecast: GaussianEstimate, inputs: Vector, innovation: Innovation) -> GaussianEstimate:
        """Return the belief after the readings, and adapt the variance of those that were used."""
        belief = super().condition(forecast, inputs, innovation)
        rows, jacobian = innovation.rows, innovation.jacobian
        residual = innovation.residual - jacobian @ (belief.mean - forecast.mean)
        observed = residual**2 + np.einsum("ij,jk,ik->i", jacobian, belief.covariance, jacobian)
        noise = self.design.reading_noise.copy()
        noise[rows, rows] += (observed - noise[rows, rows]) / self.memory
        self.design = replace(self.design, reading_noise=noise)
        return belief
