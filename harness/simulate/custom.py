"""Interfaces for users' controllers, estimators, sensors and plants, and the adapters that put them into the loop."""

import inspect
import math
import traceback
import warnings
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from railgrip.base.arrays import Array
from railgrip.base.errors import (
    ControllerFailed,
    EstimatorFailed,
    PlantFailed,
    RailgripError,
    ScenarioError,
    SensorsFailed,
)
from railgrip.base.interrupted import Interrupted
from railgrip.base.registry import Role
from railgrip.base.units import mistake, short
from railgrip.controllers.observation import Observation
from railgrip.vehicle.brake import BRAKE, Brake
from railgrip.vehicle.formation import Extent, Formation
from railgrip.vehicle.parameters import meanings_of_brakes
from railgrip.vehicle.signals import ESTIMATES, EXTRA, EXTRA_READINGS, PLANT, READINGS, SENT, Layout

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


PROVIDED = tuple(field.name for field in fields(Estimate))
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


class _KnownBrake(Brake):
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


_PATIENCE = 1.0  # s; until a mistake of units is named: filters have settled, and cylinders begin to fill
_MIN_SHARE = 0.01
"""Share of full pressure.

Pads do not touch below about 5 %, so a law whose demands never exceed 1 % does not brake; bar, kPa, mbar and shares of
full brake, mistaken for Pa, are 1 % or less.
"""
_ROUNDING = 1e-9
"""Share of full pressure by which rounding may take a demand out of range."""
_LEAST = {"speed": 1.0, "wheelset_speed": 2.0, "acceleration": 0.3, "cylinder_pressure": 2e4}
"""Magnitudes in SI units above which the unit of a signal can be recognised, given offsets of some percent of full
scale."""
_MAX_RATIO = 1.5
"""Above any adhesion, pad friction or slip: a larger estimate is in percent."""
_SLIDES = 0.1  # slip; readings of the speed of a rolling train are less than 10 % off
_ROUGHLY_ZERO = 0.02  # adhesion and friction; filters overshoot zero by less
_SLOWED = 5.0  # m/s; a train that slows by this without a change of slip is not on a rail
_SIGNS = {
    "slip": "; the wheels read slower than the train: slip is 1 - r w/v, positive in braking",
    "adhesion": "; adhesion is positive in braking",
    "pad_friction": "; friction of pads is positive",
}
"""Name of an estimate → the end of the message on its sign."""


class CustomController:
    """Puts a user's control law into the loop."""

    def __init__(self, controller: Controller, formation: Formation) -> None:
        """Start the law.

        Raises:
            ScenarioError: It lacks the methods of a controller, or fails to start.
        """
        require_methods(controller, type(controller).__name__, "controllers")
        self._part, self._shape = controller, (formation.groups,)
        self.needs = _names(controller, "needs", PROVIDED)
        _call_method(ScenarioError, controller, "start", _guard_formation(formation))
        self._decide = controller.decide

    @property
    def place(self) -> str:
        """Class and method that decide, with file and line."""
        return _place(self._part, "decide")

    def decide(self, observation: Observation) -> Array:
        """Return the demanded pressure of each group [Pa].

        Raises:
            ControllerFailed: The law raised an exception, or returned anything but pressures.
        """
        try:
            demands = self._decide(observation)
        except (KeyboardInterrupt, Interrupted):
            raise
        except BaseException as problem:
            raise ControllerFailed(_failure(self._part, "decide", problem) + _when(observation.time)) from problem
        if type(demands) is np.ndarray and demands.dtype == np.float64 and demands.shape == self._shape:
            return demands
        wrong = problem_with(demands, self._shape)
        if wrong:
            raise _no_demands(self.place, wrong, self._shape[0], observation.time)
        return np.asarray(demands, dtype=np.float64)


def _no_demands(place: str, found: str, groups: int, time: float) -> ControllerFailed:
    return ControllerFailed(
        f"{place} returned {found}, not the demanded pressures [Pa] of {groups} groups, shape ({groups},).{_when(time)}"
    )


class DemandLimits:
    """Limits the demands of other than built-in laws to what cylinders take, and counts the decisions it changed.

    Attributes:
        maximum: Maximum pressure of each group [Pa].
        is_pascal: Whether the demands have been large enough to be in Pa.
        limited: Number of decisions that were limited.
    """

    def __init__(self, formation: Formation, place: str = "The controller") -> None:
        """Start without limited decisions; `place` names the source of the demands in messages."""
        self.maximum, self.is_pascal, self.limited = formation.pressure_max, False, 0
        self._place, self._lowest, self._highest = place, 0.0, 0.0
        self._share, self._since = 0.0, math.inf

    def limit(self, demands: Array, observation: Observation) -> Array:
        """Return demands limited to 0 and the maximum pressure of each cylinder [Pa]; count decisions that were
        outside.

        Raises:
            ControllerFailed: The demands are not finite, or all of them are too small to be in Pa.
        """
        self.require_finite(demands, observation)
        within = np.clip(demands, 0.0, self.maximum)
        if (np.abs(demands - within) > _ROUNDING * self.maximum).any():
            self.limited += 1
            self._lowest, self._highest = min(self._lowest, demands.min()), max(self._highest, demands.max())
        if not self.is_pascal:
            self._refuse_another_unit(within, observation)
        return within

    def require_finite(self, demands: Array, observation: Observation) -> None:
        """Raise an error for demands that are infinite or NaN.

        Raises:
            ControllerFailed: A demand is not finite.
        """
        if not np.isfinite(demands).all():
            raise _no_demands(self._place, str(demands.tolist()), demands.size, observation.time)

    def sentence(self, decisions: int) -> str:
        """Return a sentence on the decisions that were limited, out of all `decisions`; empty if there were none."""
        if not self.limited:
            return ""
        return (
            f" In {self.limited} of {decisions} decisions the controller demanded pressures beyond what cylinders "
            f"take, between {self._lowest:.6g} and {self._highest:.6g} Pa; they were limited to 0 and "
            f"{self.maximum.max():.6g} Pa."
        )

    def _refuse_another_unit(self, demands: Array, observation: Observation) -> None:
        """Raise an error if, for a second after the first demand, no demand brakes although the driver requires it."""
        full = float(self.maximum.max())
        self._share = max(self._share, float((demands / self.maximum).max()))
        self.is_pascal = self._share > _MIN_SHARE
        if self.is_pascal or self._share == 0.0 or float(observation.driver_demand.max()) <= _MIN_SHARE * full:
            return
        self._since = min(self._since, observation.time)
        if observation.time >= self._since + _PATIENCE:
            words = mistake(self._share) or "another unit than Pa, such as bar or a share of full brake"
            raise ControllerFailed(
                f"The controller demands {self._share * full:.3g} Pa at most, and a full brake has {full:.6g} Pa; it "
                f"looks like {words}. At {observation.time:.3f} s."
            )


class _UnitCheck:
    """Compares the first second of a signal with expected values, and names the likely mistake of units."""

    def __init__(self, least: float) -> None:
        """Compare only where the expected magnitude reaches `least`; below it, offsets and noise dominate the ratio."""
        self._least, self._since, self._ratios, self._done = least, math.inf, list[Array](), False

    def mistake(self, time: float, value: Any, expected: Any) -> str:
        """Return the likely mistake, once a second of the stop has passed; else ''."""
        value, expected = np.atleast_1d(value), np.atleast_1d(expected)
        if self._done or not np.isfinite(value).all() or not (np.abs(expected) >= self._least).all():
            return ""
        self._ratios.append(value / expected)
        self._since = min(self._since, time)
        if time < self._since + _PATIENCE:
            return ""
        self._done = True
        # The median: a sensor that fails now and then, or a wheel that locks, must not look like a wrong unit.
        medians: list[float] = np.median(self._ratios, axis=0).tolist()
        return next((f"; it looks like {words}" for ratio in medians if (words := mistake(ratio))), "")

    def mistake_of_ratio(self, time: float, value: Any) -> str:
        """Return a clause if a ratio is in percent, once a second of the stop has passed; else ''."""
        values = np.atleast_1d(value)
        return self.mistake(time, np.where(np.abs(values) > _MAX_RATIO, 100.0, 1.0), np.ones(values.shape))


class _Persistence:
    """The time for which a condition has held without a break."""

    def __init__(self) -> None:
        self._since = math.inf

    def lasts(self, time: float, holds: bool) -> bool:
        """Return whether the condition, which holds at this time or not, has held for a second."""
        self._since = min(self._since, time) if holds else math.inf
        return time >= self._since + _PATIENCE


class _SignCheck:
    """Compares the signs of estimates with those that braking gives them, and looks for estimates that never change."""

    def __init__(self, name: str, wheel_radius: Array) -> None:
        """Check the estimate of a name on groups with wheels of these radii, shape (groups,) [m]."""
        self._name, self._radius = name, wheel_radius
        self._wrong, self._first, self._speed = _Persistence(), np.empty(0), math.nan

    def mistake(self, observation: Observation, value: ArrayLike) -> str:
        """Return the mistake, in words that follow the value; '' for a value that may be right."""
        values = np.atleast_1d(np.asarray(value, dtype=np.float64))
        if self._wrong.lasts(observation.time, self._is_wrong(observation, values)):
            return _SIGNS[self._name]
        # Adhesion and friction of pads may be assumptions, or steady in a steady braking.
        return self._stuck(observation, values) if self._name in ("speed", "wheelset_speed", "slip") else ""

    def _is_wrong(self, observation: Observation, values: Array) -> bool:
        match self._name:
            case "slip":
                rolling = max(observation.speed, _SLOWED) / self._radius
                read = 1.0 - observation.wheelset_speed / rolling
                return bool(np.any((read > _SLIDES) & (values < -0.5 * read)))
            case "adhesion":
                return bool(observation.driver_demand.max() > 0.0 and np.any(values < -_ROUGHLY_ZERO))
            case "pad_friction":
                return bool(np.any(values < -_ROUGHLY_ZERO))
            case _:
                return False

    def _stuck(self, observation: Observation, values: Array) -> str:
        if not self._first.size:
            self._first, self._speed = values.copy(), observation.speed
        has_moved = not np.array_equal(values, self._first)
        if has_moved:
            self._speed = math.nan  # compared with nothing from now on
        slowed = self._speed - observation.speed
        return f"; it has not changed since the start, while the train slowed by {slowed:.3g} m/s" * (slowed > _SLOWED)


class CustomEstimator:
    """Puts a user's estimator into the loop.

    Attributes:
        provides: Names of the estimates that it provides.
    """

    def __init__(self, estimator: Estimator, formation: Formation) -> None:
        """Check the estimator; the first step starts it.

        Raises:
            ScenarioError: It lacks the methods of an estimator, or provides no estimates.
        """
        require_methods(estimator, type(estimator).__name__, "estimators")
        self.provides = _names(estimator, "provides", PROVIDED)
        if not self.provides:
            raise ScenarioError(
                f"{type(estimator).__name__}: `provides` is empty; an estimator names there what its steps give"
            )
        self._part, self._formation, self._has_started = estimator, _guard_formation(formation), False
        self._checks = {name: _UnitCheck(_LEAST.get(name, 0.0)) for name in self.provides}
        radius = np.array([brake.wheel_radius for brake in formation.brakes])
        self._signs = {name: _SignCheck(name, radius) for name in self.provides if not name.endswith("_sd")}
        extent: dict[str, Extent] = {signal.name.removeprefix("estimate_"): signal.extent for signal in ESTIMATES}
        self._shapes = {
            name: () if extent[name] == "train" else (formation.width(extent[name]),) for name in self.provides
        }

    def step(self, observation: Observation) -> Mapping[str, Array]:
        """Return the estimates that it provides, as arrays of one dimension or more.

        Raises:
            EstimatorFailed: The estimator raised an exception, or returned anything but these estimates.
        """
        estimator = self._part
        if not self._has_started:
            _call_method(EstimatorFailed, estimator, "start", observation, self._formation)
            self._has_started = True
        estimate = _call_method(EstimatorFailed, estimator, "step", observation)
        if not isinstance(estimate, Estimate):
            raise EstimatorFailed(f"{_place(estimator, 'step')} returned {_short(estimate)}, not an Estimate.")
        values = {name: value for name in PROVIDED if (value := getattr(estimate, name)) is not None}
        if values.keys() != set(self.provides):
            raise EstimatorFailed(
                f"{_place(estimator, 'step')} gave {', '.join(values) or 'nothing'}; "
                f"it provides {', '.join(self.provides)}."
            )
        for name, value in values.items():
            _require_numbers(EstimatorFailed, estimator, "step", name, value, self._shapes[name])
            words = self._mistake(name, value, observation)
            if words:
                raise EstimatorFailed(
                    f"{_place(estimator, 'step')} gave {name} as {np.asarray(value).tolist()}{words}."
                )
        return {name: np.array(value, dtype=np.float64, ndmin=1) for name, value in values.items()}

    def _mistake(self, name: str, value: ArrayLike, observation: Observation) -> str:
        if name in self._signs and (words := self._signs[name].mistake(observation, value)):
            return words
        if name in _LEAST:
            return self._checks[name].mistake(observation.time, value, getattr(observation, name))
        # Slip, adhesion and friction have no reading to compare with, and a standard deviation has no upper bound.
        return "" if name.endswith("_sd") else self._checks[name].mistake_of_ratio(observation.time, value)


class CustomSensors:
    """Puts a user's sensors into the loop."""

    def __init__(
        self, sensors: Sensors, layout: Layout, formation: Formation, period: float, random: np.random.Generator
    ) -> None:
        """Start the sensors.

        Raises:
            ScenarioError: They lack the methods of sensors, or fail to start.
        """
        require_methods(sensors, type(sensors).__name__, "sensors")
        self._part, self._layout, self._period = sensors, layout, period
        self._truth, self._truth_by_name = _by_name(layout.outputs, layout.output)
        self._shapes = _shapes(layout.reading)
        self._checks = {name: _UnitCheck(least) for name, least in _LEAST.items()}
        self._has_read = False
        _call_method(ScenarioError, sensors, "start", _guard_formation(formation), random)

    def read(self, sample: int, truth: Array) -> Array:
        """Return the readings of a sample as a vector; NaN where a reading is not new.

        Raises:
            SensorsFailed: The sensors raised an exception, or returned anything but readings.
        """
        self._truth[:] = truth
        time = sample * self._period
        readings = _call_method(SensorsFailed, self._part, "read", time, self._truth_by_name, time=time)
        by_name = _by_its_names(readings)
        if by_name is None or not by_name.keys() <= self._shapes.keys():
            raise SensorsFailed(
                f"{_place(self._part, 'read')} returned {_short(readings)}, not readings of {', '.join(self._shapes)} "
                f"by name.{_when(time)}"
            )
        reading = np.full(self._layout.readings, np.nan)
        for name, value in by_name.items():
            _require_numbers(SensorsFailed, self._part, "read", name, value, self._shapes[name], time=time, nan=True)
            reading[self._layout.reading[name]] = value
            truth_of_it = self._truth_by_name.get(name)
            if name in self._checks and (words := self._checks[name].mistake(time, value, truth_of_it)):
                raise SensorsFailed(
                    f"{_place(self._part, 'read')} gave {name} as {np.asarray(value).tolist()}, which is "
                    f"{np.asarray(truth_of_it).tolist()}{words}.{_when(time)}"
                )
        self._has_read = self._has_read or bool(np.isfinite(reading).any())
        if not self._has_read and time >= _PATIENCE:
            raise SensorsFailed(f"{_place(self._part, 'read')} gives no reading at all.{_when(time)}")
        return reading


class CustomPlant:
    """Puts a user's plant into the loop."""

    def __init__(
        self, plant: Plant, layout: Layout, *, speed: float, period: float, required: Collection[str], command: str
    ) -> None:
        """Check the plant; the loop starts it.

        Args:
            required: Names of the outputs that the plant must return.
            command: Name by which the plant gets its brake command.

        Raises:
            ScenarioError: It lacks the methods of a plant.
        """
        require_methods(plant, type(plant).__name__, "plants")
        self._part, self._layout, self._speed, self._period = plant, layout, speed, period
        self._required, self._output_names, self._steps = frozenset(required), frozenset[str](), 0
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
        outputs = _call_method(PlantFailed, self._part, "start", formation, self._speed, self._period, time=self._time)
        by_name = _by_its_names(outputs)
        if by_name is None or not self._required <= by_name.keys() <= self._shapes.keys():
            raise PlantFailed(
                f"{_place(self._part, 'start')} returned {_short(outputs)}; a plant outputs "
                f"{', '.join(sorted(self._required))}, and may output "
                f"{', '.join(sorted(self._shapes.keys() - self._required))}."
            )
        self._output_names = frozenset(by_name)
        return self._vector("start", by_name)

    def step(self, inputs: Array) -> Array:
        """Step the plant and return its outputs, as `start`."""
        self._inputs[:] = inputs
        self._steps += 1
        outputs = _call_method(PlantFailed, self._part, "step", self._inputs_by_name, time=self._time)
        by_name = _by_its_names(outputs)
        if by_name is None or self._output_names.symmetric_difference(by_name):
            raise PlantFailed(
                f"{_place(self._part, 'step')} returned {_short(outputs)}, at the start it returned "
                f"{', '.join(sorted(self._output_names))}.{_when(self._time)}"
            )
        return self._vector("step", by_name)

    @property
    def _time(self) -> float:
        return self._steps * self._period

    def _vector(self, method: str, outputs: Mapping[str, ArrayLike]) -> Array:
        truth = np.full(self._layout.outputs, np.nan)
        for name, value in outputs.items():
            _require_numbers(PlantFailed, self._part, method, name, value, self._shapes[name], time=self._time)
            truth[self._layout.output[name]] = value
        return truth


_OF_TRAIN = frozenset(
    s.name.removeprefix("reading_") for s in (*PLANT, *EXTRA, *READINGS, *EXTRA_READINGS, *SENT) if s.extent == "train"
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


def _names(part: object, attribute: str, choice: Collection[str]) -> tuple[str, ...]:
    """Return an attribute of a user's object that holds names of estimates; empty if the attribute is missing.

    Raises:
        ScenarioError: The attribute is not a collection of such names.
    """

    def refusal(found: str) -> ScenarioError:
        return ScenarioError(
            f"{type(part).__name__}: `{attribute}` is {found}; expected are names of {', '.join(choice)}, as in "
            f'{attribute} = ("adhesion",)'
        )

    value = call_user_code(lambda: getattr(part, attribute, ()), refusal)
    if not isinstance(value, tuple | list) or not all(isinstance(name, str) and name in choice for name in value):
        raise refusal(short(value))
    return tuple(dict.fromkeys(value))


def _call_method(
    failed: type[RailgripError], part: object, method: str, *arguments: object, time: float | None = None
) -> Any:
    """Call a method of the user's class and return its result; on an exception raise `failed`, with the time [s]."""
    try:
        return getattr(part, method)(*arguments)
    except (KeyboardInterrupt, Interrupted):
        raise
    except BaseException as problem:  # SystemExit ends a component, not the program
        raise failed(_failure(part, method, problem) + _when(time)) from problem


def _when(time: float | None) -> str:
    return "" if time is None else f" At {time:.3f} s."


def _require_numbers(
    failed: type[RailgripError],
    part: object,
    method: str,
    name: str,
    value: Any,
    shape: tuple[int, ...],
    *,
    time: float | None = None,
    nan: bool = False,
) -> None:
    """Raise `failed` unless a returned value is an array of finite numbers of a shape; with `nan`, NaN is allowed."""
    problem = problem_with(value, shape, nan=nan)
    if problem:
        kind = "numbers" if nan else "finite numbers"
        raise failed(f"{_place(part, method)} gave {name} as {problem}, not {kind} of shape {shape}.{_when(time)}")


def _text_of(problem: BaseException) -> str:
    if isinstance(problem, RailgripError):
        return str(problem)
    try:
        text = str(problem)
    except Exception:
        text = "its text cannot be read"
    return f"{type(problem).__name__}: {text or 'without a message'}"


def _place(part: object, method: str) -> str:
    name, code = f"{type(part).__name__}.{method}", getattr(getattr(part, method, None), "__code__", None)
    return name if code is None else f"{name} ({_file(code.co_filename)}, line {code.co_firstlineno})"


def _failure(part: object, method: str, problem: BaseException) -> str:
    frames = traceback.extract_tb(problem.__traceback__)[1:]  # the first one is the call from here
    try:
        file = inspect.getsourcefile(type(part))
    except (OSError, TypeError):
        file = None
    theirs = [frame for frame in frames if frame.filename == file] or frames[:1]
    what = _text_of(problem)
    if not theirs:  # it could not even be called
        return f"{_place(part, method)} failed: {what}."
    return f"{type(part).__name__}.{method} failed in {_file(theirs[-1].filename)}, line {theirs[-1].lineno}: {what}."


def _file(name: str) -> str:
    path = Path(name)
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else name
