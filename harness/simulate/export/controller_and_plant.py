"""Export the controller of a scenario, its valve logic and its plant as FMUs for other tools.

Start values of the plant are the scenario's parameters. Inputs and outputs of a part may be in the units and with the
signs of a foreign plant.
"""

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from railgrip.base.errors import ScenarioError
from railgrip.base.names import ElementName
from railgrip.base.system import SampledSystem, Variable
from railgrip.controllers.sampled import Sampled
from railgrip.fmi import Binding
from railgrip.fmi.archive import read_description, read_sources
from railgrip.fmus.native.c_source import number
from railgrip.fmus.native.discrete import WrittenStep, sources
from railgrip.fmus.native.package import Source
from railgrip.scenario.schema import Scenario
from railgrip.scenario.vehicle_table import ModelicaPlant
from railgrip.simulate.bound_plant import binding_of, perturb_parameters, values_of
from railgrip.simulate.controller import controller_of, exceeds_driver, valve_logic_of
from railgrip.simulate.user_parts import NO_CUSTOM_PARTS, CustomParts, FormulaLaw, UserParts
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.vehicle.signals import Layout

Conversion = Callable[[SampledSystem], SampledSystem]
"""Function that returns a system with other units at its interface."""

_VALVES = "valves."
_MEMORY = "memory."
PERIODS = frozenset({"period", _VALVES + "period"})
"""Parameters for the period of the step: the FMU has a fixed one, and any other value would be wrong."""


def controller_fmu(
    scenario: Scenario,
    *,
    with_valves: bool = True,
    convert: Conversion = lambda system: system,
    objects: CustomParts = NO_CUSTOM_PARTS,
) -> Source:
    """Return C code and modelDescription.xml of a controller, with its valve logic if `with_valves` is set.

    They are for `railgrip.fmus.native.package.pack`. A step of the FMU is one period of the controller: outputs at its
    end are decided on the inputs at its beginning. Inputs are those of `railgrip.controllers.observation.Observation`.
    Outputs are the commands of the scenario's plant, limited to `driver_demand`, which is full pressure until it is
    set. Parameters may be set before the first step, except for the period, which is fixed: a step with another period
    is refused.

    Raises:
        ScenarioError: The controller is not a formula, such as the ideal bound.
    """
    vehicle = VehicleData(scenario)
    groups = vehicle.nominal.formation.brakes
    own = UserParts(objects, scenario, vehicle.layout).controller()
    law = controller_of(vehicle, own if isinstance(own, FormulaLaw) else None)
    valves = valve_logic_of(vehicle) if with_valves else None
    assert isinstance(law, Sampled)
    states = started_at(law.formula.states, law.state, _MEMORY)
    parameters = law_parameters(law, law.formula.inputs)
    # A law that redistributes applies the driver's demand itself, and raises it for some groups.
    limited = law.step if exceeds_driver(scenario.controller) else _limit_demands(law, vehicle.layout)
    outputs, step = law.formula.outputs, limited
    if valves is not None:
        states += started_at(valves.formula.states, valves.state, _MEMORY + _VALVES)
        parameters += started_at(valves.formula.parameters, valves.parameters, _VALVES)
        outputs, step = valves.formula.outputs, _in_series(law, limited, valves, vehicle.layout)
    full = {f"driver_demand[{g}]": group.pressure_max for g, group in enumerate(groups, start=1)}
    system = SampledSystem(
        name=law.formula.name,
        description=law.formula.description,
        period=scenario.periods.controller,
        states=states,
        inputs=started_at(law.formula.inputs, [full.get(variable.name, 0.0) for variable in law.formula.inputs]),
        parameters=parameters,
        outputs=started_at(outputs),
        step=step,
    )
    return sources(convert(system), waits=int(scenario.start.speed > 0.0), hidden=PERIODS)


def valves_fmu(vehicle: VehicleData, convert: Conversion) -> Source | None:
    """Return the source of the valve logic alone, from demanded and measured pressures.

    The result is None if the plant has no valves.
    """
    valves = valve_logic_of(vehicle)
    if valves is None:
        return None
    formula = valves.formula
    system = SampledSystem(
        name=formula.name,
        description=formula.description,
        period=vehicle.scenario.periods.controller,
        states=started_at(formula.states, valves.state, _MEMORY),
        inputs=started_at(formula.inputs),
        parameters=started_at(formula.parameters, valves.parameters),
        outputs=started_at(formula.outputs),
        step=valves.step,
    )
    # Without waiting for all inputs, an instant without a demand would be held for the minimum pulse.
    return sources(convert(system), waits=len(formula.inputs), hidden=PERIODS)


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
    names = {ElementName.of(variable.name).array for variable in inputs}
    return tuple(
        replace(variable, name=f"parameters.{variable.name}")
        if ElementName.of(variable.name).array in names
        else variable
        for variable in started_at(law.formula.parameters, law.parameters)
    )


def started_at(
    variables: Sequence[Variable], starts: Iterable[float] | None = None, prefix: str = ""
) -> tuple[Variable, ...]:
    """Return variables with other start values, without them with 0, and a prefix to their names."""
    return tuple(
        replace(variable, name=prefix + variable.name, start=float(start))
        for variable, start in zip(variables, [0.0] * len(variables) if starts is None else starts, strict=True)
    )


_HEAD = "static int sample("


def in_other_units(system: SampledSystem, inputs: Mapping[str, float], outputs: Mapping[str, float]) -> SampledSystem:
    """Return a system that converts some of its inputs and outputs by a factor.

    Converted variables have no unit, so that no other tool converts them again.

    Args:
        system: System in SI.
        inputs: Name of an input → its value in the system per value given.
        outputs: Name of an output → value to show per value in the system.
    """
    into = [inputs.get(variable.name, 1.0) for variable in system.inputs]
    out = [outputs.get(variable.name, 1.0) for variable in system.outputs]
    if all(factor == 1.0 for factor in (*into, *out)):
        return system
    return replace(
        system,
        inputs=_variables(system.inputs, [1.0 / factor for factor in into]),
        outputs=_variables(system.outputs, out),
        step=_written(system.step, into, out)
        if isinstance(system.step, WrittenStep)
        else _formula(system.step, into, out),
    )


def _variables(variables: Sequence[Variable], factors: Sequence[float]) -> tuple[Variable, ...]:
    return tuple(
        variable
        if factor == 1.0
        else replace(
            variable,
            unit="",
            start=factor * variable.start,
            description=f"{variable.description}; in the unit and with the sign of the plant",
        )
        for variable, factor in zip(variables, factors, strict=True)
    )


def _formula(step: ca.Function, into: Sequence[float], out: Sequence[float]) -> ca.Function:
    arguments = [step.sx_in(place) for place in range(step.n_in())]
    following, output = step(*[arguments[0], arguments[1] * ca.DM(into), *arguments[2:]])
    return ca.Function("step", arguments, [following, output * ca.DM(out)])


def _written(step: WrittenStep, into: Sequence[float], out: Sequence[float]) -> WrittenStep:
    text = [
        step.text.replace(_HEAD, "static int sample_in_si("),
        f"static const double factor_of_input[] = {{ {', '.join(map(repr, (*into, 0.0)))} }};",
        f"static const double factor_of_output[] = {{ {', '.join(map(repr, (*out, 0.0)))} }};",
        f"{_HEAD}unsigned long long *memory, long long k, const double *input, const double *parameter,",
        "                  double *output)",
        "{",
        f"    double converted[{len(into) + 1}];",
        f"    for (int i = 0; i < {len(into)}; i++)",
        "        converted[i] = input[i] * factor_of_input[i];",
        "    const int status = sample_in_si(memory, k, converted, parameter, output);",
        f"    for (int i = 0; i < {len(out)}; i++)",
        "        output[i] *= factor_of_output[i];",
        "    return status;",
        "}",
    ]
    return replace(step, text="\n".join(text))


def plant_fmu(scenario: Scenario) -> Source:
    """Return C code and modelDescription.xml of the plant, with the parameters of the stop as start values.

    Raises:
        ScenarioError: The plant was not compiled here from Modelica by the built-in compiler.
        FmuError: The FMU does not fit.
    """
    vehicle = VehicleData(scenario)
    file = vehicle.file.file
    if not isinstance(scenario.vehicle.source, ModelicaPlant):
        raise ScenarioError(
            f"{scenario.name}: the plant {file.name} is not compiled from Modelica here and cannot be exported with "
            "other parameters; use it as it is and set them there"
        )
    xml, files = read_description(file).decode(), read_sources(file)
    if "model.c" not in files:
        raise ScenarioError(
            f"{scenario.name}: the plant {file.name} was compiled by OpenModelica, which leaves out the C code; "
            "`railgrip build --compiler native` compiles it with the built-in compiler"
        )
    binding = binding_of(vehicle)
    values = values_of(vehicle, binding)
    if scenario.vehicle.nudge is not None:
        values |= perturb_parameters(values, vehicle.file, scenario.vehicle.nudge)
    values |= _inputs_at_start(vehicle, binding)
    model = _with_starts(files["model.c"], vehicle, values)
    description = vehicle.file.co_simulation
    assert description is not None
    units = tuple(dict.fromkeys(file.attrib["name"] for file in ET.fromstring(xml).iter("File"))) or ("model.c",)
    return Source.of(description.identifier, files | {"model.c": model}, _write_start_values(xml, values), units)


def _inputs_at_start(vehicle: VehicleData, binding: Binding) -> dict[str, float]:
    inputs = np.zeros(vehicle.layout.inputs)
    vehicle.rail().write_inputs(inputs)
    values = dict(zip(binding.inputs.elements, inputs.tolist(), strict=True))
    return {variable: gain * values[name] + shift for name, (variable, gain, shift) in binding.inputs.ties().items()}


def _with_starts(model: str, vehicle: VehicleData, values: Mapping[str, float]) -> str:
    """Return the C code with other start values of inputs and parameters: its tables are indexed by value reference."""
    sizes = {name: int(count) for name, count in re.findall(r"#define (NX|NU|NP) (\d+)", model)}
    first = 1 + 2 * sizes["NX"]
    for name, size in (("u", sizes["NU"]), ("p", sizes["NP"])):
        head, begin, rest = model.partition(f"start_{name}[] = {{ ")
        table, end, tail = rest.partition(" };")
        entries = table.split(", ")
        for variable, value in values.items():
            place = vehicle.file.variables[variable].reference - first
            if 0 <= place < size:
                entries[place] = number(value)
        model, first = head + begin + ", ".join(entries) + end + tail, first + size
    return model


def _write_start_values(xml: str, values: Mapping[str, float]) -> str:
    def changed(row: re.Match[str]) -> str:
        value = values.get(ET.fromstring(row[0]).get("name", ""))
        return row[0] if value is None else re.sub(r' start="[^"]*"', f' start="{value!r}"', row[0])

    return re.sub(r"<ScalarVariable .*</ScalarVariable>", changed, xml)
