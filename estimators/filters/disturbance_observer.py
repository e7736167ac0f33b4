"""Disturbance observer of each wheelset: a reference."""

import numpy as np

from railgrip.estimators.belief import Vector
from railgrip.estimators.design import FilterKind
from railgrip.estimators.filters.force_balance import TorqueBalanceEstimator


class DisturbanceEstimator(TorqueBalanceEstimator, FilterKind):
    """Adhesion as the disturbance of a critically damped observer of the wheelset speed.

    Sources: Ohishi, Nakao, Ohnishi, Miyachi, Microprocessor-Controlled DC Motor for Load-Insensitive Position Servo
    System, IEEE Trans. Industrial Electronics 34 (1987) 44; Brookner, Tracking and Kalman Filtering Made Easy (1998),
    §1.2, for gains and variance of the critically damped g-h filter.
    """

    def correct(self, seen: Vector, expected: Vector) -> Vector:
        """Predict the wheelset speeds and correct them and adhesion by their error."""
        memory = np.exp(-self.corner * self._period)
        ahead = self.mean[self._wheels] + self._period * expected
        error = np.where(np.isfinite(seen), seen - ahead, 0.0)
        is_jump = self._is_jump(error, self._period)
        self.mean[self._wheels] = ahead + np.where(is_jump, 1.0, 1.0 - memory**2) * error
        return np.where(is_jump, 0.0, (1.0 - memory) ** 2 * error / (self._period * self._effect))

    def delay(self) -> Vector:
        """Return T Σ h², k = 1, 2, …, of the error h = (1 + (1 − m) k) mᵏ after a step, with m = exp(−ωT)."""
        memory = np.exp(-self.corner * self._period)
        square, rate = memory**2, 1.0 - memory
        rest = 1.0 - square
        sums = square / rest, square / rest**2, square * (1.0 + square) / rest**3  # of m²ᵏ, k m²ᵏ, k² m²ᵏ
        return self._period * (sums[0] + 2.0 * rate * sums[1] + rate**2 * sums[2])

    def rate_variance(self) -> Vector:
        """Return the noise gain of the rate of a g-h filter."""
        memory = np.exp(-self.corner * self._period)
        g, h = 1.0 - memory**2, (1.0 - memory) ** 2
        return 2.0 * h**2 / (g * (4.0 - 2.0 * g - h) * self._period**2)
