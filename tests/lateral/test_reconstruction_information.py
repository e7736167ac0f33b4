"""Information in the readings about the states of the reconstruction, from its equations."""

import lateral_runs
import numpy as np
import pytest

from railgrip.estimation.lateral.information import information_of
from railgrip.estimation.lateral.run import LateralCase, simulate
from railgrip.estimation.lateral.wheelset import CONDITIONS, PERIOD, TESTS


@pytest.fixture(scope="module")
def found():
    return information_of(
        simulate(LateralCase(test=TESTS[-1].shorten(2.5), speed=25.0, plant="paper", seed=1), names=())
    )


def test_readings_do_not_determine_the_sign_of_creep_and_force(found):
    assert found.mirrored < 1e-9


def test_longer_windows_contain_more_information(found):
    """25 short windows in a long one: with an exact model more readings cannot reduce the information."""
    assert np.all(np.median(found.long, axis=0) < np.median(found.short, axis=0))


def test_a_change_of_the_surface_is_beyond_the_process_noise(found):
    """Friction falls by 0.1 or more where the surface changes; the walk of Table Q adds up to 1e-12 per step."""
    assert found.jump[0] > 0.05
    assert found.allowed == pytest.approx(np.sqrt(1e-12 * 0.5 / PERIOD))
    assert np.all(found.jump > 100 * found.allowed)


def test_rows_of_information_have_all_conditions_and_states(found, monkeypatch):
    monkeypatch.setattr(lateral_runs, "over_seeds", lambda *_: [found])
    rows = lateral_runs.observed_rows(1, 2.5)
    assert sum(row["windows"] for row in rows) == len(found.condition)
    assert [row["condition"] for row in rows] == [condition.name for condition in CONDITIONS]
    assert all(0 <= row["force"] <= row["force 90"] for row in rows)
    friction, force = lateral_runs.refused_rows(1, 2.5)
    assert (friction["jump"], force["allowed"]) == (found.jump[0], found.allowed[1])
