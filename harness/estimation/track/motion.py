"""Distance, speed and acceleration along the track from an optical speed sensor, accelerometers and GNSS.

One Rauch–Tung–Striebel smoother over the states

    s' = v,  v' = a,  a' = jerk,  b' = drift,  k' = 0

with the readings

    speed sensor      v + k v      k its scale error, v of the product taken from the reading
    accelerometers    a + b        mean of all; b holds their bias and g sin β, which they cannot tell from acceleration
    GNSS              s            length of the smoothed path plus how far ahead of it a position lies

The third needs a path over distance, and that a distance: the first pass goes without GNSS, the second with it.
"""

from dataclasses import dataclass

import numpy as np

from railgrip.estimation.spec import LowPass, Trust
from railgrip.estimation.track.course import Course, course_of
from railgrip.estimators.belief import Array


@dataclass(frozen=True, slots=True)
class Motion:
    """How a train moved, at every sample.

    Attributes:
        distance: Since the first sample [m], never falling, shape (k,).
        speed: [m/s].
        acceleration: [m/s2].
        scale: Scale error of the speed sensor.
        course: Of the track, over `distance`.
    """

    distance: Array
    speed: Array
    acceleration: Array
    scale: float
    course: Course


def motion_of(
    *,
    period: float,
    speed: Array,
    accelerations: Array,
    horizontal: Array,
    height: Array,
    trust: Trust,
    low_pass: LowPass,
) -> Motion:
    """Return motion and course from what was measured on one even grid.

    Args:
        period: Of the grid [s].
        speed: Of the optical sensor, shape (k,) [m/s].
        accelerations: Of all accelerometers along the vehicle, shape (k, sensors) [m/s2].
        horizontal: North and east by GNSS, NaN where there was none, shape (k, 2) [m].
        height: By GNSS, likewise, shape (k,) [m].

    Raises:
        EstimationError: The train hardly moved.
    """
    fixes = np.flatnonzero(np.isfinite(height))
    mean_acceleration = np.mean(accelerations, axis=1)
    nothing = np.full(speed.size, np.nan)
    first = _pass(period, speed, mean_acceleration, nothing, trust)
    rough = np.maximum.accumulate(first[:, 0])
    path = course_of(rough[fixes], horizontal[fixes], height[fixes], low_pass)
    along = nothing.copy()
    along[fixes] = path.length_to(rough[fixes]) + path.ahead(rough[fixes], horizontal[fixes])
    # The path begins at the first fix; the distance at the first sample.
    along -= np.nan_to_num(along[fixes[0]]) - rough[fixes[0]]
    second = _pass(period, speed, mean_acceleration, along, trust)
    distance = np.maximum.accumulate(second[:, 0] - second[0, 0])
    return Motion(
        distance=distance,
        speed=second[:, 1],
        acceleration=second[:, 2],
        scale=float(second[-1, 4]),
        course=course_of(distance[fixes], horizontal[fixes], height[fixes], low_pass),
    )


def _pass(period: float, speed: Array, acceleration: Array, along: Array, trust: Trust) -> Array:
    """Return smoothed states, shape (k, 5).

    Their covariance is not told on: the receiver's error wanders, where the smoother thinks it white.
    """
    T = period
    F = np.eye(5)
    F[0, 1] = F[1, 2] = T
    F[0, 2] = 0.5 * T**2
    # White jerk, integrated exactly over a period.
    jerk = trust.jerk**2 * np.array(
        [[T**5 / 20, T**4 / 8, T**3 / 6], [T**4 / 8, T**3 / 3, T**2 / 2], [T**3 / 6, T**2 / 2, T]]
    )
    Q = np.zeros((5, 5))
    Q[:3, :3] = jerk
    Q[3, 3] = trust.drift**2 * T
    # A floor: a constant state would leave the covariance of the smoother singular to rounding.
    Q[4, 4] = (1e-6) ** 2 * T
    observation = np.zeros((speed.size, 3, 5))
    observation[:, 0, 1], observation[:, 0, 4] = 1.0, np.nan_to_num(speed)
    observation[:, 1, 2] = observation[:, 1, 3] = 1.0
    observation[:, 2, 0] = 1.0
    return smooth(
        transition=F,
        noise=Q,
        observation=observation,
        reading_noise=np.array([trust.speed, trust.acceleration, trust.position]) ** 2,
        readings=np.column_stack([speed, acceleration, along]),
        start=np.array([0.0, float(speed[np.isfinite(speed)][0]), 0.0, 0.0, 0.0]),
        # The distance begins at zero, to a millimetre.
        spread=np.diag([1e-3, 1.0, 1.0, trust.bias, trust.scale]) ** 2,
    )


def smooth(
    *,
    transition: Array,
    noise: Array,
    observation: Array,
    reading_noise: Array,
    readings: Array,
    start: Array,
    spread: Array,
) -> Array:
    """Return the means of the states of x[j+1] = F x[j] + q, y[j] = H[j] x[j] + r by all readings, shape (k, n).

    The Rauch–Tung–Striebel smoother.

    Args:
        transition: F, shape (n, n).
        noise: Covariance of q, shape (n, n).
        observation: H of every instant, shape (k, m, n).
        reading_noise: Variances of independent r, shape (m,).
        readings: Readings, shape (k, m); NaN where there is none.
        start: Mean at the first instant before its readings, shape (n,).
        spread: Its covariance, shape (n, n), positive definite.

    Source: Särkkä, Bayesian Filtering and Smoothing (2013), theorems 4.2 and 8.2.
    """
    count, n = len(readings), start.size
    mean, covariance = np.empty((count, n)), np.empty((count, n, n))
    expected_mean, expected = np.empty((count, n)), np.empty((count, n, n))
    m, spread_now = start, spread
    for j in range(count):
        if j > 0:
            m, spread_now = transition @ m, transition @ spread_now @ transition.T + noise
        expected_mean[j], expected[j] = m, spread_now
        there = np.isfinite(readings[j])
        if there.any():
            H, R = observation[j][there], np.diag(reading_noise[there])
            gain = np.linalg.solve(H @ spread_now @ H.T + R, H @ spread_now).T
            remainder = np.eye(n) - gain @ H
            m = m + gain @ (readings[j][there] - H @ m)
            spread_now = remainder @ spread_now @ remainder.T + gain @ R @ gain.T
        mean[j], covariance[j] = m, spread_now
    for j in range(count - 2, -1, -1):
        G = np.linalg.solve(expected[j + 1], transition @ covariance[j]).T
        mean[j] = mean[j] + G @ (mean[j + 1] - expected_mean[j + 1])
        update = covariance[j] + G @ (covariance[j + 1] - expected[j + 1]) @ G.T
        covariance[j] = 0.5 * (update + update.T)
    return mean
