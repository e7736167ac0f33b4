"""Stops whose parts are exported as FMUs: FMPy steps them without railgrip."""

import re
import runpy
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd, read_ssv
from fmpy.validation import validate_fmu
from slave import Slave
from synthetic import LIBRARY
from wrong import table

from railgrip.base.errors import ScenarioError
from railgrip.fmus.native.package import archive_bytes, as_fmi_3
from railgrip.scenario.load import load
from railgrip.simulate.export.c_parts import part_fmu
from railgrip.simulate.export.controller_and_plant import plant_fmu
from railgrip.simulate.export.ssp import write_ssp
from railgrip.simulate.run import run_stop

braking_distance = runpy.run_path(str(Path(__file__).parents[2] / "docs/examples/loop_in_fmpy.py"))["braking_distance"]
FAST = ("limits.horizon=40 s", "estimator.kind=compiled", "start.speed=15 km/h")
PNEUMATIC = ("vehicle.plant=TwoPartTrainPneumatic", "actuation.kind=pneumatic")
PAGE = Path(__file__).parents[2] / "docs/how_to/controller_fmu.md"
SAME = 1e-6
"""m: the FMUs contain the loop's own C, which rounds equally, and are stepped in the loop's order."""


def scenario_with(*changes):
    return load(LIBRARY / "plain.toml", [*FAST, *changes])


COMPILED: dict[str, bytes] = {}
"""FMUs by the digest of their sources."""


def pack(source, path):
    """Write a valid FMU, compiled once for all stops that use it.

    It is not optimised, because FMPy takes longer than its steps.
    """
    if source.digest in COMPILED:
        path.write_bytes(COMPILED[source.digest])
    else:
        path.write_bytes(archive_bytes(source, flags=("-O0",)))
        assert validate_fmu(str(path)) == []
        COMPILED[source.digest] = path.read_bytes()
    return path


def exported(scenario, folder, version=2):
    """Write the FMUs of a scenario into a folder and return the folder."""
    sources = {"plant": plant_fmu(scenario)}
    sources |= {kind: part_fmu(scenario, kind) for kind in ("track", "sensors", "onboard")}
    for name, source in sources.items():
        pack(as_fmi_3(source) if version == 3 else source, folder / f"{name}.fmu")
    return folder


def distance(scenario):
    """Return the distance that the harness's train travels from its start."""
    return float(run_stop(scenario).trace["distance"].values[-1])


SERVICE_BRAKE = 'demand.phases=[{pressure="1.2 bar", until={time="4 s"}}, {pressure="2 bar"}]'
VALVES = ("controller.kind=slip_three_state", "estimator={kind='none'}", "actuation.kind=pneumatic")


@pytest.mark.parametrize(
    ("changes", "tables", "version"),
    [
        pytest.param(["vehicle.parameters.A_piston='0.029 m^2'"], {}, 2, id="estimator, weaker brakes"),
        pytest.param([*VALVES, *PNEUMATIC], {}, 2, id="valves"),
        pytest.param(["controller.kind=constant_slip", *PNEUMATIC, SERVICE_BRAKE], {}, 2, id="service brake"),
        # The FMU of the track has the demand for the wire of the train; the valves of the groups are open for it.
        pytest.param(
            [*VALVES, SERVICE_BRAKE.replace('"2 bar"', '"full"')],
            {"vehicle": {"train": "vt642"}},
            2,
            id="service brake by wire",
        ),
        pytest.param(["adhesion.recovery={mu0=0.3, A=0.4, B=0.6, rate='1.9e-4 m/J'}"], {}, 3, id="cleaned rail, FMI 3"),
    ],
)
def test_a_stop_in_fmpy_equals_that_of_the_harness(changes, tables, version, tmp_path):
    scenario = scenario_with(*changes).replaced(tables)
    folder = exported(scenario, tmp_path, version)
    assert read_model_description(str(folder / "onboard.fmu")).fmiVersion == f"{version}.0"
    assert braking_distance(folder) == pytest.approx(distance(scenario), abs=SAME)


def test_service_sensors_are_exported_with_their_noise(tmp_path):
    """Its draws come from another generator: stops of different seeds scatter by 0.3 %, so 1.5 % is five times that."""
    service = [
        "sensors={kind='white', noise={speed='0.1 m/s', acceleration='0.05 m/s2'}, bias={acceleration='0.01 m/s2'}}",
        "estimator.noise=service", "start.speed=30 km/h",
    ]  # fmt: skip
    scenario = scenario_with(*service)
    assert braking_distance(exported(scenario, tmp_path)) == pytest.approx(distance(scenario), rel=0.015)


def reading_of(sensors, sample):
    sensors.step(sample, 1e-3, speed=20.0, acceleration=-1.0)
    return sensors.get("reading_acceleration")[0]


def test_noise_is_white_and_of_its_deviation(tmp_path):
    """For 20 000 draws: mean within 5/√n of a deviation, the deviation within 5/√(2 n), neighbours uncorrelated.

    Another seed has other draws.
    """
    white = "sensors={kind='white', noise={acceleration='0.05 m/s2'}}"
    draws = []
    for scenario, count in ((scenario_with(white), 20_000), (scenario_with(white, "seed=8"), 2)):
        with Slave(pack(part_fmu(scenario, "sensors"), tmp_path / "sensors.fmu")) as sensors:
            readings = np.array([reading_of(sensors, k) for k in range(count)])
        draws.append((readings + 1.0) / 0.05)
    noise, other = draws
    assert not np.isin(other, noise).any()
    assert abs(noise.mean()) < 5 / 20_000**0.5
    assert abs(noise.std() - 1.0) < 5 / 40_000**0.5
    assert abs(np.mean(noise[1:] * noise[:-1])) < 5 / 20_000**0.5


ADHESION = [f"estimate_adhesion[{g}]" for g in range(1, 5)]


def test_the_state_of_the_onboard_part_can_be_restored(tmp_path):
    """Its memory contains pointers into itself; a restored state must not refer to the instance that it came from."""
    path = pack(part_fmu(scenario_with(), "onboard"), tmp_path / "onboard.fmu")
    readings = {"reading_speed": 20.0, "reading_acceleration": -0.5}
    readings |= {f"reading_wheelset_speed[{g}]": 51.0 for g in range(1, 5)}
    with Slave(path) as one, Slave(path) as other:
        for fmu in (one, other):
            fmu.set(**readings)
        one.fmu.doStep(0.0, 0.02)
        size = one.fmu.getFMUState()
        kept = one.fmu.serializeFMUState(size)
        one.fmu.doStep(0.02, 0.02)
        after = one.get(*ADHESION)
        one.fmu.freeFMUState(size)
        state = other.fmu.deserializeFMUState(kept)
        other.fmu.setFMUState(state)
        other.set(**readings)
        other.fmu.doStep(0.02, 0.02)
        assert other.get(*ADHESION) == after
        other.fmu.freeFMUState(state)


def test_the_onboard_part_waits_for_its_first_reading(tmp_path):
    """An importer may step it before any reading arrives, which must not be taken for standstill."""
    path = pack(part_fmu(scenario_with(), "onboard"), tmp_path / "onboard.fmu")
    with Slave(path) as onboard:
        onboard.fmu.doStep(0.0, 0.05)
        onboard.set(**{"reading_speed": 20.0} | {f"reading_wheelset_speed[{g}]": 20.0 / 0.38 for g in range(1, 5)})
        onboard.fmu.doStep(0.05, 0.001)
        assert onboard.get("estimate_speed") == pytest.approx([15 / 3.6])


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    """Return a scenario and its system."""
    scenario = scenario_with("start.speed=30 km/h", "limits.horizon=17 s")
    return scenario, write_ssp(scenario, tmp_path_factory.mktemp("system") / "plain.ssp")


def test_a_system_simulated_from_its_description_stops_like_the_harness(system):
    """FMPy passes values on after all parts have stepped: a command is three periods late, or 2.5 cm at 30 km/h.

    Of 49 m that is 0.05 %; the 0.1 % of the page is a margin for the reaction of the law.
    """
    scenario, path = system
    values = read_ssv(str(path), "resources/parameters.ssv")
    assert "plant.start_speed" in {parameter.name for parameter in values.parameters}
    rows = simulate_ssp(str(path), stop_time=17.0, step_size=1e-3, parameter_set=values)
    moving = rows["plant.speed"] > scenario.limits.stop_speed
    place = np.flatnonzero(moving)[-1] + 1
    (limit,) = re.findall(r"deviates by less than ([\d.]+) %", PAGE.read_text(encoding="utf-8"))
    assert float(limit) <= 0.1
    assert rows["plant.distance"][place] == pytest.approx(distance(scenario), rel=float(limit) / 100)


def test_a_system_has_a_connection_for_every_input(system):
    """Except for the track force, which a plant may lack; the reader is FMPy's, and checks the schema."""
    _, path = system
    read = read_ssd(str(path))
    ends = {(connection.endElement, connection.endConnector) for connection in read.system.connections}
    with zipfile.ZipFile(path) as archive:
        for component in read.system.elements:
            (path.parent / "one.fmu").write_bytes(archive.read(component.source))
            description = read_model_description(str(path.parent / "one.fmu"))
            inputs = {v.name for v in description.modelVariables if v.causality == "input"}
            assert {(component.name, name) for name in inputs} <= ends, component.name


@pytest.mark.parametrize(
    ("name", "changes", "kind", "sentence"), table(__file__, "tables.toml")["parts_without_export"]
)
def test_a_part_that_cannot_be_exported_is_refused(name, changes, kind, sentence):
    with pytest.raises(ScenarioError, match=sentence):
        part_fmu(load(LIBRARY / f"{name}.toml", changes), kind)
