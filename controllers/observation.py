"""What a controller is shown at one instant."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


class Observation(NamedTuple):
    """The train as sensors and estimator show it to the controller.

    A group is the wheelsets that turn together; every array has one entry per group, leading group first. A quantity
    that no sensor has read yet is NaN, one that no component provides is None.

    Attributes:
        time: Since braking began [s].
        speed: Of the train [m/s]; estimated where an estimator provides it, else read.
        acceleration: Of the train, read, negative in braking [m/s²].
        wheelset_speed: Rotational speed of the wheelsets, as `speed` estimated or read [rad/s]; NaN where an estimate
            is lost, its deviation more than 1 m/s at the rim.
        slip: 1 − rω/v, 0 rolling, 1 locked [1].
        slip_is_estimated: Whether the slip comes from an estimator; else it follows from the speeds read and the
            nominal radii.
        adhesion: Estimated F_x/F_z of each group, positive in braking [1]; None without an estimator of it.
        pad_friction: Estimated friction of pads on disc [1]; None without an estimator of it.
        pressure: Read brake cylinder pressure [Pa].
        driver_demand: Brake cylinder pressure that the driver asks for [Pa]. A controller can only lower it: the
            lower one of its demand and this is sent.
    """

    time: float
    speed: float
    acceleration: float
    wheelset_speed: Vector
    slip: Vector
    slip_is_estimated: bool
    adhesion: Vector | None
    pad_friction: Vector | None
    pressure: Vector
    driver_demand: Vector
