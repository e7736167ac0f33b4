"""The most that the rail would have given: the peak of the creep curve at every sample of a trace."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

Contact = Callable[[Array, Array, Array, Array], Array]
"""contact(slip, speed [m/s], wheelset load [N], mu0) → adhesion; arrays of one shape, element by element."""

_SLIPS = np.geomspace(1e-4, 1.0, 33)  # the narrowest published curve peaks near 3e-3; 1 is a locked wheel
_GOLDEN = (np.sqrt(5) - 1) / 2
_REFINEMENTS = 20  # shrinks the bracket of ±1 grid step to 4e-5 of the slip, adhesion there to some 1e-9


def peak(contact: Contact, speed: Array, load: Array, mu0: Array) -> tuple[Array, Array]:
    """Return the best common slip of wheelsets that turn as one, and the adhesion of each at it.

    The best of a logarithmic grid of slips, refined by golden section on its logarithm; at each sample on its
    own. A curve is assumed to have one maximum within two grid steps (a factor of 1.8 in slip).

    Args:
        contact: The creep curve.
        speed: Of the train, shape (n,) [m/s].
        load: Of each wheelset, shape (n, k) [N].
        mu0: Maximum friction at each wheelset, shape (n, k).

    Returns:
        Slip, shape (n,), and adhesion, shape (n, k).
    """

    def adhesion(log_slip: Array) -> Array:
        slip = np.broadcast_to(np.exp(log_slip)[:, None], load.shape)
        return contact(slip, np.broadcast_to(speed[:, None], load.shape), load, mu0)

    def force(log_slip: Array) -> Array:
        return np.sum(adhesion(log_slip) * load, axis=1)

    grid = np.log(_SLIPS)
    forces = np.stack([force(np.full(speed.shape, point)) for point in grid])
    best = np.argmax(forces, axis=0)
    low, high = grid[np.maximum(best - 1, 0)], grid[np.minimum(best + 1, len(grid) - 1)]
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    force_left, force_right = force(left), force(right)
    for _ in range(_REFINEMENTS):
        rises = force_left < force_right
        low, high = np.where(rises, left, low), np.where(rises, high, right)
        fresh = np.where(rises, low + _GOLDEN * (high - low), high - _GOLDEN * (high - low))
        force_fresh = force(fresh)
        left, right = np.where(rises, right, fresh), np.where(rises, fresh, left)
        force_left, force_right = (
            np.where(rises, force_right, force_fresh),
            np.where(rises, force_fresh, force_left),
        )
    # A maximum at the edge of the grid is not inside the bracket: never return less than the grid had.
    middle = (low + high) / 2
    chosen = np.where(force(middle) >= forces[best, np.arange(len(speed))], middle, grid[best])
    return np.exp(chosen), adhesion(chosen)
