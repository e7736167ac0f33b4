"""Reference estimators without a covariance recursion; force balance with a low-pass."""

from abc import ABC, abstractmethod
from typing import Self

import numpy as np
from numpy.typing import NDArray

from railgrip.estimators.belief import Vector
from railgrip.estimators.design import FilterContext, FilterKind, index


class TorqueBalanceEstimator(ABC):
    """An estimator of the adhesion of each group from the torque balance of its wheelsets, ẇ = f(x, u).

    Pad friction keeps its first value and wheelset loads those of the prediction; other states keep their first values.
    The train speed is that of a scalar Kalman filter with the noises of the prediction. The corner frequency follows
    from the same noises: it is that of the stationary Kalman filter for a random walk of adhesion, seen in white noise
    of the wheelset speed. No number is tuned.

    A wheelset speed that has changed by more than any adhesion can change it, such as the 0 of a sensor that fails,
    restarts the estimate of this speed and leaves that of the adhesion.

    The standard deviation of adhesion includes the noise of the wheelset speed, the first deviation of pad friction
    and the delay, if adhesion is a random walk.

    Args:
        context: Prediction, with states speed, wheelset_speed[i], group_adhesion[i] and pad_friction[i], noises and
            first belief; gate and outlier limit are not used.

    Attributes:
        mean, covariance, inputs, readings, selection: As of `railgrip.estimators.ekf.NumpyFilter`; the covariance is
            diagonal.
        squared_innovation: 0; these estimators have no innovation.
        corner: Corner frequency of each group, shape (groups,) [rad/s].

    Raises:
        EstimatorError: The prediction lacks one of these states, or has no reading of their speeds.
    """

    squared_innovation = 0.0

    def __init__(self, context: FilterContext) -> None:
        self._prediction, self._period = context.prediction, context.period
        states, outputs = context.prediction.states, context.prediction.outputs
        groups = sum(name.startswith("group_adhesion[") for name in states)

        def places(kind: str, name: str, names: tuple[str, ...]) -> list[int]:
            return [index(type(self).__name__, kind, f"{name}[{g + 1}]", names) for g in range(groups)]

        self._speed, self._speed_reading = states.index("speed"), outputs.index("speed")
        self._wheels, self._adhesions = (
            places("state", "wheelset_speed", states),
            places("state", "group_adhesion", states),
        )
        self._wheel_readings = places("output", "wheelset_speed", outputs)
        self.mean, self.covariance = context.mean.copy(), context.covariance.copy()
        self.inputs = np.zeros(len(context.prediction.inputs))
        self.readings, self.selection = np.full(len(outputs), np.nan), np.zeros(len(outputs))
        slope = context.prediction.derivative_jacobian(context.mean, self.inputs)
        self._effect = slope[self._wheels, self._adhesions]
        self._speed_noise = context.process_noise[self._speed], context.reading_noise[self._speed_reading]
        self._wheel_variance = context.reading_noise[self._wheel_readings]
        self._walk = context.process_noise[self._adhesions]
        self.corner = (self._effect**2 * self._walk / (self._wheel_variance * self._period)) ** 0.25
        self._pads = places("state", "pad_friction", states)
        self._pad_variance = np.diag(context.covariance)[self._pads]

    @classmethod
    def of_context(cls, context: FilterContext) -> Self:
        """Return the estimator of a scenario with its first belief."""
        return cls(context)

    def advance(self) -> None:
        """Move the estimate on by one period, from the arrays `inputs` and `readings`."""
        slope = self._prediction.derivative(self.mean, self.inputs)
        seen = self.readings[self._wheel_readings]
        self.mean[self._adhesions] += self.correct(seen, slope[self._wheels])
        self.selection[:] = 0.0
        self.selection[self._wheel_readings] = np.isfinite(seen)
        self._advance_speed(slope[self._speed])
        by_state = self._prediction.derivative_jacobian(self.mean, self.inputs)
        by_pads = by_state[self._wheels, self._pads] / self._effect
        variance = self.rate_variance() * self._wheel_variance / self._effect**2 + by_pads**2 * self._pad_variance
        variance += self._walk * self.delay()
        self.covariance[self._adhesions, self._adhesions] = variance

    def _advance_speed(self, acceleration: float) -> None:
        process, noise = self._speed_noise
        self.mean[self._speed] += self._period * acceleration
        variance = self.covariance[self._speed, self._speed] + self._period * process
        reading = self.readings[self._speed_reading]
        if np.isfinite(reading):
            gain = variance / (variance + noise)
            self.mean[self._speed] += gain * (reading - self.mean[self._speed])
            variance *= 1.0 - gain
            self.selection[self._speed_reading] = 1.0
        self.covariance[self._speed, self._speed] = variance

    def _is_jump(self, error: Vector, elapsed: Vector | float) -> NDArray[np.bool_]:
        # Adhesion is between 0 and 1.
        return np.abs(error) > np.abs(self._effect) * elapsed

    @abstractmethod
    def correct(self, seen: Vector, expected: Vector) -> Vector:
        """Update the wheelset speeds of `mean` and return the change of each adhesion, shape (groups,).

        Args:
            seen: Read wheelset speeds [rad/s], NaN where missing, shape (groups,).
            expected: Their derivatives by the prediction before this period [rad/s²], shape (groups,).
        """

    @abstractmethod
    def delay(self) -> Vector:
        """Return the variance of the error by delay over the density of a random walk of adhesion [s]."""

    @abstractmethod
    def rate_variance(self) -> Vector:
        """Return the variance of the estimated acceleration of the wheels over that of their speeds [1/s²]."""


class ForceBalanceEstimator(TorqueBalanceEstimator, FilterKind):
    """Adhesion from the torque balance with the differentiated wheelset speed, through a low-pass of first order."""

    def __init__(self, context: FilterContext) -> None:
        super().__init__(context)
        self._elapsed = np.full(len(self._wheels), self._period)

    def correct(self, seen: Vector, expected: Vector) -> Vector:
        """Take the read wheelset speeds as they are, and low-pass the missing acceleration."""
        is_new = np.isfinite(seen)
        error = seen - self.mean[self._wheels] - self._elapsed * expected
        change = (1.0 - np.exp(-self.corner * self._elapsed)) * error / (self._elapsed * self._effect)
        is_used = is_new & ~self._is_jump(error, self._elapsed)
        self.mean[self._wheels] = np.where(is_new, seen, self.mean[self._wheels])
        self._elapsed = np.where(is_new, self._period, self._elapsed + self._period)
        return np.where(is_used, change, 0.0)

    def delay(self) -> Vector:
        """Return T Σ h², k = 1, 2, …, of the error h = mᵏ after a step, with m = exp(−ωT)."""
        square = np.exp(-2.0 * self.corner * self._period)
        return self._period * square / (1.0 - square)

    def rate_variance(self) -> Vector:
        """Return the noise gain of the difference quotient followed by the low-pass."""
        gain = 1.0 - np.exp(-self.corner * self._period)
        return 2.0 * gain**2 / ((2.0 - gain) * self._period**2)
