"""Users' controllers, estimators, sensors and plants: their interfaces, how they are imported, and what adapts them.

A scenario names a class, or the Python interface gets an object. Both are checked for the methods of their role, get
calls whose errors name file and line, and return values whose shapes, units and signs are checked.
"""

import hashlib
import inspect
import math
import os
import sys
import traceback
import warnings
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from importlib import import_module, invalidate_caches
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any, ClassVar, Literal, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from railgrip.base.arrays import Array, generator
from railgrip.base.errors import (
    ControllerFailed,
    EstimatorFailed,
    PlantFailed,
    RailgripError,
    ScenarioError,
    SensorsFailed,
)
from railgrip.base.interrupted import Interrupted
from railgrip.base.registry import Role, installed_names
from railgrip.base.tables import JsonObject
from railgrip.base.units import cut, short
from railgrip.controllers.law import GroupLaw
from railgrip.controllers.observation import Observation
from railgrip.scenario.onboard import CustomLaw, OwnSensors, TrainLevelTable
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Custom
from railgrip.scenario.vehicle_table import PythonClass, Vehicle
from railgrip.simulate.value_checks import PATIENCE, SMALLEST_RECOGNISED, SignCheck, UnitCheck, at_time, not_demands
from railgrip.vehicle.brake import BRAKE, Brake
from railgrip.vehicle.formation import Extent, Formation
from railgrip.vehicle.parameters import meanings_of_brakes
from railgrip.vehicle.signals import ESTIMATES, EXTRA, EXTRA_READINGS, PLANT, PLANT_INPUTS, READINGS, Layout

T = TypeVar("T")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Estimate:
    """Output of a user-defined estimator: the quantities that it provides, and None for the others.

    Attributes:
        speed: Train speed [m/s].
        wheelset_speed: Shape (groups,) [rad/s].
        slip: Shape (groups,) [1].
        adhesion: Shape (groups,), positive in braking [1].
        pad_friction: Shape (groups,) [1].
        adhesion_sd: Standard deviation of `adhesion`, shape (groups,) [1].
        pad_friction_sd: Standard deviation of `pad_friction`, shape (groups,) [1].
    """

    speed: float | None = None
    wheelset_speed: ArrayLike | None = None
    slip: ArrayLike | None = None
    adhesion: ArrayLike | None = None
    pad_friction: ArrayLike | None = None
    adhesion_sd: ArrayLike | None = None
    pad_friction_sd: ArrayLike | None = None


PROVIDED = tuple(each.name for each in fields(Estimate))
"""Names of the quantities that an estimator may provide."""


@runtime_checkable
class Controller(Protocol):
    """A control law. The optional attribute `needs` names the estimates that it requires: ("adhesion",)."""

    def start(self, formation: Formation) -> None:
        """Start a stop; called again for each further stop."""
        ...

    def decide(self, observation: Observation) -> ArrayLike:
        """Return the demanded brake cylinder pressure of each group, shape (groups,) [Pa]."""
        ...


@runtime_checkable
class Estimator(Protocol):
    """Estimates of the state of the train.

    Attributes:
        provides: Names of the fields of `Estimate` that each step sets. All other fields are absent from the trace, and
            the controller gets None or the reading in their place.
    """

    provides: tuple[str, ...]

    def start(self, first: Observation, formation: Formation) -> None:
        """Start a stop with the first observation; called again for each further stop."""
        ...

    def step(self, observation: Observation) -> Estimate:
        """Return the estimates for an observation; called each period of the estimator, including for `first`."""
        ...


@runtime_checkable
class Sensors(Protocol):
    """Instruments of the train: they turn the true signals into readings."""

    def start(self, formation: Formation, random: np.random.Generator) -> None:
        """Start a stop; draw all noise from `random`, which is seeded by the scenario."""
        ...

    def read(self, time: float, truth: Mapping[str, Array]) -> Mapping[str, ArrayLike]:
        """Return speed, wheelset_speed, deflection, acceleration and cylinder_pressure, in SI units.

        Args:
            time: Time since the brake demand [s]; called each communication period, starting at 0.
            truth: True signals by the names of a trace's variables, such as speed, wheelset_speed and slip.

        A reading that is omitted or NaN is not new.
        """
        ...


@runtime_checkable
class Plant(Protocol):
    """The simulated vehicle."""

    def start(self, formation: Formation, speed: float, period: float) -> Mapping[str, ArrayLike]:
        """Start a stop, or start again, and return the outputs at the brake demand; see `step`.

        Args:
            formation: Formation of the scenario, with nominal brakes and loads.
            speed: Initial speed [m/s].
            period: Duration of each step [s].
        """
        ...

    def step(self, inputs: Mapping[str, Array]) -> Mapping[str, ArrayLike]:
        """Hold `inputs` constant over one period and return the outputs at its end.

        Args:
            inputs: pressure_command (groups,) [Pa], or valve_command [1] with pneumatic actuation; mu0 (wheelsets,)
                [1], track_force () [N]; curve_k_A, curve_k_S, curve_A [1] and curve_B [s/m] (wheelsets,) where the
                rail has several creep curves.

        Returns:
            Outputs by the names of a trace's variables and in their units, the same ones at each step: distance, speed,
            acceleration, wheelset_speed and cylinder_pressure are required; slip, adhesion, wheelset_load, brake_torque
            and the others are optional. Slip that is not returned is computed from the speeds.
        """
        ...


class _KnownBrake(Brake):  # pyrefly: ignore[bad-class-definition] - Brake alone is a dataclass
    """A brake that raises an error when a user's class reads data that neither plant nor scenario gives."""

    __slots__ = ()

    def __post_init__(self) -> None:
        """Skip the checks: the data come from a valid `Brake`."""

    def __getattribute__(self, name: str) -> Any:
        """Return an attribute.

        Raises:
            ScenarioError: The attribute is a datum that is not given.
        """
        value = super().__getattribute__(name)
        if name in BRAKE and math.isnan(value):
            keys = " and ".join(f"{key} ({meaning})" for key, meaning in meanings_of_brakes({name}).items())
            raise ScenarioError(
                f"[vehicle.formation] brakes lacks {keys}, which the plant does not declare; give it there"
            )
        return value

    def __repr__(self) -> str:
        data = {name: super(_KnownBrake, self).__getattribute__(name) for name in BRAKE}
        return f"Brake({', '.join(f'{name}={value!r}' for name, value in data.items())})"


def _guard_formation(formation: Formation) -> Formation:
    """Return a formation whose missing brake data raise an error when read; the same formation if none are missing."""
    brakes = [{name: getattr(brake, name) for name in BRAKE} for brake in formation.brakes]
    if not any(math.isnan(value) for data in brakes for value in data.values()):
        return formation
    return replace(formation, brakes=tuple(_KnownBrake(**data) for data in brakes))


_METHODS: Mapping[Role, tuple[str, str, str]] = {
    "controllers": ("a controller", "start", "decide"),
    "estimators": ("an estimator", "start", "step"),
    "sensors": ("a sensor model", "start", "read"),
    "plants": ("a plant", "start", "step"),
}


def require_methods(part: object, name: str, role: Role) -> None:
    """Check that a class or an object has the methods of its role.

    Raises:
        ScenarioError: Methods are missing; the message names them.
    """
    what, *names = _METHODS[role]
    missing = call_user_code(
        lambda: [method for method in names if not callable(getattr(part, method, None))],
        lambda problem: ScenarioError(f"{name}: its methods cannot be looked at: {problem}"),
    )
    if missing:
        raise ScenarioError(f"{name}: has no method {' and '.join(missing)}; {what} has {' and '.join(names)}")


def names_in(part: object, name: str, attribute: Literal["needs", "provides"]) -> tuple[str, ...]:
    """Return an attribute of a class or an object that holds names of estimates; empty if the attribute is missing.

    Raises:
        ScenarioError: The attribute is not a collection of such names.
    """

    def refusal(found: str) -> ScenarioError:
        return ScenarioError(
            f"{name}: `{attribute}` is {found}; expected are names of {', '.join(PROVIDED)}, "
            f'as in {attribute} = ("adhesion",)'
        )

    value = call_user_code(lambda: getattr(part, attribute, ()), refusal)
    if not isinstance(value, tuple | list) or not all(isinstance(each, str) and each in PROVIDED for each in value):
        raise refusal(short(value))
    return tuple(dict.fromkeys(value))


class _Adapter:
    """A user's object in its role: what it raises, or wrongly returns, becomes an error of the role.

    Attributes:
        role: Role of the object.
        failed: Error of the role.
        name: Name of the object's class.
    """

    role: ClassVar[Role]
    failed: ClassVar[type[RailgripError]]
    _shapes: Mapping[str, tuple[int, ...]]

    def __init__(self, part: object) -> None:
        """Check the methods of an object.

        Raises:
            ScenarioError: It lacks those of its role.
        """
        self.name, self._part = type(part).__name__, part
        require_methods(part, self.name, self.role)

    def _written(self, method: str) -> tuple[object, str]:
        """Return the object that the user has written and its method that is called, by which messages name it."""
        return self._part, method

    def _place(self, method: str) -> str:
        part, method = self._written(method)
        name = f"{self.name}.{method}"
        code = getattr(getattr(part, method, None), "__code__", None)
        return name if code is None else f"{name} ({_file(code.co_filename)}, line {code.co_firstlineno})"

    def _error(self, method: str, words: str, time: float | None = None) -> RailgripError:
        """Return the error of a method, with the time [s] if there is one; `words` follow its name and place."""
        return self.failed(f"{self._place(method)} {words}.{at_time(time)}")

    def _call(
        self, method: str, *arguments: object, time: float | None = None, failed: type[RailgripError] | None = None
    ) -> Any:
        """Call a method and return its result; on an exception raise `failed`, that of the role without it."""
        try:
            return getattr(self._part, method)(*arguments)
        except (KeyboardInterrupt, Interrupted):
            raise
        except BaseException as problem:  # SystemExit ends a component, not the program
            raise (failed or self.failed)(self._failure(method, problem) + at_time(time)) from problem

    def _failure(self, method: str, problem: BaseException) -> str:
        frames = traceback.extract_tb(problem.__traceback__)[1:]  # the first one is the call from here
        part, written = self._written(method)
        try:
            file = inspect.getsourcefile(part if isinstance(part, type) else type(part))
        except (OSError, TypeError):
            file = None
        theirs = [frame for frame in frames if frame.filename == file] or (frames[:1] if part is self._part else [])
        what = _text_of(problem)
        if not theirs:  # it could not even be called
            return f"{self._place(method)} failed: {what}."
        return f"{self.name}.{written} failed in {_file(theirs[-1].filename)}, line {theirs[-1].lineno}: {what}."

    def _require_numbers(
        self, method: str, values: Mapping[str, Any], time: float | None = None, *, nan: bool = False
    ) -> None:
        """Raise an error unless returned values are arrays of finite numbers of their shapes; with `nan`, or of NaN."""
        for name, value in values.items():
            if problem := problem_with(value, self._shapes[name], nan=nan):
                kind = "numbers" if nan else "finite numbers"
                raise self._error(method, f"gave {name} as {problem}, not {kind} of shape {self._shapes[name]}", time)


class CustomController(_Adapter):
    """Puts a user's control law into the loop."""

    role = "controllers"
    failed = ControllerFailed

    def __init__(self, controller: Controller, formation: Formation) -> None:
        """Start the law.

        Raises:
            ScenarioError: It lacks the methods of a controller, or fails to start.
        """
        super().__init__(controller)
        self._shape, self.needs = (formation.groups,), names_in(controller, self.name, "needs")
        self._call("start", _guard_formation(formation), failed=ScenarioError)

    @property
    def place(self) -> str:
        """Class and method that decide, with file and line."""
        return self._place("decide")

    def decide(self, observation: Observation) -> Array:
        """Return the demanded pressure of each group [Pa].

        Raises:
            ControllerFailed: The law raised an exception, or returned anything but pressures.
        """
        demands = self._call("decide", observation, time=observation.time)
        if type(demands) is np.ndarray and demands.dtype == np.float64 and demands.shape == self._shape:
            return demands
        if wrong := problem_with(demands, self._shape):
            raise not_demands(self.place, wrong, self._shape[0], observation.time)
        return np.asarray(demands, dtype=np.float64)


class CustomEstimator(_Adapter):
    """Puts a user's estimator into the loop.

    Attributes:
        provides: Names of the estimates that it provides.
    """

    role = "estimators"
    failed = EstimatorFailed

    def __init__(self, estimator: Estimator, formation: Formation) -> None:
        """Check the estimator; the first step starts it.

        Raises:
            ScenarioError: It lacks the methods of an estimator, or provides no estimates.
        """
        super().__init__(estimator)
        self.provides = names_in(estimator, self.name, "provides")
        if not self.provides:
            raise ScenarioError(f"{self.name}: `provides` is empty; an estimator names there what its steps give")
        self._formation, self._has_started = _guard_formation(formation), False
        self._checks = {name: UnitCheck(SMALLEST_RECOGNISED.get(name, 0.0)) for name in self.provides}
        self._signs = {name: SignCheck(name, formation) for name in self.provides if not name.endswith("_sd")}
        extent: dict[str, Extent] = {signal.name.removeprefix("estimate_"): signal.extent for signal in ESTIMATES}
        self._shapes = {
            name: () if extent[name] == "train" else (formation.width(extent[name]),) for name in self.provides
        }

    def step(self, observation: Observation) -> Mapping[str, Array]:
        """Return the estimates that it provides, as arrays of one dimension or more.

        Raises:
            EstimatorFailed: The estimator raised an exception, or returned anything but these estimates.
        """
        if not self._has_started:
            self._call("start", observation, self._formation)
            self._has_started = True
        estimate = self._call("step", observation)
        if not isinstance(estimate, Estimate):
            raise self._error("step", f"returned {_short(estimate)}, not an Estimate")
        values = {name: value for name in PROVIDED if (value := getattr(estimate, name)) is not None}
        if values.keys() != set(self.provides):
            given = ", ".join(values) or "nothing"
            raise self._error("step", f"gave {given}; it provides {', '.join(self.provides)}")
        self._require_numbers("step", values)
        for name, value in values.items():
            if words := self._mistake(name, value, observation):
                raise self._error("step", f"gave {name} as {np.asarray(value).tolist()}{words}")
        return {name: np.array(value, dtype=np.float64, ndmin=1) for name, value in values.items()}

    def _mistake(self, name: str, value: ArrayLike, observation: Observation) -> str:
        if name in self._signs and (words := self._signs[name].mistake(observation, value)):
            return words
        if name in SMALLEST_RECOGNISED:
            return self._checks[name].mistake(observation.time, value, getattr(observation, name))
        # Slip, adhesion and friction have no reading to compare with, and a standard deviation has no upper bound.
        return "" if name.endswith("_sd") else self._checks[name].mistake_of_ratio(observation.time, value)


class CustomSensors(_Adapter):
    """Puts a user's sensors into the loop."""

    role = "sensors"
    failed = SensorsFailed

    def __init__(
        self, sensors: Sensors, layout: Layout, formation: Formation, period: float, random: np.random.Generator
    ) -> None:
        """Start the sensors.

        Raises:
            ScenarioError: They lack the methods of sensors, or fail to start.
        """
        super().__init__(sensors)
        self._layout, self._period, self._has_read = layout, period, False
        self._truth, self._truth_by_name = _by_name(layout.outputs, layout.output)
        self._shapes = _shapes(layout.reading)
        self._checks = {name: UnitCheck(least) for name, least in SMALLEST_RECOGNISED.items()}
        self._call("start", _guard_formation(formation), random, failed=ScenarioError)

    def read(self, sample: int, truth: Array) -> Array:
        """Return the readings of a sample as a vector; NaN where a reading is not new.

        Raises:
            SensorsFailed: The sensors raised an exception, or returned anything but readings.
        """
        self._truth[:] = truth
        time = sample * self._period
        readings = self._call("read", time, self._truth_by_name, time=time)
        by_name = _by_its_names(readings)
        if by_name is None or not by_name.keys() <= self._shapes.keys():
            expected = f"readings of {', '.join(self._shapes)} by name"
            raise self._error("read", f"returned {_short(readings)}, not {expected}", time)
        self._require_numbers("read", by_name, time, nan=True)
        reading = np.full(self._layout.readings, np.nan)
        for name, value in by_name.items():
            reading[self._layout.reading[name]] = value
            expected = self._truth_by_name.get(name)
            if name in self._checks and (words := self._checks[name].mistake(time, value, expected)):
                found = f"gave {name} as {np.asarray(value).tolist()}, which is {np.asarray(expected).tolist()}"
                raise self._error("read", f"{found}{words}", time)
        self._has_read = self._has_read or bool(np.isfinite(reading).any())
        if not self._has_read and time >= PATIENCE:
            raise self._error("read", "gives no reading at all", time)
        return reading


NEEDED = frozenset({"distance", "speed", "acceleration", "wheelset_speed", "cylinder_pressure"})
"""Outputs that every plant must have; others, such as true adhesion, are empty in the trace if a plant lacks them."""


class CustomPlant(_Adapter):
    """Puts a user's plant into the loop."""

    role = "plants"
    failed = PlantFailed

    def __init__(self, plant: Plant, layout: Layout, *, speed: float, period: float, command: str) -> None:
        """Check the plant; the loop starts it.

        Args:
            command: Name by which the plant gets its brake command.

        Raises:
            ScenarioError: It lacks the methods of a plant.
        """
        super().__init__(plant)
        self._layout, self._speed, self._period = layout, speed, period
        self._output_names, self._steps = frozenset[str](), 0
        self._inputs, inputs = _by_name(layout.inputs, layout.input)
        self._inputs_by_name = {command if name == "command" else name: value for name, value in inputs.items()}
        self._shapes = _shapes(layout.output)

    def start(self, inputs: Array) -> Array:
        """Start the plant and return its outputs as a vector; NaN for outputs that it lacks.

        Raises:
            PlantFailed: The plant raised an exception, or returned anything but its outputs.
        """
        self._steps = 0
        formation = _guard_formation(self._layout.formation)
        outputs = self._call("start", formation, self._speed, self._period, time=self._time)
        by_name = _by_its_names(outputs)
        if by_name is None or not NEEDED <= by_name.keys() <= self._shapes.keys():
            others = ", ".join(sorted(self._shapes.keys() - NEEDED))
            expected = f"a plant outputs {', '.join(sorted(NEEDED))}, and may output {others}"
            raise self._error("start", f"returned {_short(outputs)}; {expected}")
        self._output_names = frozenset(by_name)
        return self._vector("start", by_name)

    def step(self, inputs: Array) -> Array:
        """Step the plant and return its outputs, as `start`."""
        self._inputs[:] = inputs
        self._steps += 1
        outputs = self._call("step", self._inputs_by_name, time=self._time)
        by_name = _by_its_names(outputs)
        if by_name is None or self._output_names.symmetric_difference(by_name):
            before = ", ".join(sorted(self._output_names))
            raise self._error("step", f"returned {_short(outputs)}, at the start it returned {before}", self._time)
        return self._vector("step", by_name)

    @property
    def _time(self) -> float:
        return self._steps * self._period

    def _vector(self, method: str, outputs: Mapping[str, ArrayLike]) -> Array:
        self._require_numbers(method, outputs, self._time)
        truth = np.full(self._layout.outputs, np.nan)
        for name, value in outputs.items():
            truth[self._layout.output[name]] = value
        return truth


_OF_TRAIN = frozenset(
    s.name.removeprefix("reading_")
    for s in (*PLANT, *EXTRA, *READINGS, *EXTRA_READINGS, *PLANT_INPUTS)
    if s.extent == "train"
)


def _shapes(places: Mapping[str, slice]) -> dict[str, tuple[int, ...]]:
    return {name: () if name in _OF_TRAIN else (place.stop - place.start,) for name, place in places.items()}


def _by_name(length: int, places: Mapping[str, slice]) -> tuple[Array, dict[str, Array]]:
    vector = np.empty(length)
    view = vector.view()
    view.flags.writeable = False
    return vector, {name: view[places[name]].reshape(shape) for name, shape in _shapes(places).items()}


def problem_with(value: Any, shape: tuple[int, ...], *, nan: bool = False) -> str:
    """Describe a value that is not finite numbers of a shape; return '' for one that is. With `nan`, NaN is allowed."""
    numbers = _numbers(value)
    if numbers is None:
        return _short(value)
    if numbers.shape != shape:
        return f"numbers of shape {numbers.shape}"
    good = np.isfinite(numbers) | np.isnan(numbers) if nan else np.isfinite(numbers)
    return "" if bool(np.all(good)) else str(numbers.tolist())


def _numbers(value: Any) -> Array | None:
    """Return integers or floats as an array; None for anything else that NumPy would silently convert to floats.

    Such are complex numbers, whose imaginary parts it drops, masked elements, strings, booleans, None, and integers
    that a float cannot represent.
    """
    if type(value) is np.ndarray and value.dtype == np.float64:
        return value
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # such as that a quantity loses its unit
            array = np.asarray(value)
            is_masked = np.ma.is_masked(value) or (
                isinstance(value, list | tuple) and any(element is np.ma.masked for element in value)
            )
        return None if is_masked or array.dtype.kind not in "fiu" else np.asarray(array, dtype=np.float64)
    except Exception:  # whatever the user's object raises in __array__, __len__ or __float__
        return None


def _by_its_names(value: Any) -> dict[Any, Any] | None:
    """Return a user's mapping as a dict; None if it is not a mapping, or if reading it fails."""
    try:
        return dict(value.items()) if isinstance(value, Mapping) else None
    except Exception:
        return None


def _short(value: object) -> str:
    return f"{type(value).__name__} {short(value)}"


def call_user_code(call: Callable[[], T], failed: Callable[[str], RailgripError]) -> T:
    """Call a user's code and return its result.

    Any exception, SystemExit included, becomes `failed` of its type and text.
    """
    try:
        return call()
    except (KeyboardInterrupt, Interrupted):
        raise  # not from that code: the user or the system ends the program
    except BaseException as problem:
        raise failed(_text_of(problem)) from problem


CALLS = frozenset((call_user_code.__code__, _Adapter._call.__code__))  # pyright: ignore[reportPrivateUsage]
"""Code that calls the code of users."""


def _text_of(problem: BaseException) -> str:
    if isinstance(problem, RailgripError):
        return str(problem)
    try:
        text = str(problem)
    except Exception:
        text = "its text cannot be read"
    return f"{type(problem).__name__}: {text or 'without a message'}"


def _file(name: str) -> str:
    path = Path(name)
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else name


_Table = TypeVar("_Table", bound=Custom)


def part_of(table: Custom, role: Role, folders: Sequence[Path] = ()) -> Any:
    """Return a new object of the class that a table names.

    Raises:
        ScenarioError: See `class_of`, or the class does not take these parameters.
    """
    return instance_of(class_of(table, role, folders), table.parameters, _table(role))


def class_of(table: Custom, role: Role, folders: Sequence[Path] = ()) -> type:
    """Import the class that a table names.

    Text in a file decides which code is imported here, so only two places are trusted: `folders`, which the command
        line or a caller names, and entry points of installed packages. A class is called only after its type and the
        methods of its role have been checked.

    Raises:
        ScenarioError: The module is in neither place or cannot be imported, or it lacks the class.
    """
    who = f"{_table(role)} kind {cut(table.kind)}"
    points = installed_names(role)
    class_name = points.get(table.kind, table.kind)
    module, _, name = class_name.partition(":")
    if not all(part.isidentifier() for part in module.split(".")):
        raise ScenarioError(f"{who}: {cut(module)} is not the name of a module")
    is_installed = class_name in points.values()
    invalidate_caches()  # a file may have been written a moment ago
    if not is_installed and PathFinder.find_spec(module.partition(".")[0], [str(folder) for folder in folders]) is None:
        raise ScenarioError(
            f"{who}: the module {cut(module)} cannot be imported: a class that a file names comes from a folder named "
            f"by --import-from DIR (import_from=[…] in Python), or is an entry point railgrip.{role} of an installed "
            "package"
        )
    with _path_without_current_folder(() if is_installed else folders):
        loaded: Any = call_user_code(
            lambda: import_module(module),
            lambda problem: ScenarioError(f"{who}: the module {cut(module)} cannot be imported: {problem}"),
        )
    file = getattr(loaded, "__file__", None)
    if not is_installed and not (file and any(Path(file).is_relative_to(folder.resolve()) for folder in folders)):
        raise ScenarioError(
            f"{who}: another module named {module} is loaded already, from {file or 'Python itself'}; rename yours"
        )
    found: Any = loaded
    for part in name.split("."):
        found = getattr(found, part, None)
    if not isinstance(found, type):
        raise ScenarioError(f"{who}: the module {module} has no class {cut(name)}")
    if not (role == "controllers" and issubclass(found, GroupLaw)):
        require_methods(found, found.__name__, role)
    return found


@dataclass(frozen=True, slots=True)
class FormulaLaw:
    """A user's law that is a formula, like the built-in ones; a stop opens it with the brakes of its train.

    Attributes:
        kind: The class.
        parameters: Values that replace those of its `tuning`.
    """

    kind: type[GroupLaw]
    parameters: Mapping[str, Any]


def instance_of(kind: type, parameters: Mapping[str, Any], where: str) -> Any:
    """Return a new object of a user's class; a law that is a formula becomes a `FormulaLaw`.

    Raises:
        ScenarioError: The class does not take these parameters, raises, or has attributes that have no effect; the
            message begins with `where`.
    """
    if issubclass(kind, GroupLaw):
        names_in(kind, kind.__name__, "needs")
        if kind.exceeds_driver or kind.valve_band is not None:
            raise ScenarioError(
                f"{where} {kind.__name__}: `exceeds_driver` and `valve_band` have an effect only in laws of railgrip; "
                "leave them out"
            )
        return FormulaLaw(kind, dict(parameters))
    return call_user_code(
        lambda: kind(**parameters),
        lambda problem: ScenarioError(
            f"{where} {kind.__name__} cannot be made with parameters {short(dict(parameters))}: {problem}"
        ),
    )


def _table(role: Role) -> str:
    return {"sensors": "[sensors]", "plants": "[vehicle]"}.get(role, f"[{role.removesuffix('s')}]")


def table_of(part: object, table: type[_Table] = Custom, **keys: Any) -> _Table:
    """Return the table that represents an object given by a caller; `keys` are further keys of that table."""
    if isinstance(part, FormulaLaw):
        return table(kind=_name(part.kind), parameters=dict(part.parameters), **keys)
    attributes: dict[str, object] = vars(part) if hasattr(part, "__dict__") else {}
    values = {name: _plain(value) for name, value in attributes.items() if not name.startswith("_")}
    known = {name: value for name, value in values.items() if value is not None}
    return table(kind=_name(type(part)), parameters=known, **keys)


def origin_of(part: object, parameters: Mapping[str, Any]) -> JsonObject:
    """Return the origin of an object's class, as JSON values: its name, a digest of its source, its arguments.

    The digest is that of the module's file, else of the class's source text; None if neither exists. The arguments of
    an object given by a caller are its public plain attributes.
    """
    kind = part.kind if isinstance(part, FormulaLaw) else type(part)
    return {"class": _name(kind), "source_sha256": _source(kind), "parameters": dict(parameters)}


def _name(kind: type) -> str:
    return f"{kind.__module__}:{kind.__qualname__}"


def _source(kind: type) -> str | None:
    try:
        content = Path(inspect.getfile(kind)).read_bytes()
    except (OSError, TypeError):
        try:
            content = inspect.getsource(kind).encode()  # of a notebook, which keeps its cells
        except (OSError, TypeError):
            return None
    return hashlib.sha256(content).hexdigest()


def _plain(value: object, levels: int = 12) -> Any:
    """Return a number, string or array as JSON values.

    The result is None for other types, and for lists nested more deeply than `levels`.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        elements = [_plain(element, levels - 1) for element in value] if levels else [None]
        return None if any(element is None for element in elements) else elements
    return value if isinstance(value, bool | int | float | str) else None


@contextmanager
def _path_without_current_folder(folders: Sequence[Path]) -> Generator[None]:
    here, path = os.path.realpath(Path.cwd()), list(sys.path)
    sys.path[:] = [
        *(str(folder.resolve()) for folder in folders),
        *(entry for entry in path if entry and os.path.realpath(entry) != here),
    ]
    try:
        yield
    finally:
        sys.path[:] = path


@dataclass(frozen=True, slots=True, kw_only=True)
class CustomParts:
    """User-defined objects that replace parts of a scenario; see `railgrip.simulate.user_parts`.

    Attributes:
        controller, estimator, sensors, plant: None keeps the part of the scenario.
        folders: Folders that are searched for modules of a scenario, in addition to the installed environment.
    """

    controller: Controller | None = None
    estimator: Estimator | None = None
    sensors: Sensors | None = None
    plant: Plant | None = None
    folders: tuple[Path, ...] = ()

    def declare_in(self, scenario: Scenario) -> Scenario:
        """Return the scenario with these objects' classes in its tables, which results of a stop must name."""
        tables: dict[str, object] = {}
        if self.controller is not None:
            over = {name: getattr(scenario.controller, name) for name in TrainLevelTable.model_fields}
            tables["controller"] = table_of(self.controller, CustomLaw, **over)
        if self.estimator is not None:
            tables["estimator"] = table_of(self.estimator)
        if self.sensors is not None:
            tables["sensors"] = table_of(self.sensors, OwnSensors)
        if self.plant is not None:
            vehicle = {"plant": table_of(self.plant).kind, "formation": scenario.vehicle.formation}
            tables["vehicle"] = Vehicle.model_validate(vehicle)
        return scenario.model_copy(update=tables)


NO_CUSTOM_PARTS = CustomParts()
"""Only the parts that the scenario names."""


class UserParts:
    """The user-defined parts of a stop: objects that the caller gives, or of the classes that the scenario names.

    Attributes:
        classes: Origin of each that has been opened, by part; see `origin_of`.
    """

    def __init__(self, objects: CustomParts, scenario: Scenario, layout: Layout) -> None:
        """Take the tables of a scenario, in which `objects` are declared, and the layout of its vehicle."""
        self.classes: dict[str, JsonObject] = {}
        self._objects, self._scenario, self._layout = objects, scenario, layout

    def controller(self) -> CustomController | FormulaLaw | None:
        """Return the controller; None for a built-in law or an FMU."""
        law = self._part("controllers", self._scenario.controller, self._objects.controller)
        return law if law is None or isinstance(law, FormulaLaw) else CustomController(law, self._layout.formation)

    def estimator(self) -> CustomEstimator | None:
        """Return the estimator; None for a built-in one or none."""
        part = self._part("estimators", self._scenario.estimator, self._objects.estimator)
        return None if part is None else CustomEstimator(part, self._layout.formation)

    def sensors(self) -> CustomSensors | None:
        """Return the sensors; None for built-in ones."""
        if (part := self._part("sensors", self._scenario.sensors, self._objects.sensors)) is None:
            return None
        noise, period = generator(self._scenario.seed, "sensors.custom"), self._scenario.periods.communication
        return CustomSensors(part, self._layout, self._layout.formation, period, noise)

    def plant(self) -> CustomPlant | None:
        """Return the plant; None for an FMU."""
        scenario, given, source = self._scenario, self._objects.plant, self._scenario.vehicle.source
        if not isinstance(source, PythonClass):
            return None
        arguments = {key: value.entry for key, value in scenario.vehicle.parameters.items()}
        table = Custom(kind=source.name, parameters=arguments) if given is None else table_of(given)
        command = "valve_command" if scenario.actuation.kind == "pneumatic" else "pressure_command"
        speed, period = scenario.start.speed, scenario.periods.communication
        part = self._part("plants", table, given)
        return CustomPlant(part, self._layout, speed=speed, period=period, command=command)

    def _part(self, role: Role, table: object, given: object) -> Any:
        """Return the given object, or else one of the class that a table names; None for a table of a built-in kind."""
        if not isinstance(table, Custom):
            return None
        if given is None:
            given = part_of(table, role, self._objects.folders)
        self.classes[role if role == "sensors" else role.removesuffix("s")] = origin_of(given, table.parameters)
        return given
