"""Friction is the nearest value of the table, and the force that of the section, wherever the train is."""

from collections import namedtuple

import numpy as np
import pytest
from synthetic import LAYOUT

from railgrip.scenario.adhesion import FrictionTable, TabulatedRail

Sections = namedtuple("Sections", "begins forces rates")
VALUES = np.array([0.10, 0.11, 0.12, 0.13])


def rail(over_time):
    table = FrictionTable(over_time=over_time, step=0.5, mu0_at=np.repeat(VALUES[:, None], 6, axis=1))
    return TabulatedRail(LAYOUT, table, Sections((-np.inf, 10.0, 30.0), (0.0, 1e3, -2e3), (0.0, 0.0, 50.0)))


def at(distance):
    truth = np.full(LAYOUT.outputs, np.nan)
    truth[LAYOUT.output["distance"]] = distance
    return truth


@pytest.mark.parametrize("over_time", [True, False])
@pytest.mark.parametrize(
    ("place", "nearest"), [(0.0, 0), (0.24, 0), (0.26, 1), (0.5, 1), (1.24, 2), (1.26, 3), (99.0, 3), (-3.0, 0)]
)
def test_friction_is_that_of_the_nearest_time_or_place(over_time, place, nearest):
    track = rail(over_time)
    track.advance(*(place, at(50.0)) if over_time else (50.0, at(place)))
    assert track.mu0.tolist() == [VALUES[nearest]] * 6


def test_the_force_is_that_of_the_section_ahead_and_back():
    """A plant that is reset, or rolls back, returns to earlier sections."""
    track = rail(over_time=True)
    for distance, force in ((0, 0), (10, 1e3), (29.9, 1e3), (31, -1950), (40, -1500), (29, 1e3), (9.9, 0), (-1, 0)):
        track.advance(0.0, at(distance))
        assert track.struct.pointer.force == pytest.approx(force), distance
