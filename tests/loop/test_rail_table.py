"""Friction is the nearest value of the table, and the force that of the section, wherever the train is."""

import numpy as np
import pytest
from rails import outputs
from synthetic import LAYOUT

from railgrip.scenario.adhesion import FrictionTable, TabulatedRail
from railgrip.scenario.track import TrackForce

ROWS = np.array([[-np.inf, 10, 30], [0, 1e3, -2e3], [0, 0, 50.0]])
SECTIONS = dict(zip(("begins", "forces", "rates"), ROWS, strict=True))
VALUES = np.array([0.10, 0.11, 0.12, 0.13])


def rail(over_time, **train):
    table = FrictionTable(over_time=over_time, step=0.5, mu0_at=np.repeat(VALUES[:, None], 6, axis=1))
    return TabulatedRail(LAYOUT, table, TrackForce(**SECTIONS, **train))


@pytest.mark.parametrize("over_time", [True, False])
@pytest.mark.parametrize(
    ("place", "nearest"), [(0.0, 0), (0.24, 0), (0.26, 1), (0.5, 1), (1.24, 2), (1.26, 3), (99.0, 3), (-3.0, 0)]
)
def test_friction_is_that_of_the_nearest_time_or_place(over_time, place, nearest):
    track = rail(over_time)
    track.advance(*(place, outputs(distance=50.0)) if over_time else (50.0, outputs(distance=place)))
    assert track.mu0.tolist() == [VALUES[nearest]] * 6


def test_the_force_is_that_of_the_section_ahead_and_back():
    """A plant that is reset, or rolls back, returns to earlier sections."""
    track = rail(over_time=True)
    for distance, force in ((0, 0), (10, 1e3), (29.9, 1e3), (31, -1950), (40, -1500), (29, 1e3), (9.9, 0), (-1, 0)):
        track.advance(0.0, outputs(distance=distance))
        assert track.struct.pointer.force == pytest.approx(force), distance


def test_each_wheelset_has_the_force_of_its_place_by_its_share_of_the_mass():
    """Those of cars are beyond their share of the sum by mass."""
    car = LAYOUT.formation.car_of_wheelset
    behind, shares = (0.0, 2.0, 15.0, 18.0, 32.0, 40.0), (0.3, 0.2, 0.1, 0.2, 0.1, 0.1)
    track, point = rail(over_time=True, behind=behind, shares=shares), TrackForce(**SECTIONS)
    for distance in (*np.arange(0.0, 90.0, 3.7), *np.arange(90.0, -10.0, -7.3)):
        track.advance(0.0, outputs(distance=distance))
        of_each = np.array(shares) * [float(point.at(distance - back)) for back in behind]
        assert track.struct.pointer.force == pytest.approx(of_each.sum(), abs=1e-9)
        assert float(TrackForce(**SECTIONS, behind=behind, shares=shares).at(distance)) == pytest.approx(of_each.sum())
        of_car = np.bincount(car, of_each) - np.bincount(car, shares) * of_each.sum()
        assert track.struct.view("car_force") == pytest.approx(of_car, abs=1e-9)
