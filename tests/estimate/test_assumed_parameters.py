"""A result states every parameter that it depends on, and which of them are defaults."""

import json
import tomllib
from pathlib import Path

import pytest
import xarray
from test_recording_agreement import wagon, written
from typer.testing import CliRunner

from railgrip.base.errors import ScenarioError
from railgrip.cli.app import app
from railgrip.estimation.inspection import inspect_recording
from railgrip.estimation.models import model_of
from railgrip.estimation.spec import load_specification, parameters_for


@pytest.fixture
def command(tmp_path: Path) -> list[str]:
    """Arguments of `railgrip estimate` for a recording of a wagon with a given mass."""
    arguments = written(tmp_path, wagon(start=15.0, coasting=3.0))
    toml = tmp_path / "run.toml"
    text = toml.read_text(encoding="utf-8").replace("[data]", '[model.parameters]\nm = "41 t"\n[data]')
    toml.write_text(text, encoding="utf-8")
    return [*arguments, "--set", "model.parameters.c_drag=0.8"]


ORIGINS = {
    "m": (41e3, "kg", "given in run.toml"),
    "c_drag": (0.8, "1", "--set"),
    "J[2]": (130.0, "kg.m2", "library default"),
}


def test_the_result_has_value_unit_and_origin_of_all_parameters(command, tmp_path):
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.output
    text = xarray.load_dataset(tmp_path / "out" / "estimates.nc", engine="h5netcdf").attrs["parameters"]
    found = {each["name"]: (each["value"], each["unit"], each["origin"]) for each in json.loads(text)}
    assert {name: found[name] for name in ORIGINS} == ORIGINS
    every = {v.name for v in model_of("WagonPrediction").parameters} - {"start_speed", "mu_b_start[1]", "mu_b_start[2]"}
    assert set(found) == every - {"alpha_start"}
    lines = [" ".join(line.split()) for line in result.output.splitlines()]
    assert any(line.startswith("m 41000 kg given in run.toml Mass of the wagon") for line in lines)
    assert any(line.startswith("A_drag 10 m2 library default") for line in lines)
    assert "15 of 17 parameters are library defaults" in result.output


def test_inspect_prints_only_json_on_standard_output(command, tmp_path):
    result = CliRunner().invoke(app, ["inspect", str(tmp_path / "run.csv"), "--for", "wagon", "--json"])
    assert result.exit_code == 0, result.output
    value = json.loads(result.stdout)
    assert value["signals"]["wheelset_speed[1]"] == "n1"
    assert {column["name"] for column in value["columns"]} == {"v", "n1", "n2", "F1", "F2"}
    assert tomllib.loads(value["proposal"])["extends"] == "wagon"
    assert all(each["is_default"] for each in value["parameters"])


def test_a_proposal_lists_the_data_of_the_vehicle_with_defaults_as_comments(command, tmp_path):
    """Uncommented, these lines give the same values."""
    inspection = inspect_recording(tmp_path / "run.csv", Path("wagon"))
    assert '# m = "40000 kg"  # Mass of the wagon' in inspection.proposal
    assert "model" in tomllib.loads(inspection.proposal)
    file = tmp_path / "mine.toml"
    file.write_text(inspection.proposal.replace("\n# ", "\n").replace("The filter uses", "#"), encoding="utf-8")
    values = parameters_for(load_specification(file))
    assert values == {each.name: pytest.approx(each.value) for each in inspection.parameters}


def test_a_description_instead_of_a_parameter_is_answered_with_the_name():
    with pytest.raises(ScenarioError, match=r"has no parameter 'mass'; did you mean 'm'\?"):
        parameters_for(load_specification(Path("wagon"), ["model.parameters.mass='30 t'"]))
    with pytest.raises(ScenarioError, match=r"has no parameter 'rolling_radius'; did you mean 'r_wheel'\?"):
        parameters_for(load_specification(Path("wagon"), ["model.parameters.rolling_radius='0.4 m'"]))
