"""The conversion model: brake parameters from brake percentage, brake position and length (§3.13.3, A.3.7 to A.3.9)."""

import numpy as np

from railgrip.rolling_stock.schema import BrakePosition
from railgrip.supervision.curve import Steps

LONGEST = {"passenger P": 900.0, "freight P": 1500.0, "freight G": 1500.0}
"""Maximum length of a train for which the model holds, by brake position (§3.13.3.2) [m]."""
FASTEST = 200 / 3.6
"""Maximum speed of a train for which the model holds (§3.13.3.2) [m/s]."""

_STEPS = (
    (0.0, 100.0, (-6.30e-7, 6.10e-5, 4.72e-3, 0.0663)),
    (100.0, 120.0, (2.73e-7, -4.54e-6, 5.14e-3, 0.1300)),
    (120.0, 150.0, (5.58e-8, -6.76e-6, 5.81e-3, 0.0479)),
    (150.0, 180.0, (3.00e-8, -3.85e-6, 5.52e-3, 0.0480)),
    (180.0, np.inf, (3.23e-9, 1.66e-6, 5.06e-3, 0.0559)),
)
"""A.3.7.5 and A.3.7.6: speeds of a step [km/h], and its polynomial of the brake percentage, third order first."""

_SHORT = 900.0  # m; other coefficients hold for longer trains
_LEAST = 4.0  # hundreds of metres: shorter trains count as this long where A.3.8 and A.3.9 say so
_EMERGENCY = {
    "passenger P": ((2.30, 0.0, 0.17), (2.30, 0.0, 0.17), _LEAST),
    "freight P": ((2.30, 0.0, 0.17), (-0.40, 1.60, 0.03), _LEAST),
    "freight G": ((12.0, 0.0, 0.05), (-0.40, 1.60, 0.03), 0.0),
}
"""A.3.8: a, b and c of trains up to 900 m and of longer ones, and the length that shorter trains count as."""
_SERVICE = {
    "passenger P": ((3.0, 1.50, 0.10), (3.0, 1.50, 0.10), 0.0),
    "freight P": ((3.0, 2.77, 0.0), (10.5, 0.32, 0.18), 0.0),
    "freight G": ((3.0, 2.77, 0.0), (10.5, 0.32, 0.18), _LEAST),
}
"""A.3.9: the same for full service braking."""
_TARGET_FACTOR = {"passenger P": 1.20, "freight P": 1.20, "freight G": 1.16}
"""kto of A.3.8.5: of trains that brake to a target speed above zero."""


def emergency_deceleration(percentage: float) -> Steps:
    """Return A_brake_emergency(V), which is A_basic(V), of a brake percentage (A.3.7)."""
    limit = 16.85 * percentage**0.428
    rows = [(0.0, 0.0075 * percentage + 0.076)]
    rows += [
        (max(low, limit) / 3.6, float(np.polyval(polynomial, percentage)))
        for low, high, polynomial in _STEPS
        if limit < high
    ]
    return Steps.of(rows)


def service_deceleration(percentage: float) -> Steps:
    """Return A_brake_service(V) of a brake percentage, of which 135 % count at most (A.3.7.1)."""
    return emergency_deceleration(min(percentage, 135.0))


def emergency_times(position: BrakePosition, length: float) -> tuple[float, float]:
    """Return T_brake_emergency for target speeds of zero and above [s]; the length is in m (A.3.8)."""
    return _times(_EMERGENCY[position], position, length)


def service_times(position: BrakePosition, length: float) -> tuple[float, float]:
    """Return T_brake_service for target speeds of zero and above [s]; the length is in m (A.3.9)."""
    return _times(_SERVICE[position], position, length)


def _times(
    row: tuple[tuple[float, ...], tuple[float, ...], float], position: str, length: float
) -> tuple[float, float]:
    short, long, least = row
    hundreds = max(length / 100, least)
    basic = float(np.polynomial.polynomial.polyval(hundreds, short if length <= _SHORT else long))
    return basic, _TARGET_FACTOR[position] * basic
