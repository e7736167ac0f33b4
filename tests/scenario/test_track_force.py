"""Gradients and curves push and hold the train as mechanics says."""

import numpy as np
import pytest

from railgrip.scenario.track import Track, track_force_of


def test_a_level_straight_track_does_nothing():
    assert track_force_of(Track()).at(123.0) == 0.0


def test_a_falling_gradient_pushes_forward_with_m_g_sin():
    track = Track.model_validate({"gradient": [{"begin": "100 m", "slope": "-25 ‰"}], "train_mass": "84 t"})
    force = track_force_of(track)
    assert force.at(99.9) == 0.0
    assert force.at(100.0) == pytest.approx(84e3 * 9.81 * np.sin(np.arctan(0.025)))


def test_curves_follow_the_chosen_law():
    sections = {"curve": [{"begin": 0, "radius": "500 m"}, {"begin": 50, "radius": 0}], "train_mass": 84e3}
    bogie = track_force_of(Track.model_validate(sections))
    roeckl = track_force_of(Track.model_validate(sections | {"curve_law": "roeckl"}))
    # 1.46 ‰ at 500 m (Röckl 650/(R − 55)); 0.77 ‰ from the mean wheelbase 2.15 m and gauge 1.435 m.
    assert roeckl.at(10.0) == pytest.approx(-84e3 * 9.81 * 1.4607e-3, rel=1e-4)
    assert bogie.at(10.0) == pytest.approx(-84e3 * 9.81 * (0.158 * 2.15 + 0.033 * 1.435) / 500)
    assert bogie.at(60.0) == roeckl.at(60.0) == 0.0


def test_a_constant_force_adds_up():
    track = Track.model_validate({"force": "2 kN", "gradient": [{"begin": 0, "slope": "10 ‰"}], "train_mass": 1000})
    assert track_force_of(track).at(1.0) == pytest.approx(2000 - 1000 * 9.81 * np.sin(np.arctan(0.01)))
