"""Slip of a wheelset from the speeds of train and wheel."""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

SMALL_SPEED: Final = 0.05
"""Train speed [m/s] below which slip counts as 0, because it would be a ratio of noises."""


def slip_of(speed: ArrayLike, rim_speed: ArrayLike) -> NDArray[np.float64]:
    """Return the slip 1 − rω/v; 0 if the train is slower than `SMALL_SPEED`, NaN if its speed is unknown.

    The loop in C has the same function in `slip_of` of harness/simulate/loop/kernel/onboard.c.

    Args:
        speed: v of the train [m/s].
        rim_speed: rω of each wheelset [m/s]; its shape is that of the result.
    """
    rim_speed = np.asarray(rim_speed, dtype=np.float64)
    # Not `>=`, with which an unknown speed (NaN) would have a slip of 0.
    is_moving = np.logical_not(np.asarray(speed) < SMALL_SPEED)
    return 1.0 - np.divide(rim_speed, speed, out=np.ones_like(rim_speed), where=is_moving)
