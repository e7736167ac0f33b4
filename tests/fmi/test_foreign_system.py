"""A system of FMUs with a foreign plant in other units: no tool has to convert or transform anything."""

import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import numpy as np
import pytest
from faulty_fmu import faulty_fmu, quick_stop
from fmpy import read_model_description
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssv

from railgrip.fmus.native.package import pack
from railgrip.scenario.load import load
from railgrip.simulate.export.c_parts import part_fmu
from railgrip.simulate.export.ssp import write_ssp
from railgrip.simulate.run import run_stop

SSD, SSC = (f"{{http://ssp-standard.org/SSP1/SystemStructure{name}}}" for name in ("Description", "Common"))
SCENARIO = """
name = "abroad"
description = "costs <$5> & \\u0001"
extends = "plain"
[vehicle]
plant = "{plant}"
trust = true
[vehicle.map]
acceleration = "-retardation"
[vehicle.formation]
wheelsets_per_group = [2, 1, 1, 2]
wheelset_load = ["137 kN", "137 kN", "137 kN", "137 kN", "137 kN", "137 kN"]
[vehicle.formation.brakes]
p_max = "{p_max}"
r_wheel = "0.38 m"
"""


@pytest.fixture(scope="module")
def abroad(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a scenario whose plant has km/h, bar and retardation; brakes only have the data that a run requires."""
    folder = tmp_path_factory.mktemp("abroad")
    plant = faulty_fmu(
        folder,
        speed_unit="km/h",
        pressure_unit="bar",
        names={"acceleration": "retardation"},
        defined=["SPEED_UNIT=0.2777777777777778", "PRESSURE_UNIT=1e5", "SIGN=-1"],
    )
    file = folder / "abroad.toml"
    file.write_text(SCENARIO.format(plant=plant, p_max="2.7 bar") + quick_stop("slip_two_state"))
    return file


@pytest.fixture(scope="module")
def system(abroad: Path) -> Path:
    return write_ssp(load(abroad), abroad.with_suffix(".ssp"))


def test_fmpy_stops_the_train_where_railgrip_does(abroad: Path, system: Path):
    """FMPy passes values on unchanged: without a conversion inside the parts the train would never brake.

    It does so after all parts have stepped. The command is late by up to four periods of 10 ms at 10 m/s, 0.4 m.
    """
    scenario = load(abroad)
    values = read_ssv(str(system), "resources/parameters.ssv")
    rows = simulate_ssp(str(system), stop_time=20.0, step_size=1e-2, parameter_set=values)
    moving = rows["plant.speed"] > 3.6 * scenario.limits.stop_speed
    place = np.flatnonzero(moving)[-1] + 1
    distance = run_stop(scenario).braking_distance
    assert rows["plant.distance"][place] == pytest.approx(distance, abs=0.4)
    assert rows["plant.pressure_command[1]"][place] == pytest.approx(2.7), "bar"


def test_a_reader_that_converts_units_and_one_that_transforms_pass_the_same_values(system: Path):
    """SSP 1.0, §5.4.4.1: a tool converts between the units of connectors unless this is suppressed, and transforms."""
    root = ET.fromstring(zipfile.ZipFile(system).read("SystemStructure.ssd"))
    assert root[0].get("description") == "costs <$5> & #x01"
    units = {unit.attrib["name"]: float(unit[0].get("factor", 1)) for unit in root.iter(SSC + "Unit")}
    connectors = {
        (component.get("name"), connector.get("name")): connector[0].get("unit")
        for component in root.iter(SSD + "Component")
        for connector in component.iter(SSD + "Connector")
    }
    connections = list(root.iter(SSD + "Connection"))
    assert len(connections) > 50
    for line in connections:
        ends = [(line.get(f"{end}Element"), line.get(f"{end}Connector")) for end in ("start", "end")]
        assert line.find(SSC + "LinearTransformation") is None
        if line.get("suppressUnitConversion") == "true":
            assert connectors[ends[0]] is None or connectors[ends[1]] is None
            continue
        source, target = (connectors[end] for end in ends)
        assert source is None or target is None or units[source] == units[target]
    suppressed = [line for line in connections if line.get("suppressUnitConversion") == "true"]
    names = {line.get("startConnector") for line in suppressed if line.get("startElement") == "plant"}
    assert names == {"speed", "retardation", *(f"cylinder_pressure[{g}]" for g in range(1, 5))}


@pytest.mark.parametrize("kind", ["onboard", "sensors", "track", "estimator"])
def test_parts_need_no_more_data_of_the_brakes_than_a_run(abroad: Path, tmp_path: Path, kind: str):
    """Data that the scenario does not give is not a start value of the FMU, whose C code compiles."""
    file = pack(part_fmu(load(abroad), kind), tmp_path / "part.fmu")
    assert "nan" not in [v.start for v in read_model_description(str(file)).modelVariables]
