"""Contract tests for controllers, estimators, sensors and plants: the requirements of a stop, checked without a train.

railgrip.testing.check_controller(MyLaw)

Each function takes a class, or another callable that returns a new object, and raises ContractBroken with a sentence on
the first violation. They use formations of one, three and four groups, and observations of a wheel that rolls, slides
and locks, of a train at rest, and of sensors without a reading.
"""

import copy
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import cache, partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import (
    ContractBroken,
    ControllerFailed,
    EstimatorFailed,
    PlantFailed,
    ScenarioError,
    SensorsFailed,
)
from railgrip.base.units import short
from railgrip.controllers.law import GroupLaw
from railgrip.controllers.observation import Observation
from railgrip.simulate.loop.plausible import slowing_of
from railgrip.simulate.plant_trial import TrialPlant, findings
from railgrip.simulate.user_parts import (
    Controller,
    CustomController,
    CustomEstimator,
    CustomPlant,
    CustomSensors,
    Estimator,
    Plant,
    Sensors,
    call_user_code,
)
from railgrip.simulate.value_checks import DemandLimits
from railgrip.vehicle.brake import Brake
from railgrip.vehicle.formation import Formation, carried_mass
from railgrip.vehicle.signals import layout_of

T = TypeVar("T")
Row = tuple[float, ...]

_FORMATIONS = ((2, 1, 1, 2), (1,), (1, 2, 2))
_PERIOD = 1e-2  # s
_SPEED = 25.0  # m/s
_BRAKE = Brake(
    load=1.2e5, inertia=120.0, wheel_radius=0.45, units=4, friction_radius=0.24, piston_area=0.03, rigging=5.0,
    spring_force=1000.0, pressure_max=3.8e5,
)  # fmt: skip
"""Data of a fictitious train; a law must not depend on the numbers of one train."""


def check_controller(factory: Callable[[], Controller], *, estimates: bool = True) -> None:
    """Check a control law.

    It takes any number of groups, returns one pressure between 0 and the maximum for each, for any observation, does
    not change the observation, and repeats its outputs after `start`.

    Args:
        factory: Class or function that returns a new law.
        estimates: Whether the law is also checked with estimates of adhesion and pad friction. It is checked without
            them, too, unless it `needs` them.

    Raises:
        ContractBroken: The law violates one of these requirements.
    """
    if isinstance(factory, type) and issubclass(factory, GroupLaw):
        factory = partial(type(factory.__name__, (_StartedFormula,), {}), factory)  # messages have the law's name
    limits_of = cache(DemandLimits)  # common to both runs: the unit of demands is checked once

    def rows(law: Controller, formation: Formation) -> Iterator[Row]:
        controller = _adapt(law, formation)
        limits = limits_of(formation, controller.place)
        shown: list[Observation] = []
        for estimated in (with_ for with_ in (True, False) if (estimates if with_ else not controller.needs)):
            for observation in observations(formation, estimated=estimated):
                before = copy.deepcopy(observation)
                shown.append(before)
                try:
                    demands = controller.decide(observation)
                    limits.require_finite(demands, observation)
                except ControllerFailed as problem:
                    raise ControllerFailed(f"{problem}{_blame_inputs(factory, formation, shown)}") from problem
                _require_unchanged(law, before, observation)
                _require_pressures(controller.place, formation, demands)
                yield tuple(limits.limit(demands, observation).tolist())

    _require_repeatable(factory, "decide", rows)


class _StartedFormula:
    """A law that is a formula, with the methods of a class in Python."""

    def __init__(self, kind: type[GroupLaw]) -> None:
        self.kind, self.needs = kind, kind.needs

    def start(self, formation: Formation) -> None:
        """Open the formula, with the defaults of its parameters."""
        self._law = self.kind(formation.brakes, self.kind.tuning_with(period=_PERIOD))

    def decide(self, observation: Observation) -> Sequence[float]:
        """Return the demanded pressure of each group [Pa]."""
        return self._law.decide(observation)


class _FormulaController(CustomController):
    """The adapter of such a law, whose messages name the function that gives the formula."""

    def _written(self, method: str) -> tuple[object, str]:
        assert isinstance(self._part, _StartedFormula)
        return self._part.kind, "demand"


def _adapt(law: Controller, formation: Formation) -> CustomController:
    return (_FormulaController if isinstance(law, _StartedFormula) else CustomController)(law, formation)


def check_estimator(factory: Callable[[], Estimator]) -> None:
    """Check an estimator.

    It names its estimates and returns finite values for any number of groups while there are readings; standard
    deviations are not negative; it does not change the readings, and repeats its estimates after `start`.

    Raises:
        ContractBroken: The estimator violates one of these requirements.
    """

    def rows(part: Estimator, formation: Formation) -> Iterator[Row]:
        estimator = CustomEstimator(part, formation)
        for observation in observations(formation, estimated=False):
            if not np.isfinite(observation.speed):
                continue
            before = copy.deepcopy(observation)
            values = estimator.step(observation)
            _require_unchanged(part, before, observation)
            for name, value in values.items():
                if name.endswith("_sd") and np.any(value < 0.0):
                    raise ContractBroken(f"{type(part).__name__}.step gives a negative {name}: {value.tolist()}")
            yield tuple(np.concatenate([values[name] for name in estimator.provides]).tolist())

    _require_repeatable(factory, "step", rows)


def check_sensors(factory: Callable[[], Sensors]) -> None:
    """Check a sensor model.

    It reads a train with any number of groups, returns finite readings at some time, does not change the true values,
    and repeats its readings after `start` with the same random numbers.

    Raises:
        ContractBroken: The sensors violate one of these requirements.
    """

    def rows(part: Sensors, formation: Formation) -> Iterator[Row]:
        layout = layout_of(formation)
        sensors = CustomSensors(part, layout, formation, _PERIOD, np.random.default_rng(1))
        readings: list[Row] = []
        for sample, observation in enumerate(_braking(formation, estimated=False)):
            truth = np.zeros(layout.outputs)
            for name in ("speed", "acceleration", "wheelset_speed", "slip"):
                truth[layout.output[name]] = getattr(observation, name)
            truth[layout.output["cylinder_pressure"]] = observation.pressure
            readings.append(tuple(sensors.read(sample, truth).tolist()))
        if np.isnan(np.array(readings)).all():
            raise ContractBroken(f"{type(part).__name__}.read gives no reading at all")
        yield from readings

    _require_repeatable(factory, "read", rows)


def check_plant(factory: Callable[[], Plant], formation: Formation | None = None) -> None:
    """Check a plant.

    In a short run it starts at the given speed, coasts, and brakes on a good rail; distance, speed and
    acceleration are integrals of each other, wheels roll without braking, cylinders fill, and its slip and adhesion
    are physically possible. On a poor rail it does not exceed friction. It repeats its outputs after `start`.

    Args:
        factory: Class or function that returns a new plant.
        formation: Formation of the vehicle, with brakes; None for several formations.

    Raises:
        ContractBroken: The plant violates one of these requirements.
    """

    def rows(part: Plant, vehicle: Formation) -> Iterator[Row]:
        layout, pressure = layout_of(vehicle), tuple(vehicle.pressure_max.tolist())
        plant = CustomPlant(part, layout, speed=_SPEED, period=_PERIOD, command="pressure_command")
        opening, release = (lambda: nullcontext(plant)), (0.0,) * vehicle.groups
        trials = TrialPlant(opening=opening, layout=layout, period=_PERIOD, release=release, brake=pressure).trials()
        slowing = slowing_of(carried_mass(sum(vehicle.wheelset_load)), is_known=False)
        radius = tuple(vehicle.wheel_radius.tolist())
        for finding in findings(*trials, speed=_SPEED, radius=radius, pressure=pressure, slowing=slowing):
            if not finding.good:
                raise ContractBroken(f"{type(part).__name__}: {finding.signal} {finding.sentence}")
        yield from (tuple(row) for row in np.nan_to_num(np.vstack([trial.rows for trial in trials])).tolist())

    _require_repeatable(factory, "step", rows, None if formation is None else [formation])


def formations() -> Iterator[Formation]:
    """Yield vehicles of one, three and four groups."""
    for wheelsets in _FORMATIONS:
        dimensions = Formation(wheelsets)
        yield replace(
            dimensions,
            wheelsets_per_car=(dimensions.wheelsets,),
            wheelset_position=tuple(2.5 * i for i in range(dimensions.wheelsets)),
            wheelset_load=tuple(_BRAKE.load / count for count in wheelsets for _ in range(count)),
            brakes=(_BRAKE,) * dimensions.groups,
        )


def observations(formation: Formation, *, estimated: bool) -> Iterator[Observation]:
    """Yield observations of a train before any reading, then of one that brakes from 30 m/s to standstill."""
    groups = formation.groups
    unread, values, pressure = np.full(groups, np.nan), np.full(groups, 0.05), np.zeros(groups)
    _lock(unread, values, pressure)
    estimates = (values, 7 * values) if estimated else (None, None)
    yield Observation(0.0, np.nan, np.nan, unread, unread, estimated, *estimates, pressure, formation.pressure_max)
    yield from _braking(formation, estimated=estimated)


def _rolling(formation: Formation, *, estimated: bool) -> Observation:
    groups, speed = formation.groups, 25.0
    slip, half = np.full(groups, 0.01), 0.5 * formation.pressure_max
    estimates = (np.full(groups, 0.08), np.full(groups, 0.35)) if estimated else (None, None)
    wheels = 0.99 * speed / formation.wheel_radius
    return Observation(0.0, speed, -1.0, wheels, slip, estimated, *estimates, half, formation.pressure_max)


def _blame_inputs(factory: Callable[[], Controller], formation: Formation, shown: Sequence[Observation]) -> str:
    # The law passes if the inputs at fault are replaced by those of a rolling train.
    *before, failed = shown
    rolling = _rolling(formation, estimated=True)

    def passes(names: Sequence[str]) -> bool:
        law, limits = _adapt(factory(), formation), DemandLimits(formation)
        rolls = failed._replace(**{name: getattr(rolling, name) for name in names})
        try:
            for observation in (*before, rolls):
                limits.require_finite(law.decide(observation), observation)
        except ControllerFailed:
            return False
        return True

    blamed = ["speed", "acceleration", "wheelset_speed", "slip", "adhesion", "pad_friction", "pressure"]
    if not passes(blamed):
        return ""
    for name in tuple(blamed):
        others = [other for other in blamed if other != name]
        if passes(others):
            blamed = others
    found = ", ".join(f"{name} = {_format_value(getattr(failed, name))}" for name in blamed)
    unread = any("nan" in _format_value(getattr(failed, name)) for name in blamed)
    remedy = " NaN is what no sensor has read yet; np.nan_to_num makes it 0." if unread else ""
    return f" It fails on {found}; it does not on the values of a rolling train.{remedy}"


def _format_value(value: float | NDArray[np.float64] | None) -> str:
    return short(value.tolist() if isinstance(value, np.ndarray) else value)


def _braking(formation: Formation, *, estimated: bool) -> Iterator[Observation]:
    groups = formation.groups
    for k in range(1, 302):
        time = k * _PERIOD
        speed = max(30.0 - 10.0 * time, 0.0)
        slip = np.clip(1.5 * np.sin(2.0 * time + np.arange(groups)), 0.0, 1.0)
        wheels = (1.0 - slip) * speed / formation.wheel_radius
        pressure = formation.pressure_max * (0.5 + 0.5 * np.sin(3.0 * time))
        adhesion = 0.1 * slip / (0.02 + slip)
        estimates = (adhesion, np.full(groups, 0.35)) if estimated else (None, None)
        _lock(wheels, slip, pressure, adhesion)
        yield Observation(time, speed, -10.0, wheels, slip, estimated, *estimates, pressure, formation.pressure_max)


def _lock(*arrays: NDArray[np.float64]) -> None:
    for values in arrays:
        values.flags.writeable = False


def _require_pressures(place: str, formation: Formation, demands: NDArray[np.float64]) -> None:
    for demand, most in zip(demands, formation.pressure_max, strict=True):
        if not 0.0 <= demand <= most:
            raise ContractBroken(f"{place} demands {demand:g} Pa; a cylinder takes 0 to {most:g} Pa")


def _require_unchanged(part: object, before: Observation, after: Observation) -> None:
    for name, value, other in zip(Observation._fields, before, after, strict=True):
        if value is not None and not np.array_equal(np.asarray(value), np.asarray(other), equal_nan=True):
            raise ContractBroken(f"{type(part).__name__} changes {name} of its input")


def _require_repeatable(
    factory: Callable[[], T],
    method: str,
    rows: Callable[[T, Formation], Iterator[Row]],
    vehicles: Iterable[Formation] | None = None,
) -> None:
    """Raise an error if an object fails in a run, or if its second run on a vehicle differs from the first.

    Raises:
        ContractBroken: The object fails, its runs differ, or the factory raises an exception.
    """
    for vehicle in formations() if vehicles is None else vehicles:
        part = call_user_code(factory, lambda problem: ContractBroken(f"{short(factory)} makes no object: {problem}"))
        try:
            first, second = list(rows(part, vehicle)), list(rows(part, vehicle))
        except (ControllerFailed, EstimatorFailed, PlantFailed, ScenarioError, SensorsFailed) as problem:
            raise ContractBroken(str(problem)) from None
        if not np.array_equal(first, second, equal_nan=True):
            raise ContractBroken(
                f"{type(part).__name__}.{method} gives something else after a second start; "
                "start() must reset the state"
            )
