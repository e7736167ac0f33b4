"""The plant of a scenario as an FMU whose start values are the scenario's parameters."""

import re
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Mapping

import numpy as np

from railgrip.base.errors import ScenarioError
from railgrip.fmi import Binding
from railgrip.fmus.native.c_source import number
from railgrip.fmus.native.package import Source
from railgrip.scenario.schema import Scenario
from railgrip.scenario.vehicle import ModelicaPlant
from railgrip.simulate.plant import binding_of, perturb_parameters, values_of
from railgrip.simulate.vehicle import VehicleData

_MODEL = "sources/model.c"


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
    with zipfile.ZipFile(file) as archive:
        xml = archive.read("modelDescription.xml").decode()
        names = [name for name in archive.namelist() if name.startswith("sources/") and name.endswith((".c", ".h"))]
        files = {name.removeprefix("sources/"): archive.read(name).decode() for name in names}
    if _MODEL not in names:
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
    return Source.of(description.identifier, files | {"model.c": model}, _write_start_values(xml, values))


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
