"""Fixed values of ETCS (A.3.1), and the limits that follow from them alone."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from railgrip.base.arrays import Vector

GRAVITY = 9.81
"""Acceleration of gravity of §3.13.4.3.2 [m/s2]."""
WARNING_TIME = 2.0
"""T_warning [s]."""
DRIVER_TIME = 4.0
"""T_driver [s]."""
ROTATING_MOST, ROTATING_LEAST = 15.0, 2.0
"""M_rotating_max and M_rotating_min [% of the mass]."""
TRACTION_MOST = 0.4
"""Highest acceleration after the end of traction, §3.13.9.3.2.9 [m/s2]."""
INDICATION_LEAST = 5.0
"""Shortest time from the indication to the driver's reaction, §3.13.9.3.6.2 [s]."""

_MARGINS: Mapping[str, tuple[float, float, float, float]] = MappingProxyType(
    {"W": (4.0, 5.0, 110.0, 140.0), "SBI": (5.5, 10.0, 110.0, 210.0), "EBI": (7.5, 15.0, 110.0, 210.0)}
)
"""Limit → minimum and maximum of its margin, and the speeds between which it rises [km/h]."""


def ceiling_margin(limit: str, speed: ArrayLike) -> Vector:
    """Return dV_warning ("W"), dV_sbi ("SBI") or dV_ebi ("EBI") [m/s] at permitted speeds [m/s] (§3.13.9.2.3 to .6)."""
    least, most, low, high = _MARGINS[limit]
    return np.interp(np.multiply(3.6, speed), (low, high), (least, most)) / 3.6


def ceiling_limits(speed: float) -> dict[str, float]:
    """Return the ceiling supervision limits P, W, SBI, EBI [m/s] of a permitted speed [m/s] (§3.13.9.2)."""
    return {"P": speed} | {limit: speed + float(ceiling_margin(limit, speed)) for limit in _MARGINS}


def under_reading(speed: ArrayLike) -> Vector:
    """Return by how much odometry may read too little [m/s] at some speeds [m/s]: f41 of SUBSET-041 §5.3.1.2.

    2 km/h up to 30 km/h, and 12 km/h at 500 km/h.
    """
    return np.interp(np.multiply(3.6, speed), (30.0, 500.0), (2.0, 12.0)) / 3.6
