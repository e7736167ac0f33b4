"""Input of a controller at one instant."""

from typing import NamedTuple

from railgrip.base.arrays import Vector


class Observation(NamedTuple):
    """Readings and estimates of the train at one instant.

    A group is a set of wheelsets that rotate together. Arrays have shape (groups,), leading group first. A quantity
    that no sensor has read yet is NaN; one that no component provides is None.

    Attributes:
        time: Time since braking began [s].
        speed: Speed of the train [m/s]; estimated if an estimator provides it, else read.
        acceleration: Acceleration of the train, read, negative in braking [m/s²].
        wheelset_speed: Rotational speed of the wheelsets [rad/s], estimated or read like `speed`; NaN while the
            estimate is lost, that is, its standard deviation exceeds 1 m/s at the rim.
        slip: 1 − rω/v, 0 rolling, 1 locked [1].
        slip_is_estimated: Whether the slip comes from an estimator; else it follows from the speeds read and the
            nominal radii.
        adhesion: Estimated F_x/F_z of each group, positive in braking [1]; None without an estimator of it.
        pad_friction: Estimated friction of pads on disc [1]; None without an estimator of it.
        pressure: Brake cylinder pressure, read [Pa].
        driver_demand: Brake cylinder pressure that the driver demands [Pa]. A controller can only lower it: the lower
            of the two demands is sent, unless force is redistributed; see `railgrip.controllers.train_level`.
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
