"""What the loop asks of each party."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from railgrip.controllers.observation import Observation
from railgrip.signals import Signal

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CInterface:
    """A communication step of a plant as C sees it.

    Attributes:
        cross: Address of `int cross(void *plan, int what, double time)`, as `harness/fmu/kernel/set_step_get.c` has it.
        plan: Address of its first argument.
        inputs: Read by it, shape (Layout.inputs,).
        outputs: Written by it: those that the plant has.
        present: Their places among all outputs.
        input_names, output_names: Of what is in `inputs` and `outputs`.
        period: Of the step [s].
        sample: At which the plant is.
        slip_radius: Nominal radii, shape (groups,) [m], where slip follows from the speeds; None: it is an output.
    """

    cross: int
    plan: int
    inputs: Vector
    outputs: Vector
    present: NDArray[np.intp]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    period: float
    sample: int
    slip_radius: Vector | None = None


@runtime_checkable
class Plant(Protocol):
    """The simulated truth; vectors as `railgrip.signals.Layout` orders them."""

    def start(self, inputs: Vector) -> Vector:
        """Initialise with `inputs` applied and return the outputs at the start time."""
        ...

    def step(self, inputs: Vector) -> Vector:
        """Hold `inputs` over one communication period and return the outputs at its end."""
        ...


@runtime_checkable
class PlantInC(Protocol):
    """A plant that C can step, and that takes note of how far that went."""

    def start(self, inputs: Vector) -> Vector:
        """Initialise with `inputs` applied and return the outputs at the start time."""
        ...

    def c_interface(self) -> CInterface:
        """Return how, once started."""
        ...

    def note_steps(self, steps: int, code: int) -> None:
        """Take note of steps done by C and of the outcome that ended them early, if not 0; raise PlantFailed then."""
        ...


@runtime_checkable
class Sensors(Protocol):
    """What the train's instruments make of the truth."""

    def read(self, sample: int, truth: Vector) -> Vector:
        """Return the reading of one of their own samples, ordered as in `railgrip.signals.Layout`.

        NaN where there is no new one; `Clock.sensors` says how often they sample. SensorsFailed ends the stop.
        """
        ...


@runtime_checkable
class Filter(Protocol):
    """A belief about the train that moves on in place: the arrays stay the same, their values change.

    A filter on values becomes one by `railgrip.estimators.ekf.Running`.

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


@runtime_checkable
class FilterInC(Protocol):
    """An estimator as `railgrip.estimators.compiled.CompiledFilter`."""

    mean: Vector
    covariance: Matrix
    inputs: Vector
    readings: Vector
    selection: Vector

    @property
    def entry(self) -> tuple[int, int, int]:
        """Addresses of its step, of the argument of that, and of the squared innovation."""
        ...

    def failure(self, outcome: int) -> str:
        """Return what a number that its step returns means."""
        ...


@runtime_checkable
class DirectEstimator(Protocol):
    """An estimator that gives quantities themselves, not states with a covariance.

    Attributes:
        provides: Names of `railgrip.signals.ESTIMATES` without their prefix.
    """

    provides: tuple[str, ...]

    def step(self, observation: Observation) -> Mapping[str, Vector]:
        """Return all that it provides, from what is read now; EstimatorFailed ends the stop."""
        ...


class Calculation(Protocol):
    """A sampled function with memory."""

    def call(self, inputs: Sequence[float], /) -> Sequence[float]:
        """Return its outputs for these inputs, and remember."""
        ...


@runtime_checkable
class Controller(Protocol):
    """A control law."""

    def decide(self, observation: Observation) -> Sequence[float]:
        """Return the demanded brake cylinder pressure of each group [Pa]; ControllerFailed ends the stop."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class LawStates:
    """What a law says of itself: it is kept beside what it demanded.

    Attributes:
        signals: Their columns.
        values: The law's states, where they stand.
        places: Of those that are shown, in the order of `signals`.
    """

    signals: tuple[Signal, ...]
    values: Vector
    places: NDArray[np.longlong]


@runtime_checkable
class Actuation(Protocol):
    """From demanded pressures to what the plant takes."""

    def command(self, demands: Sequence[float], measured: Vector) -> Sequence[float]:
        """Return the command for each group, from demanded and measured pressures [Pa]."""
        ...


@runtime_checkable
class Rail(Protocol):
    """What the track does to the train."""

    def lay(self, inputs: Vector) -> None:
        """Write what the plant is sent of it where the train was last, at first where it starts."""
        ...

    def meet(self, truth: Vector) -> None:
        """Refuse a plant that does not show, at its start, what the rail depends on; raise ScenarioError."""
        ...

    def roll(self, time: float, truth: Vector) -> None:
        """Find what it is at a time with these outputs of the plant; times come in order."""
        ...
