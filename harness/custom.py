"""Controllers, estimators, sensors and plants of a user: what each is asked, and how it takes part in a stop."""

import inspect
import traceback
from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railgrip.controllers.observation import Observation
from railgrip.errors import ControllerFailed, EstimatorFailed, PlantFailed, ScenarioError, SensorsFailed
from railgrip.formation import Extent, Formation
from railgrip.signals import ESTIMATES, EXTRA, EXTRA_READINGS, PLANT, READINGS, SENT, Layout

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Estimate:
    """What an estimator of one's own gives: all that it says it provides, and None for the rest.

    Attributes:
        speed: Of the train [m/s].
        wheelset_speed: Shape (groups,) [rad/s].
        slip: Shape (groups,) [1].
        adhesion: Shape (groups,), positive in braking [1].
        pad_friction: Shape (groups,) [1].
        adhesion_sd: Standard deviation of `adhesion`, shape (groups,) [1].
        pad_friction_sd: The same of `pad_friction`.
    """

    speed: float | None = None
    wheelset_speed: ArrayLike | None = None
    slip: ArrayLike | None = None
    adhesion: ArrayLike | None = None
    pad_friction: ArrayLike | None = None
    adhesion_sd: ArrayLike | None = None
    pad_friction_sd: ArrayLike | None = None


PROVIDED = tuple(field.name for field in fields(Estimate))
"""What an estimator may provide."""


@runtime_checkable
class Controller(Protocol):
    """A control law. It may have an attribute `needs`, the estimates that it cannot do without: ("adhesion",)."""

    def start(self, formation: Formation) -> None:
        """Begin a stop; also after another one."""
        ...

    def decide(self, observation: Observation) -> ArrayLike:
        """Return the demanded brake cylinder pressure of each group, shape (groups,) [Pa]."""
        ...


@runtime_checkable
class Estimator(Protocol):
    """What is believed about the train.

    Attributes:
        provides: Names of the fields of `Estimate` that each step gives; for all others the trace has no variable and
            the controller sees None, or what is read.
    """

    provides: tuple[str, ...]

    def start(self, first: Observation, formation: Formation) -> None:
        """Begin a stop with what is read first; also after another one."""
        ...

    def step(self, observation: Observation) -> Estimate:
        """Return the estimates from what is read now; called each period of the estimator, with `first`, too."""
        ...


@runtime_checkable
class Sensors(Protocol):
    """What the train's instruments make of the truth."""

    def start(self, formation: Formation, random: np.random.Generator) -> None:
        """Begin a stop; all noise comes from `random`, which the seed of the scenario decides."""
        ...

    def read(self, time: float, truth: Mapping[str, Array]) -> Mapping[str, ArrayLike]:
        """Return speed, wheelset_speed, deflection, acceleration and cylinder_pressure, in SI units.

        Args:
            time: Since the brake demand [s]; called each communication period, from 0 on.
            truth: By the names of a trace's variables, such as speed, wheelset_speed and slip.

        A reading that is left out, or NaN, brings nothing new.
        """
        ...


@runtime_checkable
class Plant(Protocol):
    """The train itself."""

    def start(self, formation: Formation, speed: float, period: float) -> Mapping[str, ArrayLike]:
        """Begin a stop, also after another one, and return what the train shows at the brake demand; see `step`.

        Args:
            formation: Of the scenario; brakes and loads are nominal.
            speed: At the start [m/s].
            period: Of each step [s].
        """
        ...

    def step(self, inputs: Mapping[str, Array]) -> Mapping[str, ArrayLike]:
        """Hold `inputs` over one period and return what the train shows at its end.

        Args:
            inputs: pressure_command (groups,) [Pa], or valve_command [1] with pneumatic actuation; mu0 (wheelsets,)
                [1], track_force () [N]; curve_k_A, curve_k_S, curve_A [1] and curve_B [s/m] (wheelsets,) where the
                rail has several creep curves.

        Returns:
            By the names of a trace's variables and in their units, the same at each step: distance, speed,
            acceleration, wheelset_speed and cylinder_pressure, and of slip, adhesion, wheelset_load, brake_torque and
            the others what the plant has. Slip that it does not show follows from the speeds.
        """
        ...


class CustomController:
    """A control law of the user's own in the loop."""

    def __init__(self, own: Controller, formation: Formation) -> None:
        """Start it.

        Raises:
            ScenarioError: It is no controller, or fails to start.
        """
        _demand_methods(own, "a controller", "start", "decide")
        self._own, self._groups = own, formation.groups
        self.needs: tuple[str, ...] = tuple(getattr(own, "needs", ()))
        _called(ScenarioError, own, "start", formation)

    def decide(self, observation: Observation) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa].

        Raises:
            ControllerFailed: It raised an exception, or returned something else.
        """
        when = f" At {observation.time:.3f} s."
        demands = _called(ControllerFailed, self._own, "decide", _locked(observation), when=when)
        wrong = problem_with(demands, (self._groups,))
        if wrong:
            expected = f"the demanded pressures [Pa] of {self._groups} groups, shape ({self._groups},)"
            raise ControllerFailed(f"{_place(self._own, 'decide')} returned {wrong}, not {expected}.{when}")
        return tuple(np.asarray(demands, dtype=np.float64).tolist())


class CustomEstimator:
    """An estimator of the user's own in the loop.

    Attributes:
        provides: As it says.
    """

    def __init__(self, own: Estimator, formation: Formation) -> None:
        """Take it; it is started by the first step.

        Raises:
            ScenarioError: It is no estimator, or does not say what it provides.
        """
        _demand_methods(own, "an estimator", "start", "step")
        provides: Any = getattr(own, "provides", None)
        if not isinstance(provides, tuple | list) or not provides or not set(provides) <= set(PROVIDED):
            raise ScenarioError(
                f"{type(own).__name__}: `provides` is {provides!r}; an estimator says there what its steps give, of "
                f'{", ".join(PROVIDED)}, as in provides = ("adhesion",)'
            )
        self._own, self._formation, self._has_started = own, formation, False
        self.provides: tuple[str, ...] = tuple(dict.fromkeys(provides))
        extent: dict[str, Extent] = {signal.name.removeprefix("estimate_"): signal.extent for signal in ESTIMATES}
        self._shapes = {
            name: () if extent[name] == "train" else (formation.width(extent[name]),) for name in self.provides
        }

    def step(self, observation: Observation) -> Mapping[str, Array]:
        """Return what it provides, each at least of one dimension.

        Raises:
            EstimatorFailed: It raised an exception, or gave something else than it provides.
        """
        own = self._own
        if not self._has_started:
            _called(EstimatorFailed, own, "start", _locked(observation), self._formation)
            self._has_started = True
        estimate = _called(EstimatorFailed, own, "step", _locked(observation))
        if not isinstance(estimate, Estimate):
            raise EstimatorFailed(f"{_place(own, 'step')} returned {_short(estimate)}, not an Estimate.")
        values = {name: value for name in PROVIDED if (value := getattr(estimate, name)) is not None}
        if values.keys() != set(self.provides):
            raise EstimatorFailed(
                f"{_place(own, 'step')} gave {', '.join(values) or 'nothing'}; it provides {', '.join(self.provides)}."
            )
        for name, value in values.items():
            wrong = problem_with(value, self._shapes[name])
            if wrong:
                raise EstimatorFailed(
                    f"{_place(own, 'step')} gave {name} as {wrong}, not finite numbers of shape {self._shapes[name]}."
                )
        return {name: np.array(value, dtype=np.float64, ndmin=1) for name, value in values.items()}


class CustomSensors:
    """Sensors of the user's own in the loop."""

    def __init__(
        self, own: Sensors, layout: Layout, formation: Formation, period: float, random: np.random.Generator
    ) -> None:
        """Start them.

        Raises:
            ScenarioError: They are no sensors, or fail to start.
        """
        _demand_methods(own, "a sensor model", "start", "read")
        self._own, self._layout, self._period = own, layout, period
        self._truth, self._truth_by_name = _by_name(layout.outputs, layout.output)
        self._shapes = _shapes(layout.reading)
        _called(ScenarioError, own, "start", formation, random)

    def read(self, sample: int, truth: Array) -> Array:
        """Return the reading of a sample; NaN where there is no new one.

        Raises:
            SensorsFailed: They raised an exception, or gave something else than readings.
        """
        self._truth[:] = truth
        time = sample * self._period
        when = f" At {time:.3f} s."
        readings = _called(SensorsFailed, self._own, "read", time, self._truth_by_name, when=when)
        if not isinstance(readings, Mapping) or not readings.keys() <= self._shapes.keys():
            raise SensorsFailed(
                f"{_place(self._own, 'read')} returned {_short(readings)}, not readings of {', '.join(self._shapes)} "
                f"by name.{when}"
            )
        reading = np.full(self._layout.readings, np.nan)
        for name, value in readings.items():
            problem = problem_with(value, self._shapes[name], nan=True)
            if problem:
                raise SensorsFailed(
                    f"{_place(self._own, 'read')} gave {name} as {problem}, not numbers of shape "
                    f"{self._shapes[name]}.{when}"
                )
            reading[self._layout.reading[name]] = value
        return reading


class CustomPlant:
    """A plant of the user's own in the loop."""

    def __init__(
        self, own: Plant, layout: Layout, *, speed: float, period: float, required: Collection[str], command: str
    ) -> None:
        """Take it; the loop starts it.

        Args:
            required: Names of outputs that it cannot do without.
            command: Name of its command to the brakes.

        Raises:
            ScenarioError: It is no plant.
        """
        _demand_methods(own, "a plant", "start", "step")
        self._own, self._layout, self._speed, self._period = own, layout, speed, period
        self._required, self._output_names, self._steps = frozenset(required), frozenset[str](), 0
        self._inputs, inputs = _by_name(layout.inputs, layout.input)
        self._inputs_by_name = {command if name == "command" else name: value for name, value in inputs.items()}
        self._shapes = _shapes(layout.output)

    def start(self, inputs: Array) -> Array:
        """Start it and return what it shows; NaN for what it does not.

        Raises:
            PlantFailed: It raised an exception, or showed something else.
        """
        self._steps = 0
        formation = self._layout.formation
        outputs = _called(PlantFailed, self._own, "start", formation, self._speed, self._period, when=self._when)
        if not isinstance(outputs, Mapping) or not self._required <= outputs.keys() <= self._shapes.keys():
            raise PlantFailed(
                f"{_place(self._own, 'start')} returned {_short(outputs)}; a plant shows "
                f"{', '.join(sorted(self._required))}, and may show "
                f"{', '.join(sorted(self._shapes.keys() - self._required))}."
            )
        self._output_names = frozenset(outputs)
        return self._vector("start", outputs)

    def step(self, inputs: Array) -> Array:
        """Step it and return what it shows, as `start`."""
        self._inputs[:] = inputs
        self._steps += 1
        outputs = _called(PlantFailed, self._own, "step", self._inputs_by_name, when=self._when)
        if not isinstance(outputs, Mapping) or self._output_names.symmetric_difference(outputs):
            raise PlantFailed(
                f"{_place(self._own, 'step')} returned {_short(outputs)}, not what it showed at the start, "
                f"{', '.join(sorted(self._output_names))}.{self._when}"
            )
        return self._vector("step", outputs)

    @property
    def _when(self) -> str:
        return f" At {self._steps * self._period:.3f} s."

    def _vector(self, method: str, outputs: Mapping[str, ArrayLike]) -> Array:
        truth = np.full(self._layout.outputs, np.nan)
        for name, value in outputs.items():
            problem = problem_with(value, self._shapes[name])
            if problem:
                raise PlantFailed(
                    f"{_place(self._own, method)} showed {name} as {problem}, not finite numbers of shape "
                    f"{self._shapes[name]}.{self._when}"
                )
            truth[self._layout.output[name]] = value
        return truth


_OF_TRAIN = frozenset(
    s.name.removeprefix("reading_") for s in (*PLANT, *EXTRA, *READINGS, *EXTRA_READINGS, *SENT) if s.extent == "train"
)


def _shapes(places: Mapping[str, slice]) -> dict[str, tuple[int, ...]]:
    return {name: () if name in _OF_TRAIN else (place.stop - place.start,) for name, place in places.items()}


def _by_name(length: int, places: Mapping[str, slice]) -> tuple[Array, dict[str, Array]]:
    """Return a vector that we write, and the signals in it, which nobody else can write."""
    vector = np.empty(length)
    view = vector.view()
    view.flags.writeable = False
    return vector, {name: view[places[name]].reshape(shape) for name, shape in _shapes(places).items()}


def _locked(observation: Observation) -> Observation:
    """Return an observation whose arrays, which others read, too, cannot be written."""
    for value in observation:
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return observation


def problem_with(value: Any, shape: tuple[int, ...], *, nan: bool = False) -> str:
    """Return what a value is that should have been finite numbers of a shape; empty if it is that."""
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        return _short(value)
    if numbers.shape != shape:
        return f"numbers of shape {numbers.shape}"
    good = np.isfinite(numbers) | np.isnan(numbers) if nan else np.isfinite(numbers)
    return "" if bool(np.all(good)) else str(numbers.tolist())


def _short(value: object) -> str:
    text = repr(value)
    return f"{type(value).__name__} {text if len(text) <= 80 else text[:77] + '...'}"


def _demand_methods(own: object, what: str, *names: str) -> None:
    missing = [name for name in names if not callable(getattr(own, name, None))]
    if missing:
        lacks, wants = " and ".join(missing), " and ".join(names)
        raise ScenarioError(f"{type(own).__name__}: has no method {lacks}; {what} has {wants}")


def _called(failed: type[Exception], own: object, method: str, *arguments: object, when: str = "") -> Any:
    """Return what a method of the user's class returns, or raise `failed` with a sentence."""
    try:
        return getattr(own, method)(*arguments)
    except Exception as problem:
        raise failed(_failure(own, method, problem) + when) from problem


def _place(own: object, method: str) -> str:
    """Return class, method, and where that is written."""
    name, code = f"{type(own).__name__}.{method}", getattr(getattr(own, method, None), "__code__", None)
    return name if code is None else f"{name} ({_file(code.co_filename)}, line {code.co_firstlineno})"


def _failure(own: object, method: str, problem: Exception) -> str:
    """Return an exception of the user's class as a sentence, with the last line of their file that led to it."""
    frames = traceback.extract_tb(problem.__traceback__)[1:]  # the first one is the call from here
    try:
        file = inspect.getsourcefile(type(own))
    except TypeError:
        file = None
    theirs = [frame for frame in frames if frame.filename == file] or frames[:1]
    what = f"{type(problem).__name__}: {str(problem) or 'without a message'}"
    if not theirs:  # it could not even be called
        return f"{_place(own, method)} failed: {what}."
    return f"{type(own).__name__}.{method} failed in {_file(theirs[-1].filename)}, line {theirs[-1].lineno}: {what}."


def _file(name: str) -> str:
    path = Path(name)
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else name
