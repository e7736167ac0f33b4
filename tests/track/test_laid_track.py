"""A track composed of pieces has their heading, height and plan."""

import numpy as np
import pytest
from scipy.special import fresnel

from railgrip.scenario.track_geometry import Linear, Place, TrackAlignment, course_of, grades_of, local

MIDDLE = Place(latitude=50.5976, longitude=12.6939, height=342.043)
FLAT = Linear(np.array([0.0]), np.array([0.0]))


def track(curvature: Linear, slope: Linear = FLAT, heading: float = 0.0) -> TrackAlignment:
    return TrackAlignment(origin=MIDDLE, middle=0.0, length=400.0, heading=heading, curvature=curvature, slope=slope)


def test_a_transition_curve_is_a_clothoid():
    """North and east of a clothoid κ = s/A² are Fresnel's integrals."""
    length, radius = 200.0, 250.0
    plan = track(course_of([(length, 1 / radius), (200, 1 / radius)])).plan()
    scale = np.sqrt(np.pi * length * radius)  # Fresnel's integrals use π t²/2 for s²/(2A²)
    sine, cosine = fresnel(length / scale)
    # Simpson over half a metre: (h⁵/2880) of a fourth derivative below 1e-6, four hundred times.
    np.testing.assert_allclose(plan.horizontal_at(length), [scale * cosine, scale * sine], rtol=0, atol=1e-7)


def test_an_arc_turns_by_its_length_over_its_radius_about_its_centre():
    track_here = track(Linear(np.array([0.0]), np.array([1 / 300.0])))
    assert track_here.heading_at(300.0) == pytest.approx(1.0)
    plan = track_here.plan()
    centre = np.array([0.0, 300.0])  # east is to the right of north
    distances = np.linalg.norm(plan.horizontal_at(np.arange(0, 400, 0.5)) - centre, axis=1)
    np.testing.assert_allclose(distances, 300.0, rtol=0, atol=1e-7)


def test_a_slope_change_is_a_parabola_through_its_tangents():
    track_here = track(FLAT, grades_of(-0.01, ((200.0, 0.01, 5000.0),)))
    # Tangents meet at 200 m, 2 m below the beginning; the parabola passes l²/(2R) above, l = 50 m.
    assert track_here.height_at(100.0) - MIDDLE.height == pytest.approx(-1.0)
    assert track_here.height_at(200.0) - MIDDLE.height == pytest.approx(-2.0 + 50.0**2 / (2 * 5000.0))
    assert track_here.height_at(300.0) - MIDDLE.height == pytest.approx(-1.0)


def test_overlapping_roundings_are_refused():
    with pytest.raises(ValueError, match="begins at 170 m, before 250 m"):
        grades_of(-0.01, ((200.0, 0.01, 5000.0), (205.0, 0.003, 10000.0)))


def test_positions_are_on_the_plan_at_the_height_over_the_ellipsoid():
    track_here = track(Linear(np.array([0.0]), np.array([1 / 300.0])), grades_of(0.01, ()), heading=0.4)
    plan = track_here.plan()
    distance = np.array([0.0, 150.0, 400.0])
    positions = plan.positions(distance)
    flat = local(positions[:, 0], positions[:, 1], positions[:, 2], MIDDLE)
    # Lifting a point by 4 m along its own vertical, 400 m off, moves it by 4·400/6.4e6 m in the plane of the origin.
    np.testing.assert_allclose(flat[:, :2], plan.horizontal_at(distance), rtol=0, atol=5e-4)
    np.testing.assert_allclose(positions[:, 2], MIDDLE.height + 0.01 * distance)
