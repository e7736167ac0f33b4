"""What a controller sees at one instant."""

from typing import NamedTuple


class Sight(NamedTuple):
    """The train as sensors and estimator show it to the controller.

    Groups are wheelsets that turn together; every tuple has one entry per group, leading group first.

    Attributes:
        time: Since braking began [s].
        speed: Of the train [m/s].
        acceleration: Of the train, negative in braking [m/s²].
        slip: 1 − rω/v, 0 rolling, 1 locked [1].
        adhesion: F_x/F_z of each group, positive in braking [1]; None without an estimator.
        pad_friction: Estimated friction of pads on disc [1]; None without an estimator.
        pressure: Measured brake cylinder pressure [Pa].
    """

    time: float
    speed: float
    acceleration: float
    slip: tuple[float, ...]
    adhesion: tuple[float, ...] | None
    pad_friction: tuple[float, ...] | None
    pressure: tuple[float, ...]
