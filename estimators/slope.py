"""Slope of the creep curve by recursive least squares, and the available adhesion that follows from it."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from railgrip.estimators.belief import Vector

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
