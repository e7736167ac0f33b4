"""Rails of constant friction, and outputs of a plant at its position on them, for a vehicle of `synthetic.LAYOUT`."""

import numpy as np
from synthetic import LAYOUT

from railgrip.scenario.adhesion import FrictionTable, TabulatedRail
from railgrip.scenario.track import TrackForce

STRAIGHT = TrackForce(begins=np.array([-np.inf]), forces=np.zeros(1), rates=np.zeros(1))


def constant_rail(mu0, **surface):
    """Return a level rail of this friction; `surface` is its cleaning field or its sand."""
    profile = FrictionTable(over_time=True, step=1.0, mu0_at=np.full((1, 6), mu0))
    return TabulatedRail(LAYOUT, profile, STRAIGHT, **surface)


def outputs(**values):
    """Return the outputs of a plant that outputs only these signals."""
    truth = np.full(LAYOUT.outputs, np.nan)
    for name, value in values.items():
        truth[LAYOUT.output[name]] = value
    return truth
