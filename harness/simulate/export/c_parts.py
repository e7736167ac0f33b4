"""Export parts of a stop as FMUs or a static library: the C code of the loop, with its initial state."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import ScenarioError
from railgrip.base.files import write_bytes
from railgrip.base.records import claim
from railgrip.base.system import SampledSystem, Variable
from railgrip.controllers.sampled import Sampled
from railgrip.estimators.compiled import StepInC
from railgrip.fmus.native.discrete import (
    WrittenStep,
    align_pointers,
    memory_in_c,
    sources,
    sources_of_library,
    straight_step,
)
from railgrip.fmus.native.package import Source, c_identifier
from railgrip.fmus.native.toolchain import FAST_BUILD, Struct, static_library
from railgrip.kernel import headers, kernel, texts
from railgrip.scenario.onboard import KalmanFilter
from railgrip.scenario.schema import Scenario
from railgrip.simulate.assembly import assemble
from railgrip.simulate.export.controller_and_plant import PERIODS, Conversion, law_parameters, started_at
from railgrip.simulate.loop.interfaces import Parts, StateEstimator
from railgrip.simulate.loop.loop import Loop, Structs
from railgrip.simulate.sensors.ideal import IdealSensors
from railgrip.simulate.sensors.service import ServiceSensors
from railgrip.simulate.sensors.white import WhiteSensors
from railgrip.simulate.user_parts import NO_CUSTOM_PARTS, CustomParts
from railgrip.vehicle.signals import DRIVER_DEMAND, ESTIMATED_STATES, OBSERVATION, Layout, Role, Signal, names_of

Kind = Literal["onboard", "estimator", "sensors", "track"]
"""onboard: from readings and the driver's demand to commands; track: the rail and the driver."""

_UNITS = ("onboard.c", "exported.c")
_UNITS_OF_PLANT = ("sensors.c", "rail.c", "driver.c")
_ESTIMATED = tuple(signal for signal in OBSERVATION if signal.name != "driver_demand")
"""Signals of an observation that an estimator outputs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Role:
    """The share of one kind of FMU in a stop.

    Attributes:
        given, shown: Inputs and outputs of the FMU.
        struct: `Cycle` of cycle.h.
        formulas: Formulas in C, by field of `struct`, such as `onboard->law`.
        parameters: Parameters of the FMU.
        macros: Macros for exported.c.
    """

    given: Sequence[Variable]
    shown: Sequence[Variable]
    struct: Struct
    formulas: Mapping[str, Sampled]
    parameters: Sequence[Variable] = ()
    macros: Mapping[str, object]


def part_fmu(
    scenario: Scenario,
    kind: Kind,
    convert: Conversion = lambda system: system,
    objects: CustomParts = NO_CUSTOM_PARTS,
) -> Source:
    """Return C code and modelDescription.xml of a part of a scenario's stop; errors are those of `part_in_c`."""
    system = convert(part_in_c(scenario, kind, objects))
    # A train that begins to move would only wait for zeros.
    readings = sum(not variable.name.startswith("driver_demand") for variable in system.inputs)
    return sources(system, waits=readings if scenario.start.speed else 0, hidden=PERIODS)


def part_in_c(scenario: Scenario, kind: Kind, objects: CustomParts = NO_CUSTOM_PARTS) -> SampledSystem:
    """Return a part of a scenario's stop as a separate system.

    A step is one communication period. Readings are NaN where a sensor has no new one.

    Raises:
        ScenarioError: The part is in Python or a foreign FMU, and therefore not in C.
        FmuError: The plant does not fit.
    """
    scenario = with_filter_in_c(scenario)
    with assemble(scenario, objects=objects) as opened:
        parts, structs = opened.parts, Loop(opened.parts).structs
        return _system(f"{scenario.name}_{kind}", parts, kind, _ROLES[kind](scenario, parts, structs))


def readings_of(scenario: Scenario, objects: CustomParts = NO_CUSTOM_PARTS) -> NDArray[np.float64]:
    """Return the inputs of the onboard part in each sample of a scenario's stop, shape (samples, inputs)."""
    with assemble(with_filter_in_c(scenario), objects=objects) as opened:
        opened.run()
        recorder, parts = opened.recorder, opened.parts
        rows = recorder.rows[: recorder.written]
        demand = np.tile(parts.full, (len(rows), 1))
        if parts.driver is not None:
            demand = rows[:, recorder.block(DRIVER_DEMAND)]
        return np.hstack([rows[:, recorder.block(parts.layout.signals["reading"])], demand])


def write_library(scenario: Scenario, folder: Path, objects: CustomParts = NO_CUSTOM_PARTS) -> Iterator[Path]:
    """Write the onboard part as a library for real-time targets, with the readings of a stop to measure its run time.

    The files are library, header, worst_case.c, readings.csv and the folder `sources`; yield the files.

    Raises:
        ScenarioError: A part is not in C, see `part_in_c`.
        CompilerMissing, BuildFailed: Raised by the C compiler.
    """
    system = part_in_c(scenario, "onboard", objects)
    name, files = c_identifier(system.name), sources_of_library(system)
    assert isinstance(system.step, WrittenStep)
    units = (f"{name}.c", *system.step.units)
    names = ",".join(variable.name for variable in system.inputs)
    rows = "\n".join(",".join(map(repr, row)) for row in readings_of(scenario, objects).tolist())
    at_top = {f"{name}.h": files[f"{name}.h"], "worst_case.c": files["worst_case.c"]}
    at_top["readings.csv"] = f"{names}\n{rows}\n"
    contents = {folder / file: text.encode() for file, text in at_top.items()}
    contents |= {folder / "sources" / file: text.encode() for file, text in files.items() if file not in at_top}
    contents[folder / "sources" / f"{name}.h"] = contents[folder / f"{name}.h"]
    contents[folder / f"lib{name}.a"] = static_library(files, name, units=units, flags=FAST_BUILD)
    claim(folder, *(file.relative_to(folder).as_posix() for file in contents))
    (folder / "sources").mkdir(exist_ok=True)
    for file, content in contents.items():
        write_bytes(file, content)
        yield file


def with_filter_in_c(scenario: Scenario) -> Scenario:
    """Return the scenario with its filter in C, equal except for rounding; the decentralised filter is in C already."""
    estimator = scenario.estimator
    if not isinstance(estimator, KalmanFilter) or estimator.kind not in ("fmu", "python") or estimator.file is not None:
        return scenario
    compiled = estimator.model_copy(update={"kind": "compiled", "interface": "model_exchange"})
    return scenario.model_copy(update={"estimator": compiled})


def _system(name: str, parts: Parts, kind: Kind, role: _Role) -> SampledSystem:
    layout, estimator = parts.layout, parts.estimator
    files = {name: align_pointers(text) for name, text in headers(layout).items()}
    is_onboard = kind in ("onboard", "estimator")
    included = _UNITS if is_onboard else (*_UNITS_OF_PLANT, *_UNITS)
    files |= texts(*included) | {"export.h": "#define EXPORT\n"}
    units: tuple[str, ...] = ()
    calls = [f"    c->{field}.call = call_{_name(field)};" for field in role.formulas]
    if is_onboard and isinstance(estimator, StateEstimator):
        assert isinstance(estimator.filter, StepInC)
        files |= sources_of_filter(estimator.filter)
        units = ("plain.c",)
        calls.append("    c->filter->advance = step_plain;")
    macros = {
        "INPUT_PLACES": 0,
        "OUTPUT_PLACES": 0,
        "DEVIATIONS": 0.0,
        "BINDING": 1,
        "LAW_PARAMETERS": 0,
        **role.macros,
    }
    text = [
        *(f"#define {name} {value}" for name, value in macros.items()),
        *(("#define ONBOARD_ALONE",) if is_onboard else ()),
        *(f'#include "{name}"' for name in included),
        memory_in_c(role.struct, headers(layout).values()),
        *(write_call(_name(field), formula) for field, formula in role.formulas.items()),
        "int step_plain(double *block);",
        "static int sample(unsigned long long *memory, long long k, const double *input, const double *parameter,",
        "                  double *output)",
        "{",
        "    Cycle *c = (Cycle *)memory;",
        "    point(memory);",
        *calls,
        "    c->sample = k;",
        f"    return sample_{kind}(c, input, parameter, output);",
        "}",
    ]
    return SampledSystem(
        name=name,
        description=_DESCRIPTIONS[kind],
        period=parts.clock.period,
        inputs=tuple(role.given),
        parameters=tuple(role.parameters),
        outputs=tuple(role.shown),
        step=WrittenStep(text="\n".join(text), files=files, units=units),
    )


_DESCRIPTIONS = {
    "onboard": "Estimator, control law and valve logic, never above the driver's demand",
    "estimator": "Estimator: from readings to what a control law takes; NaN where nothing is known",
    "sensors": "Sensors: readings of the plant's outputs, NaN where there is nothing new",
    "track": "Track and driver: friction and force at the train, and demanded brake pressures",
}


def _name(field: str) -> str:
    return field.rpartition("->")[2]


def sources_of_filter(filter_: StepInC) -> dict[str, str]:
    """Return the C code of the function `step_plain` of a filter, file name → text; the unit is plain.c."""
    return {name: text for name, text in filter_.sources.items() if name == "plain.c" or name.endswith(".h")}


def write_call(name: str, formula: Sampled) -> str:
    """Return C code of a formula with the signature of `Call` in cycle.h."""
    step, count = formula.step, formula.state.size
    sizes = [step.numel_in(0), step.numel_in(1), formula.parameters.size]
    return "\n".join(
        [
            straight_step(f"f_{name}", step, sizes),
            f"static void call_{name}(double *state, const double *input, const double *parameter, double *output)",
            "{",
            f"    double following[{count + 1}];",
            "    const double *arguments[] = { state, input, parameter };",
            "    double *results[] = { following, output };",
            f"    f_{name}(arguments, results);",
            f"    memcpy(state, following, {count} * sizeof *state);",
            "}",
        ]
    )


def _track(scenario: Scenario, parts: Parts, structs: Structs) -> _Role:
    if parts.rail.sand is not None and parts.rail.sand.is_demanded:
        raise ScenarioError(
            f"[controller] {scenario.controller.kind} switches the sanders, and the FMU of the track has no input for "
            "that; leave out [[sanders]], or choose another controller"
        )
    if _switches_magnets(parts):
        raise ScenarioError(
            f"[controller] {scenario.controller.kind} switches the magnetic track brakes, and the FMU of the track has "
            "no input for that; choose another controller, or a train without them"
        )
    layout = parts.layout
    recovers = parts.rail.slip_energy is not None
    needed = ("distance", "speed", *(("slip", "adhesion", "wheelset_load", "wheelset_speed") if recovers else ()))
    given, places = _select_outputs(layout, structs, needed)
    sent = [signal for signal in layout.signals["input"] if signal.name != "command"]
    starts = np.zeros(layout.inputs)
    parts.rail.write_inputs(starts)
    shown = _of(sent, layout, np.delete(starts, np.arange(layout.inputs)[layout.input["command"]]))
    return _Role(
        given=given,
        shown=(*shown, *_of(DRIVER_DEMAND, parts.layout, parts.full)),
        struct=structs.cycle.copy_with(
            "rail", "driver", "period", plant=_plant_data(layout, structs), onboard=structs.onboard.copy_with("full")
        ),
        formulas={},
        macros={"INPUT_PLACES": places, "OUTPUT_PLACES": _positions("input", sent, layout)},
    )


def _switches_magnets(parts: Parts) -> bool:
    """Return whether the law demands the magnetic track brakes of the train."""
    law = parts.controller
    return "magnets" in parts.layout.input and isinstance(law, Sampled) and law.visible_state("magnets") is not None


def _sensors(scenario: Scenario, parts: Parts, structs: Structs) -> _Role:
    sensors, layout = parts.sensors, parts.layout
    if not isinstance(sensors, IdealSensors | WhiteSensors | ServiceSensors):
        raise ScenarioError("[sensors] read in Python and cannot leave as an FMU")
    if parts.faults is not None:
        raise ScenarioError("[[faults]] of sensors or valves cannot leave as an FMU; leave them out")
    data: dict[str, object] = {"block": 1}
    deviation = np.zeros(1) if isinstance(sensors, IdealSensors) else sensors.deviation
    if isinstance(sensors, ServiceSensors):
        needed = ("distance", "speed", "acceleration", "wheelset_speed", "cylinder_pressure", "deflection")
        data["service"] = sensors.struct.copy_with(noise=np.zeros(deviation.size), block=1)
    else:
        needed = [n for n, at in layout.output.items() if np.isin(sensors.places, np.arange(at.start, at.stop)).any()]
        if "noise" in sensors.fields:
            data["noise"] = np.zeros(deviation.size)
    given, places = _select_outputs(layout, structs, needed)
    start, meaning = float(scenario.seed % 2**32), "of the noise, a whole number"
    seed = Variable(name="seed", unit="1", start=start, description=meaning, minimum=0.0)
    return _Role(
        given=given,
        shown=_of(layout.signals["reading"], layout),
        struct=kernel(layout).struct(
            "Cycle", plant=_plant_data(layout, structs), instruments=structs.instruments.copy_with(**data)
        ),
        formulas={},
        parameters=(seed,),
        macros={"INPUT_PLACES": places, "DEVIATIONS": ", ".join(map(repr, deviation.tolist()))},
    )


def _estimator(scenario: Scenario, parts: Parts, structs: Structs) -> _Role:
    body_force = parts.estimator.body_force if isinstance(parts.estimator, StateEstimator) else None
    if body_force is not None and body_force.formula.states:
        raise ScenarioError(
            f"{scenario.name}: the filter assumes the force of the brakes on the rail itself by the commands, which "
            "are no inputs of the estimator's FMU; export the onboard part, or a train without such brakes"
        )
    struct, formulas = _filter_data(scenario, parts, structs)
    return _Role(
        given=_of(parts.layout.signals["reading"], parts.layout),
        shown=_of(_ESTIMATED, parts.layout),
        struct=struct,
        formulas=formulas,
        macros={"OUTPUT_PLACES": _positions("observation", _ESTIMATED, parts.layout)},
    )


def _onboard(scenario: Scenario, parts: Parts, structs: Structs) -> _Role:
    struct, formulas = _filter_data(scenario, parts, structs)
    law, valves = parts.controller, parts.valves
    if not isinstance(law, Sampled):
        raise ScenarioError(
            f"[controller] kind '{scenario.controller.kind}' is not a built-in law, and only these can be exported; "
            "choose another kind"
        )
    if "filter->body_force" in formulas and _switches_magnets(parts):
        raise ScenarioError(
            f"[controller] {scenario.controller.kind} switches the magnetic track brakes, which the FMU of the onboard "
            "part does not tell its filter; choose another controller, or a train without them"
        )
    formulas["onboard->law"] = law
    given = [*_of(parts.layout.signals["reading"], parts.layout), *_of(DRIVER_DEMAND, parts.layout, parts.full)]
    parameters = law_parameters(law, given)
    commands = started_at(law.formula.outputs)
    if valves is not None:
        formulas["onboard->valves"] = valves
        parameters += started_at(valves.formula.parameters, valves.parameters, "valves.")
        commands = started_at(valves.formula.outputs)
    onboard = {_name(field): formula for field, formula in formulas.items() if field.startswith("onboard")}
    struct.target("onboard").set(
        **{name: kernel(parts.layout).struct("Formula", state=formula.state) for name, formula in onboard.items()}
    )
    states = ESTIMATED_STATES if parts.estimator is not None else ()
    return _Role(
        given=given,
        shown=[*commands, *_of(states, parts.layout)],
        struct=struct,
        formulas=formulas,
        parameters=parameters,
        macros={
            "BINDING": int(parts.driver is None or parts.driver.struct.pointer.binding),
            "LAW_PARAMETERS": law.parameters.size,
            "OUTPUT_PLACES": _positions("estimate", states, parts.layout) or 0,
        },
    )


_ROLES: Mapping[Kind, Callable[[Scenario, Parts, Structs], _Role]] = {
    "onboard": _onboard, "estimator": _estimator, "sensors": _sensors, "track": _track,
}  # fmt: skip


def _plant_data(layout: Layout, structs: Structs) -> Struct:
    return structs.plant.copy_with("slip_radius", inputs=np.zeros(layout.inputs), outputs=np.zeros(layout.outputs))


def _filter_data(scenario: Scenario, parts: Parts, structs: Structs) -> tuple[Struct, dict[str, Sampled]]:
    """Return the structs of filter and observation, and the formulas of the filter's inputs, if any."""
    layout, estimator = parts.layout, parts.estimator
    onboard = structs.onboard.copy_with("radius", "full", "estimator_rate", "controller_rate")
    cycle = kernel(layout).struct("Cycle", instruments=kernel(layout).struct("Instruments"), onboard=onboard)
    if estimator is None:
        return cycle, {}
    if scenario.has_traction:
        raise ScenarioError(
            "[demand] has traction, which the filter knows and its FMU has no input for; leave out traction, or "
            "[estimator]"
        )
    if not isinstance(estimator, StateEstimator) or not isinstance(estimator.filter, StepInC):
        raise ScenarioError(
            f"[estimator] kind '{scenario.estimator.kind}' is not in C and cannot leave as an FMU; kinds compiled, "
            "python and fmu do, with a model of this project or a Modelica class"
        )
    cycle.set(filter=structs.filter)
    formulas = {"filter->reference_speed": estimator.free_wheel, "filter->body_force": estimator.body_force}
    return cycle, {field: formula for field, formula in formulas.items() if formula is not None}


def _select_outputs(layout: Layout, structs: Structs, names: Sequence[str]) -> tuple[list[Variable], str]:
    """Return those of the named plant outputs that exist as inputs, and their positions among all outputs, for C."""
    absent = np.isnan(structs.plant.target("outputs"))
    signals = [s for s in layout.signals["output"] if s.name in names and not absent[layout.output[s.name]].any()]
    return _of(signals, layout), _positions("output", signals, layout)


def _positions(role: Role, signals: Iterable[Signal], layout: Layout) -> str:
    """Return the positions of signals in a vector, for C."""
    places = layout.places[role]
    slices = [places[signal.name.removeprefix(f"{role}_")] for signal in signals]
    return ", ".join(str(number) for place in slices for number in range(place.start, place.stop))


def _of(signals: Sequence[Signal], layout: Layout, starts: NDArray[np.float64] | None = None) -> list[Variable]:
    variables: list[Variable] = []
    for signal in signals:
        for name in names_of(signal, layout.formation):
            start = 0.0 if starts is None else float(starts[len(variables)])
            variables.append(Variable(name=name, unit=signal.unit, start=start, description=signal.meaning))
    return variables
