"""The start of a filter whose recording begins inside a braking: adhesion and deflections of a steady braking.

Filters start from a released brake, so with adhesion and deflections of zero. Where the brakes act at the first sample,
the balance of each wheelset and frame determines both:

    dω/dt (α, z, μ_b, u) = slope of the wheelset speed,    d²z/dt² (α, z, μ_b, u) = 0

Their covariance follows from that of the pad friction, to first order, and from the deviations of [start].
"""

from collections.abc import Sequence

import numpy as np

from railgrip.base.names import ElementName
from railgrip.estimators.belief import Matrix, Vector
from railgrip.estimators.prediction import Prediction

WINDOW = 0.5
"""Time over which the slope of a wheelset speed is taken [s]; a slide changes it within some tenths of a second."""
ITERATIONS = 5
"""Of Newton's method; the balances are nearly linear in adhesion and deflection."""


def start_in_braking(
    prediction: Prediction, mean: Vector, deviation: Vector, inputs: Vector, readings: Matrix, period: float
) -> tuple[Vector, Matrix]:
    """Return mean and covariance of the states at the first sample, shapes (n,) and (n, n).

    They are those that are given unless the brakes act: unless adhesion of a steady braking differs from that of `mean`
    by more than its deviation.

    Args:
        prediction: The model.
        mean: Mean of the states for a released brake, shape (n,).
        deviation: Standard deviations, shape (n,).
        inputs: Inputs at the first sample, shape (nu,).
        readings: Readings from the first sample on, NaN where missing, shape (k, m).
        period: Time between samples [s].
    """
    states, covariance = prediction.states, np.diag(deviation**2)
    rotating, adhesion, pads, moving = (
        _places(states, base) for base in ("wheelset_speed", "group_adhesion", "pad_friction", "ddz")
    )
    unknown = [*adhesion, *_places(states, "dz")]
    rates = [*rotating, *moving]
    if not adhesion or not rotating or not pads:
        return mean, covariance
    count = max(2, round(WINDOW / period) + 1)
    slopes = np.zeros(len(rates))
    for place, state in enumerate(states[k] for k in rotating):
        values = readings[:count, prediction.outputs.index(state)] if state in prediction.outputs else np.zeros(0)
        slopes[place] = _slope(values, period)
    steady = mean.copy()
    for _ in range(ITERATIONS):
        missing = slopes - prediction.derivative(steady, inputs)[rates]
        by_unknown = prediction.derivative_jacobian(steady, inputs)[np.ix_(rates, unknown)]
        if not (np.isfinite(missing).all() and np.isfinite(by_unknown).all()):
            return mean, covariance
        steady[unknown] += np.linalg.lstsq(by_unknown, missing, rcond=None)[0]
    if not np.any(np.abs(steady - mean)[adhesion] > deviation[adhesion]):
        return mean, covariance
    jacobian = prediction.derivative_jacobian(steady, inputs)
    by_friction = -np.linalg.lstsq(jacobian[np.ix_(rates, unknown)], jacobian[np.ix_(rates, pads)], rcond=None)[0]
    friction = covariance[np.ix_(pads, pads)]
    covariance[np.ix_(unknown, pads)] = by_friction @ friction
    covariance[np.ix_(pads, unknown)] = (by_friction @ friction).T
    covariance[np.ix_(unknown, unknown)] += by_friction @ friction @ by_friction.T
    return steady, covariance


def _places(states: Sequence[str], base: str) -> list[int]:
    return [k for k, state in enumerate(states) if ElementName.of(state).array == base]


def _slope(values: Vector, period: float) -> float:
    """Return the slope of a signal by Theil and Sen, which outliers do not tilt; 0 for fewer than two samples."""
    at = np.flatnonzero(np.isfinite(values))
    if at.size < 2:
        return 0.0
    first, second = np.triu_indices(at.size, 1)
    return float(np.median((values[at[second]] - values[at[first]]) / (period * (at[second] - at[first]))))
