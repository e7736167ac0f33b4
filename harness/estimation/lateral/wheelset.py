"""The wheelset of Mal et al. (2020) on a laterally irregular track: conditions, irregularity, tests, and the plant."""

from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from math import pi, sqrt
from typing import Any, Final

import numpy as np
from scipy.signal import cont2discrete, lfilter

from railgrip.base.arrays import generator
from railgrip.base.units import GRAVITY
from railgrip.estimators.belief import Array
from railgrip.fmi import CoSimulation, Description, Port, bind, describe
from railgrip.fmus.build import fmu
from railgrip.scenario.surface import named_set

PERIOD: Final = 50e-6
"""Period of plant, readings and filters [s]; Mal et al. (2020), §4."""

ACCELEROMETER: Final = sqrt(1e-7)
"""Standard deviation of readings of the lateral acceleration [m/s2]; Mal et al., eq. (37)."""

GYROSCOPE: Final = sqrt(1e-13)
"""Standard deviation of readings of the yaw rate [rad/s]; Mal et al., eq. (37)."""

INPUTS: Final = {"track": "m", "mu0": "1", "A_falling": "1", "B_falling": "s/m", "motor_torque": "N.m"}
READINGS: Final = {"lateral_acceleration": "m/s2", "yaw_rate": "rad/s"}
OUTPUTS: Final[Mapping[str, tuple[str, int]]] = {
    **{name: (unit, 0) for name, unit in READINGS.items()},
    "lateral_position": ("m", 0),
    "lateral_velocity": ("m/s", 0),
    "yaw_angle": ("rad", 0),
    "speed": ("m/s", 0),
    "creep": ("1", 2),
    "creep_force": ("N", 2),
    "friction": ("1", 2),
}
_ENDS: Final = np.cumsum([max(size, 1) for _, size in OUTPUTS.values()]).tolist()
COLUMNS: Final = dict(zip(OUTPUTS, map(slice, [0, *_ENDS], _ENDS), strict=True))
"""Columns of each output in a row of the plant's outputs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """A state of the rail.

    Attributes:
        name: Name in tables.
        mu0: Maximum friction coefficient.
        A: Friction at infinite creep speed over `mu0`.
        B: Rate at which friction falls with creep speed [s/m].
    """

    name: str
    mu0: float
    A: float
    B: float


def _condition(name: str, mu0: float, shape: str) -> Condition:
    numbers = named_set(shape)
    return Condition(name=name, mu0=mu0, A=numbers["A"], B=numbers["B"])


# Mal et al. (2020), Table 3; k_A = k_S = 1 for all, the default of the plant.
DRY: Final = _condition("dry", 0.46, "dry_wheelset_study")
WET: Final = _condition("wet", 0.30, "wet_wheelset_study")
POOR: Final = _condition("poor", 0.20, "poor_wheelset_study")
WORST: Final = _condition("worst", 0.10, "poor_wheelset_study")
CONDITIONS: Final = (DRY, WET, POOR, WORST)


@dataclass(frozen=True, slots=True, kw_only=True)
class SurfaceTest:
    """One of the five tests of §4: the conditions of the rail over time.

    Attributes:
        name: Name in tables and files.
        changes: (time [s], condition) in the order of time, the first at 0.
        duration: Duration of the run [s].
    """

    name: str
    changes: tuple[tuple[float, Condition], ...]
    duration: float

    def shorten(self, duration: float) -> "SurfaceTest":
        """Return the same test compressed in time."""
        scale = duration / self.duration
        return SurfaceTest(
            name=self.name, changes=tuple((scale * at, condition) for at, condition in self.changes), duration=duration
        )


PAPER_SENSORS: Final = (ACCELEROMETER, GYROSCOPE)
SERVICE_SENSORS: Final = (0.05, 1e-3)
"""Standard deviations of readings every 50 µs for usual sensors of vehicles: 0.05 m/s2 and 1 mrad/s (estimated)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantVariant:
    """A plant of the study and its sensors.

    Attributes:
        title: Title in tables.
        parameters: Parameters of the plant that differ from Table 1.
        rolling_creep: 1 for longitudinal creepages that include the rotation of the wheels, 0 for those of the filters.
        sensors: Standard deviations of the readings, which the filters know [m/s2, rad/s].
        utilisation: Torque of the motor over wheel radius and axle load, negative in braking.
        irregularity: Lateral deviations of the track over those of the paper.
    """

    title: str
    parameters: Mapping[str, float] = field(default_factory=dict[str, float])
    rolling_creep: float = 0.0
    sensors: tuple[float, float] = PAPER_SENSORS
    utilisation: float = 0.0
    irregularity: float = 1.0


PLANTS: Final[Mapping[str, PlantVariant]] = {
    "paper": PlantVariant(title="plant as the filters know it"),
    "twisting": PlantVariant(title="plant with a twisting axle", rolling_creep=1.0),
    "softer": PlantVariant(title="plant with a contact 5 % softer", parameters={"k_A": 0.95, "k_S": 0.95}),
    "slightly_softer": PlantVariant(title="plant with a contact 1 % softer", parameters={"k_A": 0.99, "k_S": 0.99}),
    "heavier": PlantVariant(title="plant with wheelset mass +5 %", parameters={"m_unsprung": 1.05 * 1250}),
    "yaw_inertia": PlantVariant(title="plant with yaw inertia +5 %", parameters={"I_yaw": 1.05 * 700}),
    "conicity": PlantVariant(title="plant with conicity +10 %", parameters={"conicity": 1.1 * 0.15}),
    "loaded": PlantVariant(title="plant with axle load +10 %", parameters={"m_wheelset": 1.1 * 15000}),
    "service": PlantVariant(title="plant as the filters know it, service sensors", sensors=SERVICE_SENSORS),
    "braking": PlantVariant(title="twisting axle, braking at 0.05", rolling_creep=1.0, utilisation=-0.05),
    "hard_braking": PlantVariant(title="twisting axle, braking at 0.08", rolling_creep=1.0, utilisation=-0.08),
    "traction": PlantVariant(title="twisting axle, traction at 0.05", rolling_creep=1.0, utilisation=0.05),
}
"""The plants of the study. The filters always use Table 1 and the creepages without rotation. Deviations of 1 to 10 %
are well within the uncertainty of real vehicles and contacts."""

STIFFNESS_ERRORS: Final = (-10, -1, 0, 1, 10)
"""Creep stiffness of the plants that test its estimate, against that of the filters [%]."""

IRREGULARITIES: Final = (1.0, 0.3, 0.1)

SENSORS: Final[Mapping[str, tuple[float, float]]] = {"paper": PAPER_SENSORS, "service": SERVICE_SENSORS}

STIFFNESS_PLANTS: Final[Mapping[str, PlantVariant]] = {
    f"stiffness {error:+d} %": PlantVariant(
        title=f"creep stiffness {error:+d} %".replace("-", "−"),
        parameters=dict.fromkeys(("k_A", "k_S"), 1 + error / 100),
    )
    for error in STIFFNESS_ERRORS
}
"""Plants whose creep stiffness differs from that of the filters."""

SMOOTH_PLANTS: Final[Mapping[str, PlantVariant]] = {
    f"{sensors} sensors, {scale:g} of the irregularity": PlantVariant(
        title=f"{sensors} sensors, {scale:g} of the irregularity",
        parameters=dict.fromkeys(("k_A", "k_S"), 0.95),
        sensors=noise,
        irregularity=scale,
    )
    for sensors, noise in SENSORS.items()
    for scale in IRREGULARITIES
}
"""Plants with smaller creepages, on which the creep curve is nearly linear, and a contact 5 % softer."""

ALL_PLANTS: Final[Mapping[str, PlantVariant]] = {**PLANTS, **STIFFNESS_PLANTS, **SMOOTH_PLANTS}

ROLLING: Final = ("twisting", "braking", "hard_braking", "traction")
"""Plants with the rotation of the axle, without and with longitudinal creep from the motor."""

TORQUE: Final = 15000 * GRAVITY * 0.5
"""Torque of the motor that uses an adhesion of 1 [N.m]: axle load and wheel radius of Table 1."""

TESTS: Final = (
    *(SurfaceTest(name=condition.name, changes=((0.0, condition),), duration=10.0) for condition in CONDITIONS),
    SurfaceTest(
        name="transition",
        changes=((0.0, DRY), (2.0, WET), (4.0, POOR), (6.0, WORST), (8.0, WET)),
        duration=10.0,
    ),
)


PEAK: Final = 7e-3
"""Largest lateral deviation of the track in a run [m]."""

CORNER: Final = 2 * pi * 2.0
"""Corner of the spectrum of the track [rad/s]. Mal et al. specify "random, ±7 mm" and no spectrum: the corner, in time
and so independent of speed, is a choice."""

DAMPING: Final = 1 / sqrt(2)


def draw_track(seed: int, count: int, period: float) -> tuple[Array, Array]:
    """Return lateral position [m] and velocity [m/s] of the track at `count` samples, each of shape (count,).

    White Gaussian noise through a low-pass of second order, from rest: the one-sided spectrum is
    S(f) ∝ 1/(1 + (f/corner)⁴) for the damping 1/√2 (Butterworth). Each run is scaled to a largest deviation of `PEAK`.
    """
    low_pass = [1.0, 2 * DAMPING * CORNER, CORNER * CORNER]
    noise = generator(seed, "track").standard_normal(count)
    position = _through(noise, [CORNER * CORNER], low_pass, period)
    velocity = _through(noise, [CORNER * CORNER, 0.0], low_pass, period)
    scale = PEAK / np.max(np.abs(position))
    return scale * position, scale * velocity


def track_acceleration_density(deviation: float) -> float:
    """Return the density [m2/s3] of the white acceleration behind a stationary track of this deviation [m]."""
    return 4 * DAMPING * CORNER**3 * deviation**2


def _through(noise: Array, numerator: list[float], denominator: list[float], period: float) -> Array:
    discrete: Any = cont2discrete((numerator, denominator), period, method="zoh")
    return np.asarray(lfilter(np.ravel(discrete[0]), discrete[1], noise), dtype=np.float64)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LateralInputs:
    """Track, rail and noise of one run, sample by sample.

    Attributes:
        inputs: Inputs of the plant during each step, in the order of `INPUTS`, shape (K, 5).
        track_rate: Derivative of the track [m/s], shape (K,).
        noise: Noise of the readings at the end of each step, shape (K, 2).
        segments: First and last (exclusive) step under each condition.
        conditions: Condition of each segment.
    """

    inputs: Array
    track_rate: Array
    noise: Array
    segments: tuple[tuple[int, int], ...]
    conditions: tuple[Condition, ...]


def course(test: SurfaceTest, seed: int, variant: PlantVariant = PLANTS["paper"]) -> LateralInputs:
    """Return track, rail, torque and sensor noise of one run; the same seed gives the same run."""
    count = round(test.duration / PERIOD)
    starts = [round(at / PERIOD) for at, _ in test.changes]
    segments = tuple(zip(starts, [*starts[1:], count], strict=True))
    conditions = tuple(condition for _, condition in test.changes)
    track, rate = (variant.irregularity * each for each in draw_track(seed, count, PERIOD))
    inputs = np.zeros((count, len(INPUTS)))
    inputs[:, 0] = track
    inputs[:, 4] = variant.utilisation * TORQUE
    for (first, last), condition in zip(segments, conditions, strict=True):
        inputs[first:last, 1:4] = condition.mu0, condition.A, condition.B
    noise = generator(seed, "sensors").standard_normal((count, 2)) * variant.sensors
    return LateralInputs(inputs=inputs, track_rate=rate, noise=noise, segments=segments, conditions=conditions)


@contextmanager
def wheelset(speed: float, variant: PlantVariant = PLANTS["paper"]) -> Generator[CoSimulation]:
    """Open the plant `LateralWheelset`.

    Args:
        speed: Initial speed along the track [m/s].
        variant: Parameters that differ from Table 1.
    """
    description, binding = _bind()
    parameters = {"start_speed": speed, "rolling_creep": variant.rolling_creep, **variant.parameters}
    with CoSimulation(description, binding, period=PERIOD, parameters=parameters) as plant:
        yield plant


@cache
def _bind() -> tuple[Description, Any]:
    description = describe(fmu("LateralWheelset"))
    inputs = [Port(name=name, unit=unit, size=0, needed=True) for name, unit in INPUTS.items()]
    outputs = [Port(name=name, unit=unit, size=size, needed=True) for name, (unit, size) in OUTPUTS.items()]
    return description, bind(description, inputs=inputs, outputs=outputs, where="the wheelset LateralWheelset")
