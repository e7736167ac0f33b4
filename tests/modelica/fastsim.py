"""FASTSIM, Kalker's simplified theory, for longitudinal creepage: an independent solution of the creep force.

Source: Kalker, A fast algorithm for the simplified theory of rolling contact, Vehicle System Dynamics 11 (1982) 1.
"""

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


def creep_force(rise: float, strips: int = 200, steps: int = 400) -> float:
    """Return force over friction times load, for a tangential stress that rises by `rise` along the longest strip.

    Lengths are in semi-axes and stresses in μ p0 = 2 μ Q/(π a b): `rise` is 2 a s/(L μ p0), with the creepage s and the
    flexibility L = 8 a/(3 G c11), so that at small creepage the force is G a b c11 s. Each strip is stepped from its
    leading edge against the creepage; where the stress exceeds the paraboloid 1 − x² − y², the strip slips.
    """
    y = (np.arange(strips) + 0.5) / strips
    half = np.sqrt(1 - y**2)
    step = 2 * half / steps
    stress, total = np.zeros(strips), np.zeros(strips)
    for number in range(steps):
        before = stress
        x = half - (number + 1) * step
        stress = np.minimum(stress + rise / 2 * step, np.maximum(1 - x**2 - y**2, 0.0))
        total += 0.5 * (before + stress) * step
    # Both halves of the ellipse; the paraboloid has the volume π/2.
    return float(2 * total.mean() / (np.pi / 2))


def closed_form(rise: float, strips: int = 4000) -> float:
    """Return the same by integration along each strip in closed form.

    A strip of half length c adheres from its leading edge to x = h − c, h = rise/2, and slips behind.
    """
    y = (np.arange(strips) + 0.5) / strips
    c = np.sqrt(1 - y**2)
    edge = np.minimum(rise / 2, 2 * c) - c
    slips = (c**2 * edge - edge**3 / 3) + 2 * c**3 / 3
    adheres = rise / 2 * (c - edge) ** 2 / 2
    return float(2 * (slips + adheres).mean() / (np.pi / 2))
