"""Runs of the instrumented car over a friction-modified stretch of straight track, after Abduraxman et al. (2024).

A run is one pass over 400 m at constant speed: a `Pass` has its inputs, a `Ride` the true accelerations of the axle
boxes, before any accelerometer (see `reduction`).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from scipy.ndimage import gaussian_filter1d

from railgrip.base.arrays import generator
from railgrip.estimators.belief import Array
from railgrip.fmi import CoSimulation, Description, Port, bind, describe
from railgrip.fmus.build import fmu
from railgrip.scenario.track_geometry import KINDS, TRACKS, Irregularity, realise

RATE: Final = 1280
"""Samples a second. Irregularities end at 21 Hz and the wheelsets bounce at 42 Hz: four times as many samples change
accelerations below 100 Hz by less than the solver's tolerance, and take twice as long. Accelerometers interpolate to
the rate of their loggers."""
LENGTH: Final = 400.0
"""Length of the straight section of the test track, m."""
LEAD_IN: Final = 40.0
"""Distance before the section in which the car settles on the irregularities, m."""
PIVOTS: Final = 14.2
WHEELBASE: Final = 2.1
BEHIND: Final = (0.0, WHEELBASE, PIVOTS, PIVOTS + WHEELBASE)
"""Distance of each wheelset behind the leading one, m."""
MPH: Final = 0.44704
FMU: Final = "MultiPurposeVehicle"
OUTPUTS: Final = 25
"""Number of outputs of the car: longitudinal acceleration of the left and of the right boxes, lateral acceleration,
offset and creep of the wheelsets, leading one first, the speed, and angular velocity of the wheelsets; in axes that
point forwards."""


SURFACES: Final[Mapping[str, tuple[float, float, float, float]]] = {
    # Dry and wet are Polach's (2005) published sets. Of the others only the friction is known; their slopes are
    # estimates: third-body layers are taken as soft as water, the solid film of a friction modifier as stiffer.
    "dry": (1.0, 0.4, 0.4, 0.6),
    "friction modifier": (0.5, 0.2, 0.4, 0.2),
    "wet": (0.3, 0.1, 0.4, 0.2),
    "detergent": (0.3, 0.1, 0.4, 0.2),
    "paper tape": (0.25, 0.1, 0.4, 0.2),
}
"""Polach's k_A, k_S, A and B under each rail-head treatment."""

SLOPE_DEVIATION: Final = 0.15
"""Standard deviation of the logarithm of k_A and k_S from run to run, because applied films vary (estimate)."""
FRICTION_DEVIATION: Final = 0.05
"""Relative standard deviation of friction along the section, of the size between two readings (estimate)."""
FRICTION_LENGTH: Final = 10.0
"""Distance over which friction changes along the section, m (estimate)."""
SPEED_DEVIATION: Final = 0.01
"""Relative standard deviation of the held speed from the nominal one (estimate)."""
RADII: Final = (0.4200, 0.4196, 0.4203, 0.4198)
"""Radii of the wheels, m, which are never equal in one vehicle (estimate)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pass:
    """Inputs of one run.

    Attributes:
        name: Unique; random streams of the run depend on it.
        speed: Nominal, m/s.
        condition: Key of `SURFACES`.
        friction: Mean maximum friction over the section, the label.
        track: Key of `irregularity.TRACKS`.
        track_seed: Seed of the irregularities, the same for runs over the same track.
        seed: Seed of everything that varies from run to run.
        backwards: Whether the fourth wheelset leads.
        length: m.
    """

    name: str
    speed: float
    condition: str
    friction: float
    track: str
    track_seed: int
    seed: int
    backwards: bool = False
    length: float = LENGTH

    def __post_init__(self) -> None:
        if self.condition not in SURFACES:
            raise ValueError(f"{self.name}: condition '{self.condition}' is unknown; there are {', '.join(SURFACES)}.")
        if self.track not in TRACKS:
            raise ValueError(f"{self.name}: track '{self.track}' is unknown; there are {', '.join(TRACKS)}.")
        if not 0 < self.friction < 1:
            raise ValueError(f"{self.name}: friction lies between 0 and 1, got {self.friction}.")


@dataclass(frozen=True, slots=True, kw_only=True)
class Ride:
    """True motion of the axle boxes on the section, in axes fixed to the car: wheelset 1 at its front.

    Attributes:
        longitudinal: m/s², shape (n, 4 wheelsets, 2: left and right).
        lateral: m/s², shape (n, 4), to the left.
        speed: m/s, shape (n,).
        friction: At each wheelset, shape (n, 4).
        offset: Lateral position of the wheelsets on the track, m, shape (n, 4).
        creep: Total creepage of the left wheels, shape (n, 4).
        slip_acceleration: ẍ − ω̇r of the wheelsets between samples, equation (3), m/s², shape (n − 1, 4).
    """

    longitudinal: Array
    lateral: Array
    speed: Array
    friction: Array
    offset: Array
    creep: Array
    slip_acceleration: Array


def ride(run: Pass, *, rate: int = RATE, progress: Callable[[float], None] = lambda share: None) -> Ride:
    """Simulate a run, sampled at `rate` a second.

    Raises:
        PlantFailed: The FMU failed.
        railgrip.base.errors.FmuError: It cannot be built.
    """
    speed, (k_A, k_S, A, B) = held_speed(run), _surface(run)
    inputs, lead_in = _inputs(run, speed, rate)
    radii = RADII[::-1] if run.backwards else RADII
    parameters = {
        "speed_set": speed,
        "k_A": k_A, "k_S": k_S, "A_falling": A, "B_falling": B,
        "wheelbase": WHEELBASE, "pivots": PIVOTS,
    } | {f"r_wheel[{i + 1}]": r for i, r in enumerate(radii)}  # fmt: skip
    # Backwards, the driven wheelsets are again the inner ones: the car is symmetric except for its wheels.
    description, binding = _bind()
    with CoSimulation(description, binding, period=1 / rate, parameters=parameters) as car:
        outputs = np.empty((len(inputs), OUTPUTS))
        outputs[0] = car.start(inputs[0])
        step = car.step
        for k in range(1, len(inputs)):
            outputs[k] = step(inputs[k])
            if k % 512 == 0:
                progress(k / len(inputs))
    outputs, friction = outputs[lead_in:], inputs[lead_in:, 16:]
    # The car outputs no angular acceleration, which is therefore a difference of samples.
    acceleration = 0.5 * (outputs[:, 0:4] + outputs[:, 4:8])
    slip_acceleration = 0.5 * (acceleration[1:] + acceleration[:-1]) - np.diff(outputs[:, 21:], axis=0) * rate * radii
    result = Ride(
        longitudinal=np.stack([outputs[:, 0:4], outputs[:, 4:8]], axis=-1),
        lateral=outputs[:, 8:12], offset=outputs[:, 12:16], creep=outputs[:, 16:20], speed=outputs[:, 20],
        friction=friction, slip_acceleration=slip_acceleration,
    )  # fmt: skip
    return in_axes_of_car(result) if run.backwards else result


@cache
def _bind() -> tuple[Description, Any]:
    description = describe(fmu(FMU))
    inputs = {kind: ("m", 4) for kind in KINDS} | {"mu0": ("1", 4)}
    outputs = {
        "longitudinal_left": ("m/s2", 4), "longitudinal_right": ("m/s2", 4), "lateral": ("m/s2", 4),
        "offset": ("m", 4), "creep": ("1", 4), "speed": ("m/s", 0), "wheelset_speed": ("rad/s", 4),
    }  # fmt: skip
    input_signals, output_signals = (
        [Port(name=name, unit=unit, size=size, needed=True) for name, (unit, size) in interface.items()]
        for interface in (inputs, outputs)
    )
    return description, bind(description, inputs=input_signals, outputs=output_signals, where=f"the car {FMU}")


def in_axes_of_car(forward: Ride) -> Ride:
    """Return a ride in the axes of a car that ran backwards, rotated by half a turn."""
    return Ride(
        longitudinal=-forward.longitudinal[:, ::-1, ::-1],
        lateral=-forward.lateral[:, ::-1],
        offset=-forward.offset[:, ::-1],
        creep=forward.creep[:, ::-1],
        slip_acceleration=-forward.slip_acceleration[:, ::-1],
        friction=forward.friction[:, ::-1],
        speed=forward.speed,
    )


def slope(run: Pass) -> float:
    """Return the slope of the creep curve of a run relative to that of a clean contact, (k_A + k_S)/2."""
    k_A, k_S, *_ = _surface(run)
    return (k_A + k_S) / 2


def held_speed(run: Pass) -> float:
    """Return the constant speed of the car, m/s, near the nominal one."""
    return run.speed * (1 + SPEED_DEVIATION * generator(run.seed, f"{run.name}.speed").standard_normal())


def _surface(run: Pass) -> tuple[float, float, float, float]:
    k_A, k_S, A, B = SURFACES[run.condition]
    scale = float(np.exp(SLOPE_DEVIATION * generator(run.seed, f"{run.name}.surface").standard_normal()))
    return min(k_A * scale, 1.0), min(k_S * scale, 1.0), A, B


def _inputs(run: Pass, speed: float, rate: int) -> tuple[Array, int]:
    # Positions assume exactly the set speed: the controller is accurate to some hundredths of a metre a second, which
    # shifts the irregularities by centimetres.
    before = int(LEAD_IN / speed * rate)
    count = before + int(run.length / speed * rate)
    ahead = BEHIND[-1] + LEAD_IN
    distance = np.arange(count) * (speed / rate)
    position = np.asarray(ahead + distance[:, None] - np.array(BEHIND), dtype=np.float64)
    length = ahead + LEAD_IN + run.length
    track = realise(run.track, length + LEAD_IN, generator(run.track_seed, f"track.{run.track}"))
    # The car starts on smooth track: irregularities increase over the first half of the lead-in.
    ramp = np.clip(distance / (LEAD_IN / 2), 0, 1) ** 2 * (3 - 2 * np.clip(distance / (LEAD_IN / 2), 0, 1))
    columns = [_under_car(track, kind, position, length, run.backwards) * ramp[:, None] for kind in KINDS]
    columns.append(_friction(run, position, length))
    return np.hstack(columns), before


def _under_car(track: Irregularity, kind: str, position: Array, length: float, backwards: bool) -> Array:
    if not backwards:
        return track.at(kind, position)  # pyright: ignore[reportArgumentType] - one of KINDS
    opposite = track.at(kind, length - position)  # pyright: ignore[reportArgumentType]
    return -opposite if kind in ("alignment", "cross_level") else opposite


def _friction(run: Pass, position: Array, length: float) -> Array:
    spacing = 0.5
    grid = np.arange(0.0, length + LEAD_IN, spacing)
    white = generator(run.seed, f"{run.name}.friction").standard_normal(grid.size)
    smooth = gaussian_filter1d(white, FRICTION_LENGTH / spacing / 2, mode="wrap")
    smooth = (smooth - smooth.mean()) / smooth.std()
    return np.asarray(run.friction * (1 + FRICTION_DEVIATION * np.interp(position, grid, smooth)), dtype=np.float64)
