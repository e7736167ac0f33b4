"""What takes part in a stop, and what the loop asks of each part."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from railgrip.controllers.observation import Observation
from railgrip.controllers.sampled import Sampled
from railgrip.simulate.loop.driver import Driver
from railgrip.simulate.loop.faults import Faults
from railgrip.simulate.loop.plausible import Slowing
from railgrip.simulate.loop.rail import TabulatedRail
from railgrip.simulate.loop.sensors import IdealSensors, ServiceSensors
from railgrip.trace.recorder import Recorder
from railgrip.vehicle.signals import Layout, Signal

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Indices = NDArray[np.intp]


@runtime_checkable
class Plant(Protocol):
    """The simulated truth; vectors as `railgrip.vehicle.signals.Layout` orders them.

    A `railgrip.fmi.CoSimulation` is stepped from C, any other plant by these methods.
    """

    def start(self, inputs: Vector) -> Vector:
        """Initialise with `inputs` applied and return the outputs at the start time."""
        ...

    def step(self, inputs: Vector) -> Vector:
        """Hold `inputs` over one communication period and return the outputs at its end; PlantFailed ends the stop."""
        ...


@runtime_checkable
class Sensors(Protocol):
    """What the train's instruments make of the truth; those of `railgrip.simulate.loop.sensors` are called from C."""

    def read(self, sample: int, truth: Vector) -> Vector:
        """Return the reading of one of their own samples, ordered as in `railgrip.vehicle.signals.Layout`.

        NaN where there is no new one; `Clock.sensors` says how often they sample. SensorsFailed ends the stop.
        """
        ...


Instruments = Sensors | IdealSensors | ServiceSensors


@runtime_checkable
class Filter(Protocol):
    """A belief about the train that moves on in place: the arrays stay the same, their values change.

    A filter on values becomes one by `railgrip.estimators.ekf.Running`; one that is a
    `railgrip.estimators.compiled.StepInC` is stepped from C.

    Attributes:
        mean: Shape (n,).
        covariance: Shape (n, n).
        inputs: Inputs during the next period, shape (nu,); written by the loop.
        readings: Readings at its end, NaN where nothing new was read, shape (m,); written by the loop.
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
        """Normalised innovation squared of the last step, of `selection.sum()` degrees; 0 before the first."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class StateEstimator:
    """A filter that holds its first belief, and where its states and readings stand.

    Attributes:
        filter: Its inputs are the pressures first; the rest (track force) is not known to the train and stays zero.
        reading_places: Entries of a reading that the filter takes, in its order.
        speed: Index of the train speed among the states.
        wheelset_speed: Indices of the wheelset speeds.
        adhesion: Indices of the adhesions.
        pad_friction: Indices of the pad frictions.
        wheel_radius: As the estimator believes it, one for each group [m].
        free_wheel: Given the reading of the speed, those of the wheelset speeds and of the pressures, returns the
            speed that the filter takes, and 1 for each group that is to be released; None where nothing stands in for
            the radar.
        load_deviation: Standard deviation of a wheelset's load over the one that the filter knows.
    """

    filter: Filter
    reading_places: Indices
    speed: int
    wheelset_speed: Indices
    adhesion: Indices
    pad_friction: Indices
    wheel_radius: tuple[float, ...]
    free_wheel: Sampled | None = None
    load_deviation: float = 0.0


@runtime_checkable
class DirectEstimator(Protocol):
    """An estimator that gives quantities themselves, not states with a covariance.

    Attributes:
        provides: Names of `railgrip.vehicle.signals.ESTIMATES` without their prefix.
    """

    provides: tuple[str, ...]

    def step(self, observation: Observation) -> Mapping[str, Vector]:
        """Return all that it provides, from what is read now; EstimatorFailed ends the stop."""
        ...


@runtime_checkable
class Controller(Protocol):
    """A control law; a `railgrip.controllers.sampled.Sampled` is called from C."""

    def decide(self, observation: Observation) -> Sequence[float] | Vector:
        """Return the demanded brake cylinder pressure of each group [Pa]; ControllerFailed ends the stop."""
        ...


class Limits(Protocol):
    """What limits the demands of a controller from outside of this project.

    Attributes:
        most: Highest pressure of each group; demands between none and these are not looked at once `is_pascal` [Pa].
        is_pascal: Whether the demands have been large enough to be in Pa.
    """

    most: Vector
    is_pascal: bool

    def limit(self, demands: Vector, observation: Observation) -> Vector:
        """Return demands that cylinders take [Pa]; ControllerFailed ends the stop."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class LawStates:
    """States of a law that are kept beside what it demanded.

    Attributes:
        signals: Their columns.
        values: The law's states, where they stand.
        places: Of those that are shown, in the order of `signals`.
    """

    signals: tuple[Signal, ...]
    values: Vector
    places: NDArray[np.longlong]


@dataclass(frozen=True, slots=True, kw_only=True)
class Clock:
    """Integer time: everything happens at whole multiples of the communication period.

    A part is due at the first sample at or after each multiple of its own period.

    Attributes:
        period: Communication period [s].
        estimator: Communication periods in a period of the estimator, not necessarily a whole number.
        controller: The same for the controller.
        samples: Communication periods until the horizon.
        sensors: Communication periods between two readings; in between there is nothing new.
    """

    period: float
    estimator: Fraction | int
    controller: Fraction | int
    samples: int
    sensors: int = 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Parts:
    """The parts of one stop, none of them started.

    Attributes:
        layout: Of the vectors that they exchange.
        plant: The simulated truth.
        rail: Friction and force along the track.
        sensors: Instruments.
        estimator: None if the controller sees readings only.
        controller: The law; the caller of the loop may decide in its place.
        limits: What its demands are limited by, if they are.
        over: What is decided for the train as a whole over a law in Python, which it takes for the pressures read.
        valves: From demanded and read pressures to the commands of valves; None sends the demands themselves.
        driver: The most that may be demanded, and traction.
        faults: Of sensors and brakes, if there are any: what sensors show, and what of a command arrives at the plant.
        wheel_radius: Nominal radii for a slip from readings [m].
        law: What of the controller's states is kept, if any is.
        clock: Periods and horizon.
        slowing: Bounds of what slows the plant beside adhesion.
        start_speed: Requested speed of the plant at the start [m/s].
        stop_speed: The train stands below this speed [m/s]; one that starts at rest, once it has been faster or brakes
            are demanded.
        recorder: Written from row 0 on; holds clock.samples + 1 rows.
    """

    layout: Layout
    plant: Plant
    rail: TabulatedRail
    sensors: Instruments
    estimator: StateEstimator | DirectEstimator | None
    controller: Controller
    limits: Limits | None = None
    over: Sampled | None = None
    valves: Sampled | None
    driver: Driver
    faults: Faults | None = None
    wheel_radius: tuple[float, ...]
    law: LawStates | None = None
    clock: Clock
    slowing: Slowing
    start_speed: float
    stop_speed: float
    recorder: Recorder
