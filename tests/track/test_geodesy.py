"""Positions agree with another library and with the authors of the field test."""

import numpy as np
import pyproj
import pytest

from railgrip.scenario.track_geometry import Place, geodetic, local

MIDDLE = Place(latitude=50.5976, longitude=12.6939, height=342.043)
"""Middle of the test track of Schwarz, Lüdicke and Heckmann, §3.2."""


def test_the_local_frame_is_that_of_proj():
    random = np.random.default_rng(2)
    latitude = MIDDLE.latitude + random.uniform(-0.02, 0.02, 50)
    longitude = MIDDLE.longitude + random.uniform(-0.02, 0.02, 50)
    height = MIDDLE.height + random.uniform(-50, 50, 50)
    east_north_up = pyproj.Transformer.from_pipeline(
        "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84 "
        f"+step +proj=topocentric +ellps=WGS84 +lon_0={MIDDLE.longitude} +lat_0={MIDDLE.latitude} +h_0={MIDDLE.height}"
    )
    east, north, up = east_north_up.transform(longitude, latitude, height)
    position = local(latitude, longitude, height, MIDDLE)
    np.testing.assert_allclose(position, np.stack([north, east, -np.asarray(up)], axis=-1), rtol=0, atol=1e-6)


def test_conversion_there_and_back_returns_the_position():
    points = np.random.default_rng(3).uniform(-2000, 2000, (50, 3))
    there = geodetic(points[:, 0], points[:, 1], points[:, 2], MIDDLE)
    back = local(there[:, 0], there[:, 1], there[:, 2], MIDDLE)
    # The library iterates from ECEF to a height, to about a nanometre.
    np.testing.assert_allclose(back, points, rtol=0, atol=1e-6)


def test_a_level_kilometre_falls_by_eight_centimetres_in_the_local_frame():
    """d²/2R, with R the radius of the ellipsoid along the meridian there, 6.374e6 m to 0.3 %."""
    down = local(MIDDLE.latitude + np.degrees(1000 / 6.374e6), MIDDLE.longitude, MIDDLE.height, MIDDLE)[2]
    assert down == pytest.approx(1000**2 / 2 / 6.374e6, rel=0.01)
