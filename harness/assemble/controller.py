"""The controller of a scenario and what its commands go through: laws, valves, FMUs of one's own."""

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import numpy as np

from railgrip.assemble.files import description_of, units_of
from railgrip.assemble.foreign_controller import foreign_controller
from railgrip.assemble.vehicle import VehicleData, units_of_nominal_data
from railgrip.controllers import tuning
from railgrip.controllers.adhesion_based import AdhesionBased, LiteralAdhesionBased
from railgrip.controllers.brake import BrakeGroup
from railgrip.controllers.constant_slip import ConstantSlip, ConstantSlipTuning
from railgrip.controllers.extremum_seeking import ExtremumSeeking, ExtremumSeekingTuning
from railgrip.controllers.full_brake import FullBrake
from railgrip.controllers.law import Law, Tuning
from railgrip.controllers.sampled import Sampled
from railgrip.controllers.slip_based import SlipBased
from railgrip.controllers.slope_seeking import SlopeSeeking
from railgrip.controllers.train_level import OverTheTrain, pass_through, with_redistribution, with_shared_valves
from railgrip.controllers.valves import ValveLogic, ValveModel
from railgrip.controllers.wheel_reference import WheelReference, WheelReferenceTuning
from railgrip.custom import DemandLimits, Limited
from railgrip.errors import ScenarioError
from railgrip.fmu import Description
from railgrip.loop.parts import Controller, LawStates
from railgrip.scenario.custom import Custom
from railgrip.scenario.parties import AdhesionLaw, ControllerFmu, KalmanFilter, SlipLaw
from railgrip.scenario.quantity import in_units
from railgrip.scenario.schema import Scenario
from railgrip.scenario.sensors import ServiceSensors
from railgrip.signals import of_law


def controlling(
    vehicle: VehicleData,
    estimates: Collection[str],
    fmus: dict[str, Description],
    limits: DemandLimits,
    tell: Callable[[str], None],
    stack: ExitStack,
) -> tuple[Controller, bool]:
    """Open the controller of a scenario; return also whether it commands the valves itself.

    An FMU that takes part adds itself to `fmus`, and what it demands is limited by `limits`.

    Raises:
        ScenarioError: A parameter is wrong, or the controller asks for something that is not there.
        FmuError: An FMU does not fit.
    """
    scenario, table = vehicle.scenario, vehicle.scenario.controller
    if not isinstance(table, ControllerFmu):
        return controller_of(vehicle), False
    description = description_of(table.file.path, scenario.limits.fmu.limits())
    name = description.file.name
    fmus[f"controller: {name}" if name in fmus else name] = description
    values = in_units("[controller.parameters]", table.parameters, units_of(description))
    groups = vehicle.formation.groups
    context = foreign_controller(scenario, table, description, values, groups, estimates, tell)
    controller, commands_valves = stack.enter_context(context)
    if not commands_valves:
        return over_the_train(vehicle, Limited(controller, limits)), False
    if table.redistribute:
        raise ScenarioError(
            f"{scenario.name}: [controller] redistribute shares out pressures, but {name} commands the valves; "
            "leave it out, or let the FMU give demand [Pa]"
        )
    return controller, True


def controller_of(vehicle: VehicleData) -> Controller:
    """Return the control law of a scenario with what is decided for the whole train.

    Raises:
        ScenarioError: A parameter is wrong, or the controller is no law of ours.
    """
    return _decided_over_the_train(vehicle, _group_law(vehicle))


def over_the_train(vehicle: VehicleData, controller: Controller) -> Controller:
    """Return a controller that is no law of ours with what is decided for the whole train, if anything is.

    Raises:
        ScenarioError: Redistribution has nothing to share out.
    """
    alone = pass_through(vehicle.controlled.brakes)
    over = _decided_over_the_train(vehicle, alone)
    return controller if over is alone else OverTheTrain(controller, over)


def _decided_over_the_train(vehicle: VehicleData, law: Law) -> Law:
    """Return a law with redistribution and shared valves as [controller] and the formation want them."""
    scenario, groups, table = vehicle.scenario, vehicle.controlled.brakes, vehicle.scenario.controller
    valves = vehicle.formation.groups_per_valve
    if table.redistribute:
        if valves and max(valves) > 1:
            raise ScenarioError(
                f"{scenario.name}: [controller] redistribute asks single groups for more, groups_per_valve is "
                f"{list(valves)}: a valve gives all its groups the same; leave out redistribute"
            )
        if scenario.demand is None:
            raise ScenarioError(
                f"{scenario.name}: [controller] redistribute has nothing to give where full brake is asked of every "
                "group; write a [demand] below it"
            )
        law = with_redistribution(
            law, groups, period=scenario.periods.controller, adhesion_max=scenario.limits.alpha_max
        )
    return with_shared_valves(law, groups, valves, table.shared_valve) if valves and max(valves) > 1 else law


def _group_law(vehicle: VehicleData) -> Law:
    """Return the law for single groups, its named set changed by [controller.parameters].

    Raises:
        ScenarioError: A parameter is wrong, or the controller is no law of ours.
    """
    scenario, groups = vehicle.scenario, vehicle.controlled.brakes
    table = scenario.controller
    if isinstance(table, ControllerFmu | Custom) or table.kind in ("ideal_bound", "ideal_tracking"):
        raise ScenarioError(f"{scenario.name}: [controller] kind '{table.kind}' is no law of this project")
    train = units_of_nominal_data(vehicle.formation)
    own = {name: value for name, value in table.parameters.items() if name not in train}
    where = "[controller.parameters]"
    if table.kind == "full_brake":
        in_units(where, own, {})
        return FullBrake(groups)
    if isinstance(table, SlipLaw):
        values = in_units(where, own, {"low": "1", "high": "1", "speed_min": "m/s"})
        levels = replace(tuning.PAPER_LEVELS, hold=table.kind == "slip_three_state")
        if table.tuning != "paper":
            slip = "estimated" if isinstance(scenario.estimator, KalmanFilter) else "read"
            levels = replace(levels, **_searched(scenario, table, slip))
        try:
            return SlipBased(groups, replace(levels, **values))
        except ValueError as problem:
            raise ScenarioError(f"{where}: {problem}") from problem
    law, base, fixed = _law_of(scenario, table.kind)
    values = in_units(where, own, type(base).units())
    try:
        return law(groups, replace(base, **fixed, **values))
    except ValueError as problem:
        raise ScenarioError(f"{where}: {problem}") from problem


def _searched(scenario: Scenario, table: SlipLaw | AdhesionLaw, slip: tuning.SlipSource) -> Mapping[str, float]:
    """Return the set of parameters that [controller] names.

    Raises:
        ScenarioError: The law was not searched for that, or not with this actuation.
    """
    try:
        return tuning.searched(table.kind, scenario.actuation.kind, slip, type_test=table.tuning == "type_test")
    except ValueError as problem:
        raise ScenarioError(f"{scenario.name}: [controller] tuning '{table.tuning}': {problem}") from problem


def _law_of(
    scenario: Scenario, kind: str
) -> tuple[Callable[[Sequence[BrakeGroup], Any], Law], Tuning, dict[str, float]]:
    """Return a law, its parameters, and those of them that other tables of a scenario set."""
    actuation, period = scenario.actuation.kind, {"period": scenario.periods.controller}
    if kind in ("adhesion_based", "adhesion_literal"):
        law_class = AdhesionBased if kind == "adhesion_based" else LiteralAdhesionBased
        base = tuning.PEAK_SEEKING[actuation]
        if isinstance(scenario.controller, AdhesionLaw) and scenario.controller.tuning == "type_test":
            base = replace(base, **_searched(scenario, scenario.controller, "estimated"))
        return law_class, base, period | {"adhesion_max": scenario.limits.alpha_max}
    if kind == "slope_seeking":
        lag = scenario.sensors.pressure.lag if isinstance(scenario.sensors, ServiceSensors) else 0.0
        return SlopeSeeking, tuning.SLOPE, period | {"adhesion_max": scenario.limits.alpha_max, "pressure_lag": lag}
    law, parameters = {
        "wheel_reference": (WheelReference, WheelReferenceTuning),
        "constant_slip": (ConstantSlip, ConstantSlipTuning),
        "extremum_seeking": (ExtremumSeeking, ExtremumSeekingTuning),
    }[kind]
    slip = "estimated" if isinstance(scenario.estimator, KalmanFilter) else "read"
    return law, parameters(**period, **tuning.of(kind, actuation, slip)), period


def law_states(controller: Controller) -> LawStates | None:
    """Return what a controller shows of its states; None where it shows none."""
    if not isinstance(controller, Sampled) or not (visible := controller.visible):
        return None
    places = np.array([place for place, _ in visible], dtype=np.longlong)
    columns = of_law((quantity.name, quantity.unit, quantity.description) for _, quantity in visible)
    return LawStates(columns, controller.state, places)


def valve_logic_of(vehicle: VehicleData) -> ValveLogic | None:
    """Return what turns demanded pressures into commands of valves; None where the plant takes pressures."""
    scenario = vehicle.scenario
    if scenario.actuation.kind == "ideal":
        return None
    valves = vehicle.valves
    return ValveLogic(
        vehicle.controlled.pressure_max.tolist(),
        ValveModel(
            period=scenario.periods.controller,
            dead_time=0.5 * (valves["dead_fill"] + valves["dead_vent"]),
            fill_time=valves["T_fill"],
            vent_time=valves["T_vent"],
            band=tuning.VALVE_BANDS.get(scenario.controller.kind, tuning.VALVE_BAND),
            pulse_min=tuning.VALVE_PULSE_MIN,
        ),
    )
