"""The three laws of curve resistance say what their sources print."""

import numpy as np
import pytest

from railgrip.scenario.track import CurveLaw, curve_coefficient, force_along


@pytest.mark.parametrize(
    ("law", "per_mille"),
    # R = 500 m, wheelbase 2.15 m, gauge 1.435 m: (0.3397 + 0.0474)/500, 650/445, (0.2267 + 0.2215)/500.
    [("bogie", 0.774), ("roeckl", 1.461), ("protopapadakis", 0.896)],
)
def test_a_curve_of_500_m(law: CurveLaw, per_mille: float):
    assert 1e3 * curve_coefficient(1 / 500, law) == pytest.approx(per_mille, abs=6e-4)
    assert curve_coefficient(-1 / 500, law) == curve_coefficient(1 / 500, law)


def test_a_curve_holds_either_way_and_a_fall_pushes():
    force = force_along(np.array([0.0, -0.01]), np.array([-1 / 500, 0.0]), 84e3)
    assert force[0] == pytest.approx(-84e3 * 9.81 * 0.774e-3, rel=1e-3)
    assert force[1] == pytest.approx(84e3 * 9.81 * np.sin(np.arctan(0.01)))


def test_roeckl_is_held_at_the_end_of_its_range():
    assert curve_coefficient(1 / 200, "roeckl") == pytest.approx(0.650 / 245)
