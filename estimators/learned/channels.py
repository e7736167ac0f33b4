"""Which motions of the wheelsets an estimator listens to."""

from collections.abc import Mapping
from typing import Final, Literal

import numpy as np

from railgrip.estimators.belief import Array

Motion = Literal["longitudinal", "lateral", "yaw", "left", "right"]

COMBINATIONS: Final[Mapping[str, tuple[Motion, ...]]] = {
    "longitudinal, lateral, yaw": ("longitudinal", "lateral", "yaw"),
    "longitudinal, lateral": ("longitudinal", "lateral"),
    "longitudinal, yaw": ("longitudinal", "yaw"),
    "lateral, yaw": ("lateral", "yaw"),
    "left, right": ("left", "right"),
    "longitudinal": ("longitudinal",),
    "lateral": ("lateral",),
    "yaw": ("yaw",),
}
"""The eight combinations of Abduraxman et al. (2024), each over all wheelsets; `longitudinal` is the one they chose."""


def motions(left: Array, right: Array, lateral: Array, combination: str) -> Array:
    """Return the channels of a combination, m/s², shape (n, 4 to 12): motion by motion, wheelset by wheelset.

    Longitudinal is the mean of both axle boxes; yaw is right minus left, which is the yaw acceleration times the
    distance of the boxes.

    Args:
        left, right: Longitudinal accelerations of the axle boxes, m/s², shape (n, wheelsets).
        lateral: m/s², shape (n, wheelsets).
        combination: Key of `COMBINATIONS`.
    """
    parts: dict[Motion, Array] = {
        "longitudinal": (left + right) / 2,
        "lateral": lateral,
        "yaw": right - left,
        "left": left,
        "right": right,
    }
    return np.hstack([parts[motion] for motion in COMBINATIONS[combination]])


def forwards(lateral: Array, yaw: Array, *, backwards: bool) -> tuple[Array, Array]:
    """Return lateral and yaw acceleration, each of shape (n, 4), in axes that point forwards, wheelset 1 leading.

    Run backwards, the car is turned by half a turn: the fourth wheelset leads, left is right, and yaw stays yaw.
    """
    return (-lateral[:, ::-1], yaw[:, ::-1]) if backwards else (lateral, yaw)
