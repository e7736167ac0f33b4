"""Export the controller of a scenario, and its valve logic, as FMUs for other tools."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import casadi as ca

from railgrip.base.system import SampledSystem, Variable
from railgrip.controllers.sampled import Sampled
from railgrip.fmus.native.discrete import sources
from railgrip.fmus.native.package import Source
from railgrip.scenario.schema import Scenario
from railgrip.simulate.controller import controller_of, exceeds_driver, valve_logic_of
from railgrip.simulate.export.in_other_units import Conversion
from railgrip.simulate.vehicle import VehicleData
from railgrip.vehicle.signals import Layout

_VALVES = "valves."
_MEMORY = "memory."
PERIODS = frozenset({"period", _VALVES + "period"})
"""Parameters for the period of the step: the FMU has a fixed one, and any other value would be wrong."""


def controller_fmu(
    scenario: Scenario, *, with_valves: bool = True, convert: Conversion = lambda system: system
) -> Source:
    """Return C code and modelDescription.xml of a controller, with its valve logic if `with_valves` is set.

    They are for `railgrip.fmus.native.package.pack`. A step of the FMU is one period of the controller: outputs at its
    end are decided on the inputs at its beginning. Inputs are those of `railgrip.controllers.observation.Observation`.
    Outputs are the commands of the scenario's plant, limited to `driver_demand`, which is full pressure until it is
    set. Parameters may be set before the first step, except for the period, which is fixed: a step with another period
    is refused.

    Raises:
        ScenarioError: The controller is not a built-in law, such as the ideal bound.
    """
    vehicle = VehicleData(scenario)
    groups = vehicle.nominal.formation.brakes
    law, valves = controller_of(vehicle), valve_logic_of(vehicle) if with_valves else None
    assert isinstance(law, Sampled)
    states = started_at(law.formula.states, law.state, _MEMORY)
    parameters = law_parameters(law, law.formula.inputs)
    # A law that redistributes applies the driver's demand itself, and raises it for some groups.
    limited = law.step if exceeds_driver(scenario) else _limit_demands(law, vehicle.layout)
    outputs, step = law.formula.outputs, limited
    if valves is not None:
        states += started_at(valves.formula.states, valves.state, _MEMORY + _VALVES)
        parameters += started_at(valves.formula.parameters, valves.parameters, _VALVES)
        outputs, step = valves.formula.outputs, _in_series(law, limited, valves, vehicle.layout)
    full = {f"driver_demand[{g}]": group.pressure_max for g, group in enumerate(groups, start=1)}
    return sources(
        convert(
            SampledSystem(
                name=law.formula.name,
                description=law.formula.description,
                period=scenario.periods.controller,
                states=states,
                inputs=started_at(
                    law.formula.inputs, [full.get(variable.name, 0.0) for variable in law.formula.inputs]
                ),
                parameters=parameters,
                outputs=started_at(outputs, [0.0] * len(outputs)),
                step=step,
            )
        ),
        waits=int(scenario.start.speed > 0.0),
        hidden=PERIODS,
    )


def valves_fmu(scenario: Scenario, convert: Conversion = lambda system: system) -> Source | None:
    """Return the source of the valve logic alone, from demanded and measured pressures.

    The result is None if the plant has no valves.
    """
    valves = valve_logic_of(VehicleData(scenario))
    if valves is None:
        return None
    formula = valves.formula
    return sources(
        convert(
            SampledSystem(
                name=formula.name,
                description=formula.description,
                period=scenario.periods.controller,
                states=started_at(formula.states, valves.state, _MEMORY),
                inputs=started_at(formula.inputs, [0.0] * len(formula.inputs)),
                parameters=started_at(formula.parameters, valves.parameters),
                outputs=started_at(formula.outputs, [0.0] * len(formula.outputs)),
                step=valves.step,
            )
        ),
        # Without it, an instant without a demand would be held for the minimum pulse.
        waits=len(formula.inputs),
        hidden=PERIODS,
    )


def _limit_demands(law: Sampled, layout: Layout) -> ca.Function:
    """Return the step of a law with its demands limited to the driver's."""
    state, inputs, parameter = (law.step.sx_in(place) for place in range(3))
    following, demand = law.step(state, inputs, parameter)
    limited = ca.fmin(demand, inputs[layout.places["observation"]["driver_demand"]])
    return ca.Function("step", [state, inputs, parameter], [following, limited])


def _in_series(law: Sampled, limited: ca.Function, valves: Sampled, layout: Layout) -> ca.Function:
    """Return one step of the law followed by the valves, which take its limited demands and the pressures it reads."""
    state, inputs, parameter = (
        ca.SX.sym(name, count)
        for name, count in (
            ("state", law.state.size + valves.state.size),
            ("given", len(law.formula.inputs)),
            ("parameter", law.parameters.size + valves.parameters.size),
        )
    )
    mine, theirs = ca.vertsplit(state, [0, law.state.size, state.numel()])
    tuning, model = ca.vertsplit(parameter, [0, law.parameters.size, parameter.numel()])
    following, demand = limited(mine, inputs, tuning)
    by_name = {"demand": demand, "pressure": inputs[layout.places["observation"]["pressure"]]}
    given = ca.vertcat(*(by_name[name] for name in layout.places["valve_input"]))
    onwards, command = valves.step(theirs, given, model)
    return ca.Function("step", [state, inputs, parameter], [ca.vertcat(following, onwards), command])


def law_parameters(law: Sampled, inputs: Iterable[Variable]) -> tuple[Variable, ...]:
    """Return the parameters of a law with their values as start values.

    A name that an input of the FMU has as well, be it as an array, gets the prefix `parameters.`.
    """
    names = {_without_index(variable.name) for variable in inputs}
    return tuple(
        replace(variable, name=f"parameters.{variable.name}") if _without_index(variable.name) in names else variable
        for variable in started_at(law.formula.parameters, law.parameters)
    )


def _without_index(name: str) -> str:
    return name.partition("[")[0]


def started_at(variables: Sequence[Variable], starts: Iterable[float], prefix: str = "") -> tuple[Variable, ...]:
    """Return variables with other start values, and a prefix to their names."""
    return tuple(
        replace(variable, name=prefix + variable.name, start=float(start))
        for variable, start in zip(variables, starts, strict=True)
    )
