"""Export a scenario as a system of FMUs by SSP 1.0: plant, track, sensors, estimator, law and valves, connected."""

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from railgrip.base.errors import ScenarioError
from railgrip.base.files import write_bytes
from railgrip.base.names import ElementName, xml_text
from railgrip.base.system import SampledSystem
from railgrip.fmi import Binding
from railgrip.fmi.archive import read_description
from railgrip.fmus.native.package import Source, archive_bytes, zip_files
from railgrip.scenario.schema import Scenario
from railgrip.scenario.vehicle_table import FmuFile
from railgrip.simulate.bound_plant import binding_of, values_of
from railgrip.simulate.export.c_parts import part_fmu
from railgrip.simulate.export.controller_and_plant import controller_fmu, in_other_units, plant_fmu, valves_fmu
from railgrip.simulate.user_parts import NO_CUSTOM_PARTS, CustomParts
from railgrip.simulate.vehicle_data import VehicleData

_NAMESPACES = {
    key: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for key, name in (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"))
}
_PARAMETERS = "resources/parameters.ssv"


@dataclass(frozen=True, slots=True)
class _Component:
    """An FMU of the system, with its modelDescription.xml for names and units of its variables."""

    name: str
    content: bytes
    description: ET.Element

    def variables(self, causality: str) -> dict[str, ET.Element]:
        every = self.description.findall("ModelVariables/ScalarVariable")
        return {variable.attrib["name"]: variable[0] for variable in every if variable.get("causality") == causality}


@dataclass(frozen=True, slots=True)
class _Connection:
    """Connection of an output to an input, as (component, variable).

    Values pass unchanged: not every tool applies the transformations of SSP. The track, the sensors and the last part
    before the plant convert them to and from the units and signs of a foreign plant.
    """

    source: tuple[str, str]
    target: tuple[str, str]
    is_converted: bool = False


def write_ssp(
    scenario: Scenario, path: Path, platforms: Sequence[str] = (), objects: CustomParts = NO_CUSTOM_PARTS
) -> Path:
    """Write a scenario's system into a file.

    The parameters of the scenario are start values of the FMUs and, in addition, a parameter set of the system.

    Args:
        scenario: Scenario to export.
        path: Path of the .ssp file.
        platforms: See `railgrip.fmus.native.package.archive_bytes`.
        objects: Folders of the classes that the scenario names.

    Raises:
        ScenarioError: A part cannot be exported as an FMU.
        FmuError: The plant does not fit.
    """
    vehicle = VehicleData(scenario)
    binding = binding_of(vehicle)
    components = {component.name: component for component in _components(vehicle, binding, platforms, objects)}
    connections = [*_connections(vehicle, binding, components)]
    members = {f"resources/{name}.fmu": component.content for name, component in components.items()}
    members["SystemStructure.ssd"] = _bytes(_structure(scenario, components, connections))
    members[_PARAMETERS] = _bytes(_parameter_set(vehicle, components))
    write_bytes(path, zip_files(members))
    return path


def _components(
    vehicle: VehicleData, binding: Binding, platforms: Sequence[str], objects: CustomParts
) -> Iterator[_Component]:
    scenario = vehicle.scenario
    if isinstance(scenario.vehicle.source, FmuFile):
        file = vehicle.file.file
        if vehicle.file.fmi != 2 or vehicle.file.co_simulation is None:
            raise ScenarioError(
                f"{scenario.name}: all components of a system are Co-Simulation by FMI 2.0, the plant {file.name} is "
                "not; export it as that"
            )
        yield _Component("plant", file.read_bytes(), ET.fromstring(read_description(file)))
        sources: dict[str, Source | None] = {}
    else:
        sources = {"plant": plant_fmu(scenario)}
    of_plant, to_plant = _factors(binding.outputs.ties()), _factors(binding.inputs.ties())
    command = "valve_command" if scenario.actuation.kind == "pneumatic" else "pressure_command"

    def commands(system: SampledSystem) -> SampledSystem:
        names = {v.name: _command_of(command, v.name) for v in system.outputs}
        return in_other_units(system, {}, {own: to_plant[name] for own, name in names.items() if name in to_plant})

    def convert(system: SampledSystem) -> SampledSystem:
        return in_other_units(system, of_plant, to_plant)

    sources |= {
        "track": part_fmu(scenario, "track", convert, objects),
        "sensors": part_fmu(scenario, "sensors", lambda system: in_other_units(system, of_plant, {}), objects),
        "estimator": part_fmu(scenario, "estimator", objects=objects),
    }
    if (valves := valves_fmu(vehicle, commands)) is None:
        sources["law"] = controller_fmu(scenario, with_valves=False, convert=commands, objects=objects)
    else:
        sources |= {"law": controller_fmu(scenario, with_valves=False, objects=objects), "valves": valves}
    for name, source in sources.items():
        if source is not None:
            yield _Component(name, archive_bytes(source, platforms=platforms), ET.fromstring(source.xml))


def _factors(ties: Mapping[str, tuple[str, float, float]]) -> dict[str, float]:
    """Return the factor of each element whose unit or sign differs."""
    return {name: gain for name, (_, gain, _) in ties.items() if gain != 1.0}


def _of_plant(vehicle: VehicleData, tie: tuple[str, float, float]) -> tuple[tuple[str, str], bool]:
    """Return a variable of the plant as the end of a connection, and whether it is converted.

    Raises:
        ScenarioError: The variable is not Real, or has a unit with an offset.
    """
    variable, gain, shift = tie
    kind = vehicle.file.variables[variable].kind
    if kind != "Real" or shift:
        fault = "in a unit with an offset" if shift else f"of type {kind}"
        raise ScenarioError(
            f"{vehicle.scenario.name}: the plant {vehicle.file.file.name} has '{variable}' {fault}, which a system of "
            "FMUs does not convert; give the FMU a Real variable in SI"
        )
    return ("plant", variable), gain != 1.0


def _command_of(command: str, variable: str) -> str:
    """Return the plant's input for an output of the law or the valves."""
    return command + ElementName.of(variable).bracket


def _connections(vehicle: VehicleData, binding: Binding, components: Mapping[str, _Component]) -> Iterator[_Connection]:
    outputs, inputs = binding.outputs.ties(), binding.inputs.ties()
    for name in ("track", "sensors"):
        for variable in components[name].variables("input"):
            if variable in outputs:
                source, is_converted = _of_plant(vehicle, outputs[variable])
                yield _Connection(source, (name, variable), is_converted)
    from_track = components["track"].variables("output")
    for variable in from_track.keys() & inputs.keys():
        yield _Connection(("track", variable), *_of_plant(vehicle, inputs[variable]))
    for source, target in (("sensors", "estimator"), ("estimator", "law"), ("track", "law"), ("law", "valves")):
        if target in components:
            wanted = components[target].variables("input")
            for variable in components[source].variables("output"):
                if variable in wanted:
                    yield _Connection((source, variable), (target, variable))
    last, command = ("valves", "valve_command") if "valves" in components else ("law", "pressure_command")
    if "valves" in components:
        for variable in components["valves"].variables("input"):
            if variable.startswith("pressure["):
                yield _Connection(("estimator", variable), ("valves", variable))
    for variable in components[last].variables("output"):
        yield _Connection((last, variable), *_of_plant(vehicle, inputs[_command_of(command, variable)]))


def _structure(
    scenario: Scenario, components: Mapping[str, _Component], connections: Sequence[_Connection]
) -> ET.Element:
    root = _element(None, "ssd:SystemStructureDescription", version="1.0", name=scenario.name)
    system = _element(root, "ssd:System", name=scenario.name, description=scenario.description)
    bindings = _element(system, "ssd:ParameterBindings")
    _element(bindings, "ssd:ParameterBinding", source=_PARAMETERS)
    elements = _element(system, "ssd:Elements")
    for name, component in components.items():
        component_ = _element(elements, "ssd:Component", name=name, type="application/x-fmu-sharedlibrary")
        component_.set("source", f"resources/{name}.fmu")
        connectors = _element(component_, "ssd:Connectors")
        for kind, ends in (("input", "target"), ("output", "source")):
            used = {
                variable
                for owner, variable in (getattr(connection, ends) for connection in connections)
                if owner == name
            }
            for variable, type_ in component.variables(kind).items():
                if variable in used:
                    connector = _element(connectors, "ssd:Connector", name=variable, kind=kind)
                    _element(connector, f"ssc:{type_.tag}", **_unit(type_))
    lines = _element(system, "ssd:Connections")
    for connection in connections:
        line = _element(
            lines, "ssd:Connection", startElement=connection.source[0], startConnector=connection.source[1],
            endElement=connection.target[0], endConnector=connection.target[1],
        )  # fmt: skip
        if connection.is_converted:
            line.set("suppressUnitConversion", "true")
    _units(root, "ssd:Units", components)
    begin = scenario.plant_begin
    stop = repr(begin + scenario.horizon)
    _element(root, "ssd:DefaultExperiment", startTime=f"{begin:g}", stopTime=stop)
    return root


def _parameter_set(vehicle: VehicleData, components: Mapping[str, _Component]) -> ET.Element:
    root = _element(None, "ssv:ParameterSet", version="1.0", name=vehicle.scenario.name)
    parameters = _element(root, "ssv:Parameters")
    values = values_of(vehicle, binding_of(vehicle))
    for name, component in components.items():
        for variable, type_ in component.variables("parameter").items():
            value = values.get(variable) if name == "plant" else type_.get("start")
            if value is not None and type_.tag == "Real":
                entry = _element(parameters, "ssv:Parameter", name=f"{name}.{variable}")
                _element(entry, "ssv:Real", value=str(value), **_unit(type_))
    _units(root, "ssv:Units", components)
    return root


def _units(root: ET.Element, tag: str, components: Mapping[str, _Component]) -> None:
    units = {
        unit.attrib["name"]: unit.find("BaseUnit")
        for component in components.values()
        for unit in component.description.findall("UnitDefinitions/Unit")
    }
    group = _element(root, tag)
    for name, base in units.items():
        _element(_element(group, "ssc:Unit", name=name), "ssc:BaseUnit", **({} if base is None else base.attrib))


def _unit(type_: ET.Element) -> dict[str, str]:
    return {"unit": type_.attrib["unit"]} if type_.tag == "Real" and "unit" in type_.attrib else {}


def _element(parent: ET.Element | None, tag: str, **attributes: str) -> ET.Element:
    key, _, name = tag.partition(":")
    full, texts = f"{{{_NAMESPACES[key]}}}{name}", {key: xml_text(text) for key, text in attributes.items()}
    return ET.Element(full, texts) if parent is None else ET.SubElement(parent, full, texts)


def _bytes(root: ET.Element) -> bytes:
    for key, uri in _NAMESPACES.items():
        ET.register_namespace(key, uri)
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True)
