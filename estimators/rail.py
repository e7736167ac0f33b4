"""Properties of the rail that follow from estimates: its condition, and the slope and maximum of its creep curve."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import Vector

UNDECIDED = -1
"""Label before any condition has been probable enough for long enough."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionDetector:
    """Detects the probable condition from a Gaussian estimate of friction, with hysteresis in time.

    A condition covers the friction between the midpoints to its neighbours. It is announced when its probability has
    been `confidence` or more for `hold` seconds without interruption, and remains until another one is announced.

    Attributes:
        levels: Friction of each condition.
        confidence: Required probability, between one half and one.
        hold: Time for which it must last [s].
        model_deviation: Standard deviation added to that of the estimate, for model errors that its covariance does
            not include.

    Raises:
        EstimatorError: Fewer than two levels, equal ones, or an invalid confidence or time.
    """

    levels: Mapping[str, float]
    confidence: float
    hold: float
    model_deviation: float

    def __post_init__(self) -> None:
        if len(set(self.levels.values())) != len(self.levels) or len(self.levels) < 2:
            raise EstimatorError(f"ConditionDetector: requires two different levels or more, got {dict(self.levels)}.")
        if not (0.5 <= self.confidence < 1.0 and self.hold >= 0.0 and self.model_deviation >= 0.0):
            raise EstimatorError(
                "ConditionDetector: confidence is in [0.5, 1), hold and model_deviation are not negative; "
                f"got {self.confidence}, {self.hold} s, {self.model_deviation}."
            )

    def probabilities(self, mean: Vector, deviation: Vector) -> NDArray[np.float64]:
        """Return the probability of each condition at each sample, shape (k, number of levels), rows summing to one."""
        values = np.array(list(self.levels.values()))
        order = np.argsort(values)
        bounds = 0.5 * (values[order][1:] + values[order][:-1])
        total_deviation = np.hypot(deviation, self.model_deviation)
        below = ndtr((bounds - mean[:, np.newaxis]) / total_deviation[:, np.newaxis])
        edges = np.column_stack([np.zeros(len(mean)), below, np.ones(len(mean))])
        shares = np.empty((len(mean), values.size))
        shares[:, order] = np.diff(edges, axis=1)
        return shares

    def labels(self, mean: Vector, deviation: Vector, period: float) -> NDArray[np.intp]:
        """Return the condition announced at each sample, shape (k,): its index in `levels`, or `UNDECIDED`.

        Args:
            mean: Estimated friction, shape (k,); NaN without an estimate.
            deviation: Standard deviation of the estimate, shape (k,).
            period: Time between samples [s].
        """
        shares = self.probabilities(mean, deviation)
        best = np.argmax(np.where(np.isnan(shares), -1.0, shares), axis=1)
        sure = np.take_along_axis(shares, best[:, np.newaxis], axis=1)[:, 0] >= self.confidence
        hold_steps = max(1, round(self.hold / period))
        labels = np.full(len(mean), UNDECIDED)
        label, candidate, since = UNDECIDED, UNDECIDED, 0
        for k in range(len(mean)):
            if sure[k] and best[k] == candidate:
                since += 1
            else:
                candidate, since = (int(best[k]), 1) if sure[k] else (UNDECIDED, 0)
            if candidate != UNDECIDED and since >= hold_steps:
                label = candidate
            labels[k] = label
        return labels


def confusion(truth: NDArray[np.intp], labels: NDArray[np.intp], levels: int) -> NDArray[np.int64]:
    """Return the number of samples of each true condition by label, shape (levels, levels + 1).

    The last column counts undecided samples.
    """
    counts = np.zeros((levels, levels + 1), dtype=np.int64)
    np.add.at(counts, (truth, np.where(labels == UNDECIDED, levels, labels)), 1)
    return counts


MEMORY: Final = 0.5
"""Time constant of the weights of older samples [s]: slip control passes the maximum of the creep curve several times
a second, and the rail may change within a second."""

EXCITATION: Final = 0.002
"""Standard deviation of slip in the memory below which its slope is not estimated: a wheel speed of 0.2 % error."""

CLEAR: Final = 2.0
"""The same over the standard deviation of the slip itself: errors of slip flatten the slope and make it negative."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SlopeEstimate:
    """Slope of adhesion over slip at each sample.

    Attributes:
        slope: Shape (k,); NaN where slip varies less than `EXCITATION`, or than `CLEAR` times its own deviation.
        available: Available adhesion, shape (k,): the largest adhesion in the memory where the slope is not positive
            and the wheelset brakes, that is at or beyond the maximum of the creep curve; NaN elsewhere.
    """

    slope: Vector
    available: Vector


def estimate_slope(
    adhesion: Vector, slip: Vector, period: float, memory: float = MEMORY, slip_deviation: Vector | float = 0.0
) -> SlopeEstimate:
    """Return the slope by recursive least squares of adhesion on slip and a constant, with exponential forgetting.

    Args:
        adhesion: Estimated adhesion, shape (k,).
        slip: Estimated slip, shape (k,).
        period: Between samples [s].
        memory: Time constant of the weights [s].
        slip_deviation: Standard deviation of the estimated slip, shape (k,) or one value.

    Source: Gustafsson, Slip-based tire-road friction estimation, Automatica 33 (1997) 1087, for the regression.
    """
    keep = float(np.exp(-period / memory))
    # The moments of the recursion; they give the same solution as its gains, without a first covariance.
    weight = mean_slip = mean_adhesion = variance = covariance = 0.0
    highest = -np.inf
    smallest = np.broadcast_to(np.maximum(EXCITATION, CLEAR * np.asarray(slip_deviation)) ** 2, len(slip))
    slopes, available = np.full(len(slip), np.nan), np.full(len(slip), np.nan)
    for k, (s, a) in enumerate(zip(slip, adhesion, strict=True)):
        weight = keep * weight + 1.0
        gain = 1.0 / weight
        off_slip, off_adhesion = s - mean_slip, a - mean_adhesion
        mean_slip += gain * off_slip
        mean_adhesion += gain * off_adhesion
        variance = (1.0 - gain) * (variance + gain * off_slip**2)
        covariance = (1.0 - gain) * (covariance + gain * off_slip * off_adhesion)
        # A former maximum loses its weight like every older sample.
        highest = max(a, mean_adhesion + keep * (highest - mean_adhesion)) if np.isfinite(highest) else a
        if variance > smallest[k]:
            slopes[k] = covariance / variance
            available[k] = highest if slopes[k] <= 0.0 and a > 0.0 else np.nan
    return SlopeEstimate(slope=slopes, available=available)
