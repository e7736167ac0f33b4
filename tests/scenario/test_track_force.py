"""Gradients and curves accelerate and brake the train according to mechanics."""

import numpy as np
import pytest

from railgrip.scenario.track import CurveLaw, Track, curve_coefficient, force_along, slope_of, track_force_of


def test_a_level_straight_track_does_nothing():
    assert track_force_of(Track(), 84e3).at(123.0) == 0.0


@pytest.mark.parametrize(
    ("law", "per_mille"),
    # R = 500 m, wheelbase 2.15 m, gauge 1.435 m: (0.3397 + 0.0474)/500, 650/445, (0.2267 + 0.2215)/500.
    [("bogie", 0.774), ("roeckl", 1.461), ("protopapadakis", 0.896)],
)
def test_a_curve_of_500_m_has_the_resistance_of_its_formula(law: CurveLaw, per_mille: float):
    assert 1e3 * curve_coefficient(1 / 500, law) == pytest.approx(per_mille, abs=6e-4)
    assert curve_coefficient(-1 / 500, law) == curve_coefficient(1 / 500, law)
    for radius in ("500 m", "-500 m"):
        sections = {"curve": [{"begin": 0, "radius": radius}, {"begin": 50, "radius": 0}]}
        force = track_force_of(Track.model_validate(sections | {"curve_law": law}), 84e3)
        assert force.at(10.0) == pytest.approx(-84e3 * 9.81 * 1e-3 * per_mille, rel=1e-3)
        assert force.at(60.0) == 0.0


def test_roeckl_is_constant_beyond_the_end_of_its_range():
    assert curve_coefficient(1 / 200, "roeckl") == pytest.approx(0.650 / 245)


def test_a_falling_gradient_adds_m_g_sin_to_a_constant_force():
    gradient = [{"begin": "100 m", "slope": "-25 ‰"}]
    force = track_force_of(Track.model_validate({"force": "2 kN", "gradient": gradient}), 84e3)
    assert force.at(99.9) == 2000.0
    assert force.at(100.0) == pytest.approx(2000.0 + 84e3 * 9.81 * np.sin(np.arctan(0.025)))


PLAN = {
    "latitude": 50.6, "longitude": 12.7, "height": "340 m", "middle": "500 m", "heading": "20 deg",
    "course": [["300 m", 0], ["80 m", "600 m"], ["100 m", "600 m"], ["80 m", 0], ["440 m", 0]],
    "slope": "-6 permille", "grades": [["200 m", "4 permille", "8000 m"]], "start": "100 m", "direction": "forward",
}  # fmt: skip


@pytest.mark.parametrize(("direction", "start"), [("forward", 100.0), ("backward", 900.0)])
def test_the_force_along_a_track_follows_slope_and_curvature(direction, start):
    plan = PLAN | {"direction": direction, "start": start}
    track = Track.model_validate({"plan": plan})
    force, laid, way = track_force_of(track, 84e3), track.plan.alignment(), 1.0 if direction == "forward" else -1.0
    distance = np.linspace(0.0, 800.0, 3333)
    place = start + way * distance
    exact = force_along(way * laid.slope(place), laid.curvature(place), 84e3)
    # sin is not linear over a metre of a rounding: m g (h/8R)^2 times the slope; 1e-4 N in 5 kN.
    np.testing.assert_allclose([force.at(s) for s in distance], exact, rtol=0, atol=1e-4)
    assert [slope_of(track)(s) for s in distance[:9]] == pytest.approx(list(way * laid.slope(place[:9])))
    assert force.at(5e4) == pytest.approx(float(force_along(way * laid.slope(place[-1] + way * 1e4), 0.0, 84e3)))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"grades": [["200 m", "4 permille", "8000 m"], ["210 m", 0, "8000 m"]]}, "the rounding at 210 m begins at"),
        ({"start": "2 km"}, "start 2000 m is beyond the end of the track, 1000 m"),
        ({"course": [["300 m", "5 m"]]}, "a radius is 0, for straight track, or at least 10 m"),
    ],
)
def test_an_inconsistent_track_is_refused(changes, sentence):
    with pytest.raises(ValueError, match=sentence):
        Track.model_validate({"plan": PLAN | changes})
