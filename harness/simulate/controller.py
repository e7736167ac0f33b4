"""Controllers of a scenario, from built-in laws to users' FMUs, and the valve logic behind them.

A controller FMU gets the same observation as a built-in law. Before the stop it makes a short run, in which the wheels
of one group after the other slide. A controller that protects from sliding lowers the pressure of a group whose wheels
slide. If it lowers that of another group instead, its map has groups in another order.
"""

from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from railgrip import fmi
from railgrip.base.arrays import Vector
from railgrip.base.errors import ControllerFailed, FmuError, PlantFailed, ScenarioError
from railgrip.base.names import ElementName
from railgrip.base.units import short
from railgrip.controllers.law import GroupLaw, Law, Tuning
from railgrip.controllers.observation import Observation
from railgrip.controllers.parameters import SEARCHED
from railgrip.controllers.sampled import Sampled
from railgrip.controllers.train_level import (
    pass_through,
    with_redistribution,
    with_release_limit,
    with_shared_valves,
    within_brake,
)
from railgrip.controllers.valves import BAND, PULSE_MIN, ValveLogic, ValveModel
from railgrip.fmi import Binding, Description, bind, foreign_code, open_plant
from railgrip.scenario.onboard import Actuation, Controller, ControllerFmu, KalmanFilter
from railgrip.scenario.onboard import BuiltInLaw as LawTable
from railgrip.scenario.quantity import Magnitude, in_units
from railgrip.simulate.loop.interfaces import LawStates, LoopController, LoopPlant
from railgrip.simulate.named_models import description_of_file, require_role, units_of
from railgrip.simulate.user_parts import FormulaLaw, call_user_code
from railgrip.simulate.vehicle_data import Opening, VehicleData, law_exceeds_driver, law_named
from railgrip.vehicle.brake import Brake
from railgrip.vehicle.parameters import units_of_nominal_data
from railgrip.vehicle.signals import CONTROLLER_DEMAND, OBSERVATION, ONLY_ESTIMATED, Signal, of_law

_SPEED = 25.0  # m/s
_DECELERATION = 1.0  # m/s2
_ROLLING, _SLIDING = 0.01, 0.6
"""Slip of wheels that roll in braking, and of wheels that slide."""
_PHASE = 0.5  # s
_LOWERED = 0.2
"""Share of the range of a decision by which a group's decision clearly changes."""


def responses(
    decide: Callable[[Observation], Sequence[float]], brakes: Sequence[Brake], period: float, *, estimates: bool
) -> NDArray[np.float64]:
    """Return how far each group's decision falls while wheels slide, over the range of all decisions.

    Row i belongs to the run in which the wheels of group i slide, shape (groups, groups). The run is that of a train at
    25 m/s that brakes with 1 m/s2; wheels roll for half a second before each slide, which lasts as long.

    Args:
        decide: Function that returns the decision for each group: a pressure, or the command to its valve.
        brakes: Brake of each group.
        period: Period of the controller [s].
        estimates: Whether the observation has estimates of adhesion and pad friction.

    Raises:
        ControllerFailed: The controller failed.
    """
    groups, steps = len(brakes), max(round(_PHASE / period), 2)
    radius, full = (np.array([getattr(brake, name) for brake in brakes]) for name in ("wheel_radius", "pressure_max"))
    samples = 0

    def phase(slip: Vector) -> Vector:
        nonlocal samples
        decisions: list[Sequence[float]] = []
        for _ in range(steps):
            time = samples * period
            speed = _SPEED - _DECELERATION * time
            adhesion = np.where(slip > _ROLLING, 0.05, 0.1)
            decisions.append(
                decide(
                    Observation(
                        time=time,
                        speed=speed,
                        acceleration=-_DECELERATION,
                        wheelset_speed=(1.0 - slip) * speed / radius,
                        slip=slip,
                        slip_is_estimated=estimates,
                        adhesion=adhesion if estimates else None,
                        pad_friction=np.full(groups, 0.35) if estimates else None,
                        pressure=full,
                        driver_demand=full,
                    )
                )
            )
            samples += 1
        return np.array(decisions)

    changes = np.zeros((groups, groups))
    lowest, highest = np.inf, -np.inf
    for group in range(groups):
        slip = np.full(groups, _ROLLING)
        before = phase(slip)
        slip = slip.copy()
        slip[group] = _SLIDING
        during = phase(slip)
        changes[group] = before[-1] - during.min(axis=0)
        lowest, highest = min(lowest, before.min(), during.min()), max(highest, before.max(), during.max())
    return changes / (highest - lowest) if highest > lowest else changes


def order_mistake(changes: NDArray[np.float64]) -> str:
    """Return the sentence on a controller that lowers the pressure of another group than the one that slides; else ''.

    A controller that lowers that of several groups, as one that takes the lowest demand for all, is not judged.
    """
    for group, change in enumerate(changes):
        lowered = np.flatnonzero(change > _LOWERED)
        if len(lowered) == 1 and lowered[0] != group:
            return (
                f"lowers the pressure of group {lowered[0] + 1} while the wheels of group {group + 1} slide; look at "
                "the order of groups, from the leading one on, in its inputs and its output"
            )
    return ""


_DECISIONS = (*CONTROLLER_DEMAND, Signal("command", "group", "1", "command to the valves: -1 vent, 0 hold, 1 fill"))
"""Alternative outputs of a controller FMU."""


EXPORTED: Final = "railgrip (CasADi"
"""Start of the generation tool of a law that was exported here."""
_VALID: Final = "_valid"
"""End of the names of inputs that say whether the quantity has a value."""


def _starts(binding: Binding, description: Description) -> NDArray[np.float64]:
    """Return the start values of the FMU's inputs, in the units of the harness; 0 for those without one."""
    values = np.zeros(binding.inputs.size)
    for channel in binding.inputs.channels:
        start = np.nan_to_num([description.variables[name].start for name in channel.variables])
        values[channel.positions] = (start - channel.shift) / channel.gain
    return values


def _bindable(signals: Sequence[Signal], groups: int) -> tuple[fmi.Port, ...]:
    return tuple(
        fmi.Port(name=s.name, unit=s.unit, size=0 if s.extent == "train" else groups, needed=False) for s in signals
    )


def controller_signals(groups: int) -> tuple[tuple[fmi.Port, ...], tuple[fmi.Port, ...]]:
    """Return the inputs that a controller FMU may have, and its alternative outputs, of which it has one."""
    return _bindable(OBSERVATION, groups), _bindable(_DECISIONS, groups)


class ForeignController:
    """An FMU as a control law.

    A step of the FMU lasts from one decision to the next. Its inputs are the observation at the start of the step, held
    constant. Its outputs at the end of the step are the decision, which is applied at once: a sampled law decides on
    its current inputs, and a law in continuous time leads by one period.

    The FMU never gets NaN, for which comparisons are false in most languages. A quantity without a value keeps its last
    one, or the start value of the FMU's input before the first. An input such as `slip_valid` is 1 while the slip has a
    value, else 0. Only a law that railgrip exported gets NaN, by which it defines a missing value.
    """

    def __init__(self, fmu: LoopPlant, binding: Binding, gives: str, description: Description) -> None:
        """Decide by an open FMU that has not been started; `gives` is the name of its output, demand or command."""
        self.fmu = fmu
        self._inputs, self._places = _starts(binding, description), binding.inputs.layout
        self._decision = binding.outputs.layout[gives]
        self._has_started = False
        self._knows_nan = description.generator.startswith(EXPORTED)

    def decide(self, observation: Observation) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa], or the valve command if that is the FMU's output.

        Raises:
            ControllerFailed: The FMU failed.
        """
        for name, place in self._places.items():
            if name.endswith(_VALID):
                continue
            values = np.atleast_1d(np.asarray(getattr(observation, name), dtype=np.float64))
            has_value = np.isfinite(values)
            np.copyto(self._inputs[place], values, where=has_value | self._knows_nan)
            self._inputs[self._places[name + _VALID]] = has_value
        try:
            if not self._has_started:
                self.fmu.start(self._inputs)
                self._has_started = True
            outputs = self.fmu.step(self._inputs)
        except PlantFailed as failed:
            raise ControllerFailed(f"The controller failed: {failed}") from failed
        return tuple(outputs[self._decision].tolist())


def binding_of(
    table: ControllerFmu, actuation: Actuation, description: Description, groups: int, estimates: Collection[str]
) -> tuple[Binding, str]:
    """Bind observation and decision to variables of the FMU; return the binding and the output, demand or command.

    Raises:
        FmuError: The map does not fit the FMU, or the FMU has neither output.
    """
    where = "[controller.map]"
    if not table.map:
        require_role(description, "controller", "[controller] file")
    inputs = [signal for signal in OBSERVATION if signal.name not in ONLY_ESTIMATED - {*estimates}]
    outputs = [signal for signal in _DECISIONS if signal.name in table.map] or _DECISIONS
    binding = bind(
        description,
        inputs=(
            *_bindable(inputs, groups),
            *(replace(port, name=port.name + _VALID, unit="1") for port in _bindable(inputs, groups)),
        ),
        outputs=_bindable(outputs, groups),
        table=table.map,
        where=where,
    )
    file, decisions = description.file.name, [s.name for s in outputs if s.name not in binding.outputs.absent]
    if len(decisions) != 1:
        names = " and ".join(decisions) or "neither demand nor command"
        raise FmuError(
            f"{where}: {file} gives {names}; expected is either demand [Pa] or command of the {groups} groups: state "
            'which variables they are, as in demand = "pressure[{i}]".'
        )
    if decisions == ["command"] and actuation.kind != "pneumatic":
        raise FmuError(
            f"{where}: {file} commands valves, but [actuation] kind is '{actuation.kind}', which takes pressures; make "
            "it 'pneumatic', with a plant that has valves."
        )
    return binding, decisions[0]


def open_controller(
    stop: Opening, estimates: Collection[str], own: FormulaLaw | None = None
) -> tuple[LoopController, bool]:
    """Open the controller of a scenario, or a user's formula; also return whether it commands the valves directly.

    Inputs of a controller FMU without a source, such as an adhesion that is not estimated, are reported.

    Raises:
        ScenarioError: A parameter is wrong, or the controller requires something that the scenario does not provide.
        FmuError: An FMU does not fit.
        PlantFailed: An FMU does not load.
    """
    vehicle, scenario, table = stop.vehicle, stop.vehicle.scenario, stop.vehicle.scenario.controller
    if not isinstance(table, ControllerFmu):
        return controller_of(vehicle, own), False
    description = description_of_file(table.file.path, scenario.limits.fmu)
    name = description.file.name
    stop.add_fmu(description, "controller")
    values = in_units("[controller.parameters]", table.parameters, units_of(description))
    binding, gives = binding_of(table, scenario.actuation, description, vehicle.formation.groups, estimates)

    @contextmanager
    def opening(notify: Callable[[str], None]) -> Generator[ForeignController]:
        period, limits = scenario.periods.controller, scenario.limits.fmu
        context = open_plant(
            description, binding, period=period, parameters=values, trusted=table.trust, notify=notify, limits=limits,
            table="[controller]", span=(0.0, scenario.horizon),
        )  # fmt: skip
        with foreign_code(name) if table.trust else nullcontext(), context as fmu:
            yield ForeignController(fmu, binding, gives, description)

    with suppress(ControllerFailed, PlantFailed), opening(lambda sentence: None) as law:  # the stop reports these
        _try_controller(stop, law, name, {*estimates} >= ONLY_ESTIMATED)
    if binding.unused:
        names = ", ".join(dict.fromkeys(ElementName.of(unused).array for unused in binding.unused))
        stop.notify(
            f"{name}: nothing drives its {names} ([estimator] kind is '{scenario.estimator.kind}'): the start value "
            "remains."
        )
    controller, commands_valves = stop.stack.enter_context(opening(stop.notify)), gives == "command"
    given = [key for key in ("redistribute", "release_max") if getattr(table, key)]
    problems = {
        f"[demand] limits the pressures that a controller demands, but {name} commands the valves instead; leave out "
        "[demand], or name an FMU whose output is the demand [Pa]": scenario.demand is not None,
        f"[controller] {' and '.join(given)} cannot change pressures: {name} commands the valves; leave that out, or "
        "let the FMU give demand [Pa]": bool(given),
    }
    if commands_valves and any(problems.values()):
        raise ScenarioError("\n".join(problem for problem, is_true in problems.items() if is_true))
    return controller, commands_valves


def _try_controller(stop: Opening, law: ForeignController, name: str, has_estimates: bool) -> None:
    """Refuse a controller FMU whose groups are in another order, and report one that ignores slides.

    Raises:
        ScenarioError: It lowers the pressure of another group than the one that slides.
    """
    scenario, brakes = stop.vehicle.scenario, stop.vehicle.nominal.formation.brakes
    changes = responses(law.decide, brakes, scenario.periods.controller, estimates=has_estimates)
    where = "[controller.map]"
    if words := order_mistake(changes):
        raise ScenarioError(f"{where} does not fit {name}: in a short run it {words}.")
    if np.all(np.abs(changes) < _LOWERED):
        stop.notify(
            f"{scenario.name}: {where}: in a short run {name} changed no pressure while wheels slid by 60 %; if it "
            "protects from sliding, look at units and signs of its inputs."
        )


def controller_of(vehicle: VehicleData, own: FormulaLaw | None = None) -> LoopController:
    """Return the control law of a scenario, `own` if it is a user's, wrapped in the decisions for the whole train.

    Raises:
        ScenarioError: A parameter is wrong, the controller is neither built-in nor `own`, or `own` gives no formula.
    """
    return _add_train_level(vehicle, _built_in_law(vehicle) if own is None else _own_law(vehicle, own))


def exceeds_driver(table: Controller) -> bool:
    """Return whether the controller applies the driver's demand itself, and commands are not limited to it."""
    return table.redistribute or law_exceeds_driver(table.kind)


def train_level_of(vehicle: VehicleData) -> Law | None:
    """Return the decisions for the whole train over a controller that is not a built-in law, or None.

    Raises:
        ScenarioError: Redistribution has no groups to shift pressure between.
    """
    alone = pass_through(vehicle.nominal.formation.brakes)
    over = _add_train_level(vehicle, alone)
    return None if over is alone else over


def _add_train_level(vehicle: VehicleData, law: Law) -> Law:
    scenario, groups, table = vehicle.scenario, vehicle.nominal.formation.brakes, vehicle.scenario.controller
    valves = vehicle.formation.groups_per_valve
    if table.redistribute:
        if valves and max(valves) > 1:
            raise ScenarioError(
                f"{scenario.name}: [controller] redistribute asks single groups for more, groups_per_valve is "
                f"{list(valves)}: a valve gives all its groups the same; leave out redistribute"
            )
        if law_exceeds_driver(table.kind):
            raise ScenarioError(f"{scenario.name}: [controller] redistribute is part of {table.kind}; leave it out")
        if scenario.demand is None:
            raise ScenarioError(
                f"{scenario.name}: [controller] redistribute has no effect where full brake is demanded from "
                "every group; write a [demand] below it"
            )
        law = with_redistribution(
            law, groups, period=scenario.periods.controller, adhesion_max=scenario.limits.alpha_max
        )
    if valves and max(valves) > 1:
        law = with_shared_valves(law, groups, valves, table.shared_valve)
    if table.release_max is not None:
        law = with_release_limit(law, groups, period=scenario.periods.controller, release_max=table.release_max)
    return law


def _built_in_law(vehicle: VehicleData) -> Law:
    scenario = vehicle.scenario
    table = scenario.controller
    kind = law_named(table.kind) if isinstance(table, LawTable) else None
    if kind is None or not isinstance(table, LawTable):
        raise ScenarioError(f"{scenario.name}: [controller] kind '{table.kind}' is not a built-in law")
    train = units_of_nominal_data(vehicle.formation)
    parameters = {name: value for name, value in table.parameters.items() if name not in train}
    values = in_units("[controller.parameters]", parameters, kind.tuning.units())
    try:
        slip = "estimated" if isinstance(scenario.estimator, KalmanFilter) else "read"
        name = table.tuning or SEARCHED
        return _group_law(vehicle, kind, partial(kind.load_tuning, scenario.actuation.kind, slip, name), values)
    except ValueError as problem:
        raise ScenarioError(f"{scenario.name}: [controller] {problem}") from problem


def _own_law(vehicle: VehicleData, own: FormulaLaw) -> Law:
    """Return a user's law with limited demands, after a short run of it."""
    scenario, brakes, name = vehicle.scenario, vehicle.nominal.formation.brakes, own.kind.__name__

    def failed(problem: str) -> ScenarioError:
        if "truth value" in problem:
            problem = (
                "Python's if, and, or, not, max, min and a < b < c require a value, and a symbol has none; use choose, "
                "every, either, casadi.logic_not, casadi.fmax and casadi.fmin"
            )
        return ScenarioError(f"{scenario.name}: [controller] {name} does not give a formula: {problem}")

    magnitudes = dict[str, Magnitude]()
    for key, value in own.parameters.items():
        try:
            magnitudes[key] = Magnitude(value)
        except (TypeError, ValueError) as problem:
            raise ScenarioError(
                f"{scenario.name}: [controller.parameters] {key} is {short(value)}, but a number, or a text such as "
                "'10 %', is expected"
            ) from problem
    values = in_units("[controller.parameters]", magnitudes, call_user_code(lambda: own.kind.tuning.units(), failed))

    def open_law() -> Law:
        return call_user_code(lambda: _group_law(vehicle, own.kind, own.kind.tuning_with, values), failed)

    trial, full = open_law(), vehicle.nominal.formation.pressure_max

    def decide(observation: Observation) -> Sequence[float]:
        demands = np.array(trial.decide(observation))
        if not np.all((demands >= 0.0) & (demands <= full * (1.0 + 1e-9))):
            raise ScenarioError(
                f"{scenario.name}: [controller] {name} demands {demands.tolist()} Pa in a short run, at slips of "
                f"{observation.slip.tolist()}; expected are 0 to {full.tolist()} Pa"
            )
        return demands.tolist()

    changes = responses(decide, brakes, scenario.periods.controller, estimates=bool(trial.needs))
    if words := order_mistake(changes):
        raise ScenarioError(f"{scenario.name}: [controller] {name}: in a short run it {words}.")
    return within_brake(open_law(), brakes)


def _group_law(
    vehicle: VehicleData, kind: type[GroupLaw], tuning_with: Callable[..., Tuning], values: Mapping[str, float]
) -> GroupLaw:
    """Return a law for single groups; `tuning_with` returns its parameters with `values` in SI units."""
    scenario = vehicle.scenario
    of_other_tables = {
        "period": scenario.periods.controller,
        "adhesion_max": scenario.limits.alpha_max,
        "pressure_lag": scenario.sensors.pressure_lag,
    }
    law = kind(vehicle.nominal.formation.brakes, tuning_with(**{**of_other_tables, **values}))
    places = vehicle.formation.position
    if places is not None:
        law.place([float(places[members].mean()) for members in vehicle.formation.members()])
    return law


def law_states(controller: LoopController) -> LawStates | None:
    """Return the states of a controller that are recorded in the trace, or None."""
    if not isinstance(controller, Sampled) or not (visible := controller.visible):
        return None
    places = np.array([place for place, _ in visible], dtype=np.longlong)
    columns = of_law((variable.name, variable.unit, variable.description) for _, variable in visible)
    return LawStates(columns, controller.state, places)


def valve_logic_of(vehicle: VehicleData) -> ValveLogic | None:
    """Return the logic that turns demanded pressures into valve commands; None if the plant takes pressures."""
    scenario = vehicle.scenario
    if scenario.actuation.kind == "ideal":
        return None
    valves, law = vehicle.nominal.valves, law_named(scenario.controller.kind)
    return ValveLogic(
        vehicle.nominal.formation.pressure_max.tolist(),
        ValveModel(
            period=scenario.periods.controller,
            dead_time=0.5 * (valves["dead_fill"] + valves["dead_vent"]),
            fill_time=valves["T_fill"],
            vent_time=valves["T_vent"],
            band=BAND if law is None or law.valve_band is None else law.valve_band,
            pulse_min=PULSE_MIN,
        ),
    )
