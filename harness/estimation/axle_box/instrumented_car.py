"""Runs of the instrumented car over a friction-modified stretch of straight track, after Abduraxman et al. (2024).

A run is one pass over 400 m at constant speed: a `Pass` has its inputs, a `Ride` the true accelerations of the axle
boxes, `Readings` the recordings of accelerometers, and a `LabelledRun` the data of estimators.

Effects of the sensors are offset, drift and noise, the resonance of the plate, and the vibration of rolling wheels,
which a rigid-body vehicle does not have. Values are estimates for a DC-coupled sensor of the class of the 7533A4; the
range of offsets is that of Abduraxman et al. (2024).

A run at the rate of the loggers has some hundred megabytes. A reduced run has the block means of the paper's chain and
lateral and yaw acceleration at 128 samples a second, some hundred kilobytes.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d
from scipy.signal import butter, lfilter, sosfilt

from railgrip.base.arrays import generator
from railgrip.estimation.judgement import rms
from railgrip.estimators.belief import Array
from railgrip.estimators.learned.preprocessing import (
    BLOCKS,
    AntiAlias,
    Chain,
    Motion,
    Spectral,
    lateral_and_yaw,
    motions,
)
from railgrip.fmi import CoSimulation, Description, Port, bind, describe
from railgrip.fmus.build import fmu
from railgrip.scenario.load import read_toml
from railgrip.scenario.track_geometry import KINDS, TRACKS, Irregularity, realise

CAR_RATE: Final = 1280
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


PAPER: Final = read_toml(Path(__file__).parent / "library" / "published.toml")
"""Numbers of Abduraxman et al. (2024), and creep curves: tables `labels`, `networks` and `conditions`."""
SURFACES: Final[Mapping[str, Sequence[float]]] = {name: one["curve"] for name, one in PAPER["conditions"].items()}
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


def ride(run: Pass, *, rate: int = CAR_RATE, progress: Callable[[float], None] = lambda share: None) -> Ride:
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


RATE: Final = 5120
"""Sampling rate of the paper's loggers [Hz]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AxleBoxAccelerometer:
    """An accelerometer on its plate.

    Attributes:
        offset: Lowest and highest offset, m/s².
        drift: Standard deviation of the drift within a run, m/s² a second.
        walk: Random walk of the offset, m/s² a square root of a second.
        noise: Density of white noise, m/s²/√Hz.
        gain_error: Relative standard deviation of the gain.
        plate_frequency: Resonance of the plate, Hz; plate_damping: its damping ratio.
        rolling: Vibration of rolling wheels above 50 Hz, m/s² a m/s of speed.
    """

    offset: tuple[float, float] = (266.0, 272.0)
    drift: float = 5e-3
    walk: float = 2e-3
    noise: float = 5e-3
    gain_error: float = 0.01
    plate_frequency: float = 640.0
    plate_damping: float = 0.05
    rolling: float = 0.1


AXLE_BOX: Final = AxleBoxAccelerometer()


def measure(
    true: Array,
    true_rate: int,
    speed: float,
    sensor: AxleBoxAccelerometer,
    vehicle: np.random.Generator,
    run: np.random.Generator,
) -> Array:
    """Return the recording of the loggers at `RATE`, m/s².

    Args:
        true: Accelerations, m/s², shape (n, channels).
        true_rate: Of `true`, samples a second; `RATE` is a multiple of it.
        speed: m/s.
        vehicle: Draws the properties of the sensors: offsets and gains.
        run: Draws what varies from run to run: drift and noise.
    """
    fine = _fine(true, true_rate)
    channels = fine.shape[1]
    rolling = run.standard_normal(fine.shape) * sensor.rolling * speed
    gain = 1 + sensor.gain_error * vehicle.standard_normal(channels)
    time = np.arange(len(fine)) / RATE
    after = vehicle.uniform(*sensor.offset, channels) + time[:, None] * (sensor.drift * run.standard_normal(channels))
    after += np.cumsum(run.standard_normal(fine.shape), axis=0) * (sensor.walk / np.sqrt(RATE))
    after += run.standard_normal(fine.shape) * (sensor.noise * np.sqrt(RATE / 2))
    before = np.asarray(sosfilt(butter(2, 50, "highpass", fs=RATE, output="sos"), rolling, axis=0), dtype=np.float64)
    return _plate(fine + before, sensor) * gain + after


def _fine(true: Array, rate: int) -> Array:
    if RATE % rate:
        raise ValueError(f"accelerometers sample {RATE} times a second, which is not a multiple of {rate}.")
    fine = np.arange((len(true) - 1) * (RATE // rate) + 1) / (RATE // rate)
    return np.asarray(CubicSpline(np.arange(len(true)), true)(fine), dtype=np.float64)


def plate(sensor: AxleBoxAccelerometer) -> tuple[Array, Array]:
    """Return numerator and denominator of a plate with one resonance and a gain of 1 at rest (bilinear)."""
    w = np.tan(np.pi * sensor.plate_frequency / RATE)
    a = np.array([1 + 2 * sensor.plate_damping * w + w**2, 2 * (w**2 - 1), 1 - 2 * sensor.plate_damping * w + w**2])
    b = np.array([1.0, 2.0, 1.0]) * w**2
    return b / a[0], a / a[0]


def _plate(signal: Array, sensor: AxleBoxAccelerometer) -> Array:
    b, a = plate(sensor)
    # The plate starts settled at the first sample; its gain at rest is 1.
    last = b[2] - a[2]
    rest = np.array([b[1] - a[1] + last, last])[:, None] * signal[0]
    return np.asarray(lfilter(b, a, signal, axis=0, zi=rest)[0], dtype=np.float64)


SLOW: Final = AntiAlias(rate=RATE, keep=40)
SPECTRAL: Final = Spectral(rate=SLOW.slow_rate)
CHANNELS: Final[Mapping[Motion, slice]] = {
    "longitudinal": slice(0, 4), "lateral": slice(4, 8), "yaw": slice(8, 12), "left": slice(12, 16),
    "right": slice(16, 20),
}  # fmt: skip
"""Columns of `LabelledRun.blocks` by motion."""

OTHER_CHAINS: Final[Mapping[str, Callable[[Chain], Mapping[str, Any]]]] = {
    "first second is zero": lambda _: {"start": "first second"},
    "without the high-pass": lambda _: {"high_pass": 0.0},
    "offset kept": lambda _: {"high_pass": 0.0, "start": "offset"},
    "blocks a fifth as long": lambda chain: {"block": chain.block // 5},
    "blocks five times as long": lambda chain: {"block": 5 * chain.block},
}
"""Variants of the paper's chain by name → their values of `Chain`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """Recording of the loggers in one run, at `RATE`.

    Attributes:
        boxes: Accelerations in the order of `BOXES`, m/s², shape (n, 12), in axes of the car.
        speed: m/s, shape (n,).
        backwards: Whether the fourth wheelset leads.
    """

    boxes: Array
    speed: Array
    backwards: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class LabelledRun:
    """One labelled run, reduced.

    Attributes:
        name: Unique.
        group: Speed class, mph.
        speed: Mean, m/s.
        friction: The label.
        blocks: Of the paper's chain, columns as in `CHANNELS`, m/s², shape (n, 20).
        other_blocks: The same by each of `OTHER_CHAINS`.
        slow: Lateral and yaw acceleration at the rate of `SLOW`, the leading wheelset first, m/s², and the speed, m/s,
            shape (m, 9).
        slope: Slope of the creep curve relative to that of a clean contact; known for simulated runs only.
        slip_acceleration: Rms of ẍ − ω̇r of the wheelsets [m/s²]; known for simulated runs only.
        slip_rate: Rms rate of change of the total creepage of the left wheels [1/s]; known for simulated runs only.
    """

    name: str
    group: int
    speed: float
    friction: float
    blocks: Array
    other_blocks: Mapping[str, Array]
    slow: Array
    slope: float | None = None
    slip_rate: float | None = None
    slip_acceleration: float | None = None


def reduce(name: str, friction: float, readings: Readings) -> LabelledRun:
    """Return a run as estimators are trained on it."""
    speed = float(np.mean(np.abs(readings.speed)))
    group = speed_class(speed)
    combinations = ("longitudinal, lateral, yaw", "left, right")
    raw = np.stack(
        [channel for combination in combinations for channel in motions(readings.boxes.T, combination)], axis=-1
    )
    chain = Chain(rate=RATE, block=BLOCKS[group])
    lateral, yaw = lateral_and_yaw(SLOW, readings.boxes, backwards=readings.backwards)
    return LabelledRun(
        name=name,
        group=group,
        speed=speed,
        friction=friction,
        blocks=chain.process(raw),
        other_blocks={name: replace(chain, **changes(chain)).process(raw) for name, changes in OTHER_CHAINS.items()},
        slow=np.column_stack([lateral, yaw, SLOW.every(readings.speed)]),
    )


def speed_class(speed: float) -> int:
    """Return the nearest of the paper's speeds, mph, for a speed in m/s."""
    return min(BLOCKS, key=lambda mph: abs(mph * MPH - speed))


VEHICLE: Final = 7
"""Seed of the properties of the sensors: the car has the same accelerometers in every run."""


def measure_run(run: Pass, motion: Ride, rate: int, speed: float) -> Readings:
    """Measure the motion of a run, sampled at `rate` a second; rolling wheels vibrate the boxes as at `speed`, m/s."""
    true = np.hstack([motion.longitudinal[:, :, 0], motion.longitudinal[:, :, 1], motion.lateral])
    sensors, noise = generator(VEHICLE, "sensors"), generator(run.seed, f"{run.name}.sensors")
    boxes = measure(true, rate, speed, AXLE_BOX, vehicle=sensors, run=noise)
    samples = np.arange(len(boxes)) * (rate / RATE)
    travelled = np.interp(samples, np.arange(len(motion.speed)), motion.speed)
    return Readings(boxes=boxes, speed=travelled, backwards=run.backwards)


EVERY: Final = 20.0
"""Distance between the spectral features that are kept, m."""
SETTLED: Final = 60.0
"""Distance before the first of them, m."""


def spectral_features(run: LabelledRun) -> Array:
    """Return features every `EVERY` metres after the first `SETTLED` metres, shape (m, features)."""
    speed = run.slow[:, 8]
    every = SPECTRAL.features(run.slow[:, :4], run.slow[:, 4:8], speed)
    metres = np.cumsum(np.abs(speed)) / SPECTRAL.rate
    first, last = max(SETTLED, 2 * SPECTRAL.settling * run.speed), metres[-1]
    return every[np.searchsorted(metres, np.arange(min(first, last), last, EVERY))]


def run_of(run: Pass) -> LabelledRun:
    """Simulate, measure and reduce a pass."""
    motion = ride(run)
    reduced = reduce(run.name, run.friction, measure_run(run, motion, CAR_RATE, float(motion.speed.mean())))
    return replace(
        reduced,
        slip_rate=rms(np.diff(motion.creep, axis=0) * CAR_RATE),
        slip_acceleration=rms(motion.slip_acceleration),
        slope=slope(run),
    )
