"""Maximum adhesion of the rail: the peak of the creep curve at every sample of a trace."""

from collections.abc import Callable

import numpy as np

from railgrip.base.arrays import Array

Contact = Callable[..., Array]
"""contact(slip, speed [m/s], wheelset load [N], mu0) → adhesion; arrays of one shape, element by element.

One that can do so takes `curve` with Polach's k_A, k_S, A and B [s/m] of each element, shape (4, …)."""

SLIPS = np.geomspace(1e-4, 1.0, 33)  # the narrowest published curve peaks near 3e-3; 1 is a locked wheel
_GOLDEN = (np.sqrt(5) - 1) / 2
_REFINEMENTS = 9  # shrinks the bracket of ±1 grid step to 0.8 % of the slip; a parabola does the rest


def peak(contact: Contact, speed: Array, load: Array, mu0: Array, slips: Array = SLIPS) -> tuple[Array, Array]:
    """Return the best common slip of wheelsets that turn as one, and the adhesion of each at it.

    The best of a logarithmic grid of slips, refined by golden section on its logarithm and by a parabola through the
    last points; at each sample on its own. Below the locked wheel a curve is assumed to have one maximum within four
    grid steps (a factor of 3.2 in slip); one that rises again towards the lock may have its greatest value there.

    Args:
        contact: The creep curve.
        speed: Of the train, shape (n,) [m/s].
        load: Of each wheelset, shape (n, k) [N].
        mu0: Maximum friction at each wheelset, shape (n, k).
        slips: The grid, an odd number of slips, rising.

    Returns:
        Slip, shape (n,), and adhesion, shape (n, k).
    """

    def adhesion(log_slip: Array) -> Array:
        slip = np.broadcast_to(np.exp(log_slip)[:, None], load.shape)
        return contact(slip, np.broadcast_to(speed[:, None], load.shape), load, mu0)

    def force(log_slip: Array) -> Array:
        return np.sum(adhesion(log_slip) * load, axis=1)

    grid, every = np.log(slips), np.arange(len(speed))
    last = len(grid) - 1
    # Every other slip first, then the neighbours of the best.
    coarse = np.stack([force(np.full(speed.shape, point)) for point in grid[::2]])
    best = 2 * np.argmax(coarse[:-1], axis=0)
    around = [np.maximum(best - 1, 0), best, np.minimum(best + 1, last)]
    beside = np.stack([force(grid[around[0]]), coarse[best // 2, every], force(grid[around[2]])])
    nearest = np.argmax(beside, axis=0)
    best, highest = np.stack(around)[nearest, every], beside[nearest, every]
    low, high = grid[np.maximum(best - 1, 0)], grid[np.minimum(best + 1, last)]
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
    middle = (low + high) / 2
    vertex = _vertex((left, middle, right), (force_left, force(middle), force_right))
    fine = np.clip(vertex, low, high)
    # A maximum at the edge of the grid is not inside the bracket: never return less than the grid had.
    force_there = force(fine)
    place = np.where(force_there >= highest, fine, grid[best])
    place = np.where(coarse[-1] > np.maximum(force_there, highest), grid[last], place)
    return np.exp(place), adhesion(place)


def _vertex(points: tuple[Array, Array, Array], values: tuple[Array, Array, Array]) -> Array:
    """Return where the parabola through three points with the middle one halfway has its vertex; the middle if flat."""
    left, middle, right = points
    bend = values[0] - 2.0 * values[1] + values[2]
    shift = np.divide(values[0] - values[2], 2.0 * bend, out=np.zeros_like(bend), where=bend < 0.0)
    return middle + 0.5 * (right - left) * shift
