"""Controllers as FMUs: the output of the command, and the driver's demand that the FMU itself must respect."""

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from slave import Slave
from synthetic import LIBRARY
from wrong import table

from railgrip.base.errors import ScenarioError
from railgrip.fmi import describe
from railgrip.fmus.native.package import pack
from railgrip.scenario.load import load
from railgrip.simulate.export.controller_and_plant import controller_fmu
from railgrip.simulate.run import run_stop
from railgrip.simulate.user_parts import CustomParts
from railgrip.simulate.vehicle_data import VehicleData

PLAIN = LIBRARY / "plain.toml"


class Driven:
    """A controller in a loop without [demand]: only the exported FMU receives the driver's demand."""

    def __init__(self, fmu, period, demand):
        self.fmu, self.period, self.demand, self.calls = fmu, period, demand, 0

    def start(self, formation):
        self.groups = range(formation.groups)

    def decide(self, seen):
        of_groups = {"slip": seen.slip, "wheelset_speed": seen.wheelset_speed, "pressure": seen.pressure}
        of_groups["driver_demand"] = self.demand(seen.time)
        values = {f"{name}[{g + 1}]": own[g] for name, own in of_groups.items() for g in self.groups}
        self.fmu.step(self.calls, self.period, speed=seen.speed, acceleration=seen.acceleration, **values)
        self.calls += 1
        return self.fmu.get(*(f"demand[{g + 1}]" for g in self.groups))


@pytest.mark.parametrize("kind", ["slip_three_state", "full_brake", "constant_slip"])
def test_an_exported_law_gives_the_stop_of_the_harness_under_a_service_demand(kind, tmp_path):
    """1.2 bar, and full brake after 4 s: the loop around the FMU has no driver, so the FMU must limit the pressure."""
    changes = [f"controller.kind={kind}", "estimator={kind='none'}", "adhesion.mu0=0.12"]
    plain = load(PLAIN, changes)
    phases = 'demand.phases=[{pressure="1.2 bar", until={time="4 s"}}, {pressure="full"}]'
    service = run_stop(load(PLAIN, [*changes, phases]))
    full = VehicleData(plain).nominal.formation.pressure_max
    path = pack(controller_fmu(plain), tmp_path / "controller.fmu")
    assert validate_fmu(str(path)) == []
    with Slave(path) as fmu:
        law = Driven(fmu, plain.periods.controller, lambda time: np.full(4, 1.2e5) if time < 4.0 else full)
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
