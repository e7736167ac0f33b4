"""Latitude, longitude and height on WGS84, and a local north-east-down frame (NED).

Heights are above the ellipsoid, as in GNSS, not above sea level. The formulas are pymap3d's.
"""

from dataclasses import dataclass

import numpy as np
import pymap3d
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """A point, or the origin of a local frame.

    Attributes:
        latitude: Degrees north.
        longitude: Degrees east.
        height: Metres above the WGS84 ellipsoid.
    """

    latitude: float
    longitude: float
    height: float


def local(latitude: ArrayLike, longitude: ArrayLike, height: ArrayLike, origin: Place) -> Array:
    """Return north, east, down [m] from `origin`, shape (…, 3), in the tangent plane of the ellipsoid there.

    The ellipsoid curves away from that plane: 1 km from the origin, "down" of a level track is 8 cm and its apparent
    slope 0.16 ‰; north and east have an error of less than 0.1 mm. Use heights, not "down", for slopes.
    """
    offsets = pymap3d.geodetic2ned(latitude, longitude, height, origin.latitude, origin.longitude, origin.height)
    return np.stack([np.asarray(c, dtype=np.float64) for c in offsets], axis=-1)


def geodetic(north: ArrayLike, east: ArrayLike, down: ArrayLike, origin: Place) -> Array:
    """Return latitude, longitude [°] and height [m], shape (…, 3), of points in the local frame of `origin`."""
    position = pymap3d.ned2geodetic(north, east, down, origin.latitude, origin.longitude, origin.height)
    return np.stack([np.asarray(c, dtype=np.float64) for c in position], axis=-1)
