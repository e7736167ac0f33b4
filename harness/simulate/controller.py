"""Controllers of a scenario, from built-in laws to users' FMUs, and the valve logic behind them."""

from collections.abc import Callable, Collection
from contextlib import AbstractContextManager, ExitStack, suppress
from functools import partial

import numpy as np

from railgrip.base.errors import ControllerFailed, PlantFailed, ScenarioError
from railgrip.controllers.law import Law
from railgrip.controllers.parameters import SEARCHED
from railgrip.controllers.sampled import Sampled
from railgrip.controllers.train_level import pass_through, with_redistribution, with_shared_valves
from railgrip.controllers.valves import BAND, PULSE_MIN, ValveLogic, ValveModel
from railgrip.fmi import Description
from railgrip.scenario.parts import BuiltInLaw as LawTable
from railgrip.scenario.parts import ControllerFmu, KalmanFilter
from railgrip.scenario.quantity import in_units
from railgrip.scenario.schema import Scenario
from railgrip.simulate.controller_trial import is_deaf, order_mistake, responses
from railgrip.simulate.files import description_of, units_of
from railgrip.simulate.foreign_controller import ForeignController, foreign_controller
from railgrip.simulate.loop.parts import LawStates, LoopController
from railgrip.simulate.vehicle import VehicleData, law_named
from railgrip.vehicle.parameters import units_of_nominal_data
from railgrip.vehicle.signals import ONLY_ESTIMATED, of_law


def open_controller(
    vehicle: VehicleData,
    estimates: Collection[str],
    fmus: dict[str, Description],
    notify: Callable[[str], None],
    stack: ExitStack,
) -> tuple[LoopController, bool]:
    """Open the controller of a scenario; also return whether it commands the valves directly.

    The description of a controller FMU is added to `fmus`.

    Raises:
        ScenarioError: A parameter is wrong, or the controller requires something that the scenario does not provide.
        FmuError: An FMU does not fit.
    """
    scenario, table = vehicle.scenario, vehicle.scenario.controller
    if not isinstance(table, ControllerFmu):
        return controller_of(vehicle), False
    description = description_of(table.file.path, scenario.limits.fmu)
    name = description.file.name
    fmus[f"controller: {name}" if name in fmus else name] = description
    values = in_units("[controller.parameters]", table.parameters, units_of(description))
    groups = vehicle.formation.groups
    opening = partial(foreign_controller, scenario, table, description, values, groups, estimates)
    _try_controller(vehicle, opening, description, estimates, notify)
    controller, commands_valves = stack.enter_context(opening(notify))
    if commands_valves and table.redistribute:
        raise ScenarioError(
            f"{scenario.name}: [controller] redistribute shares out pressures, but {name} commands the valves; "
            "leave it out, or let the FMU give demand [Pa]"
        )
    return controller, commands_valves


def _try_controller(
    vehicle: VehicleData,
    opening: Callable[[Callable[[str], None]], AbstractContextManager[tuple[ForeignController, bool]]],
    description: Description,
    estimates: Collection[str],
    notify: Callable[[str], None],
) -> None:
    """Refuse a controller FMU whose groups are in another order, and report one that ignores slides.

    Raises:
        ScenarioError: It lowers the pressure of another group than the one that slides.
    """
    scenario = vehicle.scenario
    with suppress(ControllerFailed, PlantFailed), opening(lambda sentence: None) as (law, _):  # the stop reports these
        brakes, period = vehicle.nominal.formation.brakes, scenario.periods.controller
        changes = responses(law.decide, brakes, period, estimates={*estimates} >= ONLY_ESTIMATED)
        where = f"{scenario.name}: [controller.map]"
        if words := order_mistake(changes):
            raise ScenarioError(f"{where} does not fit {description.file.name}: in a short run it {words}.")
        if is_deaf(changes):
            notify(
                f"{where}: in a short run {description.file.name} changed no pressure while wheels slid by 60 %; if it "
                "protects from sliding, look at units and signs of its inputs."
            )


def controller_of(vehicle: VehicleData) -> LoopController:
    """Return the control law of a scenario, wrapped in the decisions for the whole train.

    Raises:
        ScenarioError: A parameter is wrong, or the controller is not a built-in law.
    """
    return _add_train_level(vehicle, _group_law(vehicle))


def exceeds_driver(scenario: Scenario) -> bool:
    """Return whether the controller applies the driver's demand itself, and commands are not limited to it."""
    law = law_named(scenario.controller.kind)
    return getattr(scenario.controller, "redistribute", False) or (law is not None and law.exceeds_driver)


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
        if exceeds_driver(scenario.revised({"controller": {"redistribute": False}})):
            raise ScenarioError(f"{scenario.name}: [controller] redistribute is part of {table.kind}; leave it out")
        if scenario.demand is None:
            raise ScenarioError(
                f"{scenario.name}: [controller] redistribute has no effect where full brake is demanded from "
                "every group; write a [demand] below it"
            )
        law = with_redistribution(
            law, groups, period=scenario.periods.controller, adhesion_max=scenario.limits.alpha_max
        )
    return with_shared_valves(law, groups, valves, table.shared_valve) if valves and max(valves) > 1 else law


def _group_law(vehicle: VehicleData) -> Law:
    """Return the law for single groups, its named set changed by [controller.parameters].

    Raises:
        ScenarioError: A parameter is wrong, or the controller is not a built-in law.
    """
    scenario = vehicle.scenario
    table = scenario.controller
    kind = law_named(table.kind) if isinstance(table, LawTable) else None
    if kind is None or not isinstance(table, LawTable):
        raise ScenarioError(f"{scenario.name}: [controller] kind '{table.kind}' is not a built-in law")
    train = units_of_nominal_data(vehicle.formation)
    parameters = {name: value for name, value in table.parameters.items() if name not in train}
    values = in_units("[controller.parameters]", parameters, kind.tuning.units())
    of_other_tables = {
        "period": scenario.periods.controller,
        "adhesion_max": scenario.limits.alpha_max,
        "pressure_lag": scenario.sensors.pressure_lag,
    }
    slip = "estimated" if isinstance(scenario.estimator, KalmanFilter) else "read"
    try:
        tuning = kind.load_tuning(scenario.actuation.kind, slip, table.tuning or SEARCHED, **(of_other_tables | values))
    except ValueError as problem:
        raise ScenarioError(f"{scenario.name}: [controller] {problem}") from problem
    law, places = kind(vehicle.nominal.formation.brakes, tuning), vehicle.formation.position
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
