"""The parts of a stop, and the interface that the loop requires of each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from railgrip.base.arrays import Indices, Matrix, Vector
from railgrip.controllers.observation import Observation
from railgrip.controllers.sampled import Sampled
from railgrip.fmus.native.toolchain import Struct
from railgrip.scenario.adhesion import TabulatedRail
from railgrip.scenario.demand import Driver
from railgrip.simulate.loop.plausible import Plausibility
from railgrip.simulate.value_checks import DemandLimits
from railgrip.trace.recorder import Recorder
from railgrip.vehicle.signals import Layout, Signal

BLOCK = 1024
"""Number of readings whose noise is drawn at once."""


@runtime_checkable
class LoopPlant(Protocol):
    """The simulated vehicle; vectors in the order of `railgrip.vehicle.signals.Layout`.

    A `railgrip.fmi.CoSimulation` is stepped from C, any other plant by these methods.
    """

    def start(self, inputs: Vector) -> Vector:
        """Start with `inputs`; return the outputs at the start time."""
        ...

    def step(self, inputs: Vector) -> Vector:
        """Hold `inputs` over one communication period and return the outputs at its end; PlantFailed ends the stop."""
        ...


@runtime_checkable
class LoopSensors(Protocol):
    """Instruments of the train in Python."""

    def read(self, sample: int, truth: Vector) -> Vector:
        """Return the reading of one of the sensors' samples, in the order of `railgrip.vehicle.signals.Layout`.

        Readings that are not new are NaN; `Clock.sensors` is the sampling interval. SensorsFailed ends the stop.
        """
        ...


@runtime_checkable
class SensorsInC(Protocol):
    """Instruments of the train that are called from C.

    Attributes:
        fields: Fields of `Instruments` in cycle.h.
    """

    fields: Mapping[str, object]

    def draw(self) -> None:
        """Draw the noise of the next block; due before every reading that is a multiple of `BLOCK`."""
        ...


def draw_block(noise: NDArray[np.float64], random: np.random.Generator, draws: int) -> None:
    """Fill `noise`, whose rows are readings, with the first of every `draws` rows that `random` draws.

    Noise is drawn at the period of the instruments, so a loop that reads only some of their samples gets the same noise
    at the same instants.
    """
    noise[:] = random.standard_normal((len(noise) * draws, *noise.shape[1:]))[::draws]


@runtime_checkable
class Filter(Protocol):
    """An estimate of the train's state that is updated in place: the arrays stay the same, their values change.

    `railgrip.estimators.ekf.NumpyFilter` makes one of a filter that maps estimates to estimates; a
    `railgrip.estimators.compiled.StepInC` is stepped from C.

    Attributes:
        mean: Mean of the state, shape (n,).
        covariance: Covariance of the state, shape (n, n).
        inputs: Inputs during the next period, shape (nu,); written by the loop.
        readings: Readings at the end of the period, NaN for those that are not new, shape (m,); written by the loop.
        selection: 1 for every reading that the last step used, else 0, shape (m,).
    """

    mean: Vector
    covariance: Matrix
    inputs: Vector
    readings: Vector
    selection: Vector

    def advance(self) -> None:
        """Predict over one period with `inputs`, then condition on `readings`; ArithmeticError when that fails."""
        ...

    @property
    def squared_innovation(self) -> float:
        """Normalised innovation squared of the last step, with `selection.sum()` degrees of freedom.

        It is 0 before the first step.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class StateEstimator:
    """A filter in its initial state, with the positions of its states and readings.

    Attributes:
        filter: Its first inputs are the pressures. Of the force of the track, traction and `body_force` are known on
            board; the others (gradient, curves) are unknown and count as zero.
        reading_places: Positions in a reading of those that the filter uses, in its order.
        speed: Index of the train speed among the states.
        wheelset_speed: Indices of the wheelset speeds.
        adhesion: Indices of the adhesions.
        pad_friction: Indices of the pad frictions.
        wheel_radius: Wheel radius that the estimator assumes, for each group [m].
        free_wheel: Given the readings of speed, wheelset speeds and pressures, it returns the speed for the filter, and
            1 for each group that is to be released; None if the radar has no substitute.
        body_force: Braking force on the body [N], see `railgrip.simulate.estimator`; None without any.
        track_force: Index of the force of the track among the inputs; -1 without it.
        load_deviation: Relative standard deviation of a wheelset's load.
    """

    filter: Filter
    reading_places: Indices
    speed: int
    wheelset_speed: Indices
    adhesion: Indices
    pad_friction: Indices
    wheel_radius: tuple[float, ...]
    free_wheel: Sampled | None = None
    body_force: Sampled | None = None
    track_force: int = -1
    load_deviation: float = 0.0


@runtime_checkable
class DirectEstimator(Protocol):
    """An estimator that returns quantities, not states with a covariance.

    Attributes:
        provides: Names of `railgrip.vehicle.signals.ESTIMATES` without their prefix.
    """

    provides: tuple[str, ...]

    def step(self, observation: Observation) -> Mapping[str, Vector]:
        """Return all quantities that it provides, from an observation; EstimatorFailed ends the stop."""
        ...


@runtime_checkable
class LoopController(Protocol):
    """A control law; a `railgrip.controllers.sampled.Sampled` is called from C."""

    def decide(self, observation: Observation) -> Sequence[float] | Vector:
        """Return the demanded brake cylinder pressure of each group [Pa]; ControllerFailed ends the stop."""
        ...


class LoopFaults(Protocol):
    """Faults of readings and commands.

    Attributes:
        struct: `Faults` of faults.h; its arrays live as long as this object.
    """

    struct: Struct


@dataclass(frozen=True, slots=True, eq=False)
class LawStates:
    """States of a law that are recorded in addition to its demands.

    Attributes:
        signals: Columns of the states.
        values: State vector of the law.
        places: Positions of the recorded states in it, in the order of `signals`.
    """

    signals: tuple[Signal, ...]
    values: Vector
    places: NDArray[np.longlong]


@dataclass(frozen=True, slots=True, kw_only=True)
class Clock:
    """Integer time: everything happens at whole multiples of the communication period.

    A part is due at the first sample at or after each multiple of its period.

    Attributes:
        period: Communication period [s].
        estimator: Period of the estimator in communication periods, not necessarily a whole number.
        controller: Period of the controller, as for the estimator.
        samples: Number of communication periods until the horizon.
        sensors: Communication periods between two readings; in between no reading is new.
    """

    period: float
    estimator: Fraction | int
    controller: Fraction | int
    samples: int
    sensors: int = 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Parts:
    """The parts of one stop, not yet started.

    Attributes:
        layout: Layout of the vectors that they exchange.
        plant: The simulated vehicle.
        rail: Friction and force along the track.
        sensors: Instruments.
        estimator: None if the controller sees readings only.
        controller: The law; the caller of the loop may decide in its place.
        limits: Limits on the controller's demands; None for built-in laws.
        train_level: From observation and demands of a law in Python to demands that suit the train as a whole.
        valves: From demanded and read pressures to valve commands; None sends the demands directly.
        full: Pressure of full brake, shape (groups,) [Pa]: the demand of a train without driver.
        driver: Maximum demand, and traction; None for full brake.
        faults: Faults of sensors and brakes, which change readings and commands; None for an intact train.
        wheel_radius: Nominal radii for a slip from readings [m].
        law: States of the controller that are recorded, or None.
        clock: Periods and horizon.
        plausibility: Checks of the plant's outputs.
        stop_speed: Speed below which the train has stopped [m/s]; a train that starts at rest must first have been
            faster, or brakes must be demanded.
        recorder: Written from row 0 on; has clock.samples + 1 rows, or fewer, of which the last one is overwritten.
    """

    layout: Layout
    plant: LoopPlant
    rail: TabulatedRail
    sensors: LoopSensors | SensorsInC
    estimator: StateEstimator | DirectEstimator | None
    controller: LoopController
    limits: DemandLimits | None = None
    train_level: Sampled | None = None
    valves: Sampled | None
    full: Vector
    driver: Driver | None = None
    faults: LoopFaults | None = None
    wheel_radius: tuple[float, ...]
    law: LawStates | None = None
    clock: Clock
    plausibility: Plausibility
    stop_speed: float
    recorder: Recorder
