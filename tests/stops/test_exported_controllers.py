"""Controllers as FMUs: the output of the command, and the driver's demand that the FMU itself must respect."""

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from synthetic import LIBRARY
from wrong import table

from railgrip.base.errors import ScenarioError
from railgrip.fmi import CoSimulation, Port, bind, describe
from railgrip.fmus.native.package import pack
from railgrip.scenario.load import load
from railgrip.simulate.export.controller_and_plant import controller_fmu
from railgrip.simulate.run import run_stop
from railgrip.simulate.user_parts import CustomParts
from railgrip.simulate.vehicle_data import VehicleData

PLAIN = LIBRARY / "plain.toml"


def exported(scenario, folder):
    """Return the FMU of a scenario's controller, ready to start; its inputs are those of a law, in that order."""
    path = pack(controller_fmu(scenario), folder / "controller.fmu")
    assert validate_fmu(str(path)) == []
    described = describe(path)
    inputs = tuple(
        Port(name=name, unit=unit, size=size, needed=True)
        for name, unit, size in (
            ("speed", "m/s", 0),
            ("acceleration", "m/s2", 0),
            ("slip", "1", 4),
            ("adhesion", "1", 4),
            ("pad_friction", "1", 4),
            ("wheelset_speed", "rad/s", 4),
            ("driver_demand", "Pa", 4),
            ("pressure", "Pa", 4),
        )
    )
    output = Port(name="demand", unit="Pa", size=4, needed=True)
    if scenario.actuation.kind == "pneumatic":
        output = Port(name="command", unit="1", size=4, needed=True)
    binding = bind(described, inputs=inputs, outputs=(output,), parameters=(), table={}, where="test")
    return CoSimulation(described, binding, period=scenario.periods.controller, parameters={})


class Driven:
    """A controller in a loop without [demand]: only the exported FMU receives the driver's demand."""

    def __init__(self, fmu, demand):
        self.fmu, self.demand = fmu, demand

    def start(self, formation):
        self.unknown, self.begun = np.zeros(formation.groups), False

    def decide(self, seen):
        inputs = np.concatenate(
            [
                *([seen.speed], [seen.acceleration], seen.slip, self.unknown, self.unknown, seen.wheelset_speed),
                *(self.demand(seen.time), seen.pressure),
            ]
        )
        if not self.begun:
            self.begun = True
            self.fmu.start(inputs)
        return self.fmu.step(inputs)


@pytest.mark.parametrize("kind", ["slip_three_state", "full_brake", "constant_slip"])
def test_an_exported_law_gives_the_stop_of_the_harness_under_a_service_demand(kind, tmp_path):
    """1.2 bar, and full brake after 4 s: the loop around the FMU has no driver, so the FMU must limit the pressure."""
    changes = [f"controller.kind={kind}", "estimator={kind='none'}", "adhesion.mu0=0.12"]
    plain = load(PLAIN, changes)
    phases = 'demand.phases=[{pressure="1.2 bar", until={time="4 s"}}, {pressure="full"}]'
    service = run_stop(load(PLAIN, [*changes, phases]))
    full = VehicleData(plain).nominal.formation.pressure_max
    with exported(plain, tmp_path) as fmu:
        law = Driven(fmu, lambda time: np.full(4, 1.2e5) if time < 4.0 else full)
        stop = run_stop(plain, objects=CustomParts(controller=law))
    undriven = run_stop(plain)
    # Another order of the same sums changes slip in its last digit; a phase begins a sample early or late.
    assert stop.metrics.distance == pytest.approx(service.metrics.distance, abs=0.03)
    assert undriven.metrics.distance < service.metrics.distance - 5.0


def test_a_parameter_named_like_an_input_gets_a_prefix():
    """The law's target `slip` is not an element of the input `slip[1]`, `slip[2]` …."""
    xml = controller_fmu(load(PLAIN, ["controller.kind=constant_slip"])).xml
    assert 'name="parameters.slip"' in xml
    assert 'name="slip"' not in xml


def test_an_exported_law_brakes_fully_until_a_driver_demands_less(tmp_path):
    """A tool that does not set `driver_demand` gets the emergency brake, like a stop without [demand]."""
    described = describe(pack(controller_fmu(load(PLAIN)), tmp_path / "law.fmu"))
    starts = [float(described.variables[f"driver_demand[{g}]"].start) for g in range(1, 5)]
    assert starts == VehicleData(load(PLAIN)).nominal.formation.pressure_max.tolist()


@pytest.mark.parametrize(("changes", "sentence"), table(__file__, "tables.toml")["controllers_without_export"])
def test_a_controller_that_cannot_be_exported_is_refused(changes, sentence):
    with pytest.raises(ScenarioError, match=sentence):
        controller_fmu(load(PLAIN, changes))


def test_the_command_prints_the_path_of_the_fmu(tmp_path, command):
    """The valves' parameters and those of the law have units; the parameter that is the FMU's own step is omitted."""
    made = tmp_path / "new" / "law.fmu"
    pneumatic = ("--set", "actuation.kind=pneumatic", "--set", "vehicle.plant=TwoPartTrainPneumatic")
    output = command("export", PLAIN, *pneumatic, "--out", made)
    assert (output.code, output.out.strip()) == (0, str(made))
    described = {v.name: v for v in describe(made).variables.values() if v.causality == "parameter"}
    assert described["filter_time"].unit == described["valves.fill_time"].unit == "s"
    assert {v.minimum for v in described.values()} == {0.0}
    assert all(v.unit for v in described.values())
    assert not {"period", "valves.period"} & set(described)


@pytest.mark.parametrize(("arguments", "sentence"), table(__file__, "tables.toml")["meaningless_exports"])
def test_a_meaningless_export_is_refused(arguments, sentence, command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused = command("export", PLAIN, *arguments)
    assert refused.code == 2
    assert sentence in " ".join(refused.err.split())
    assert not [*tmp_path.iterdir()]
