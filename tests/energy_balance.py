"""Stopping distances on uneven track by the balance of energy: no equation of motion is solved."""

import numpy as np

G = 9.81
CURVE = 0.158 * (1.9 + 2.65 + 1.9) / 3 + 0.033 * 1.435
"""Curve resistance over weight, times the radius [m]: equation (7) of Schwarz, Lüdicke and Heckmann."""


def steps(sections):
    """Return a function of place from rows of begin and value; before the first row as in it."""
    begins, values = np.array(sections, dtype=float).T
    return lambda place: values[np.maximum(np.searchsorted(begins, place, side="right") - 1, 0)]


def stopping_distance(speed, brake, behind, shares, slope=((0, 0),), curvature=((0, 0),), gravity=G):
    """Return where the works of brake, gravity and curves equal the kinetic energy at the start [m].

    Args:
        speed: At the start, with the first point of the train at 0 [m/s].
        brake: Deceleration by the brake [m/s2].
        behind: Distance of each point with mass behind the first [m].
        shares: Share of the mass at each point.
        slope: Rows of begin [m] and tangent of the gradient.
        curvature: Rows of begin [m] and curvature [1/m].
        gravity: Acceleration of gravity along the track over the sine of the gradient [m/s2].
    """
    step = 0.01
    edges = np.arange(-max(behind) - 1.0, 3000.0, step)
    middles = edges[:-1] + 0.5 * step
    # Heights are sums of sin β along the track.
    rate = gravity * np.sin(np.arctan(steps(slope)(middles))) + G * CURVE * np.abs(steps(curvature)(middles))
    work = np.concatenate([[0.0], np.cumsum(rate * step)])
    s = np.arange(0.0, 2500.0, 0.05)
    of_track = sum(
        share * (np.interp(s - back, edges, work) - np.interp(-back, edges, work))
        for back, share in zip(behind, shares, strict=True)
    )
    return float(np.interp(0.5 * speed**2, brake * s + of_track, s))
