"""Scenarios that are derived from others keep the files that these name, whatever the current folder is."""

import os
import re
import shutil
from pathlib import Path

import pytest
from test_extends import TEN_LINES

import railgrip
from railgrip.base.registry import shelf
from railgrip.scenario.load import load, scenario_of
from railgrip.scenario.schema import Scenario
from railgrip.simulate.ideal import _full_brake

SCENARIO = TEN_LINES.replace('plant = "TwoPartTrain"', 'train = "mine.toml"').replace("slip_two_state", "full_brake")


@pytest.fixture
def scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Scenario:
    """Return a scenario with a train file next to it, read from a relative path; the current folder is another one."""
    monkeypatch.chdir(tmp_path)
    Path("project").mkdir()
    shutil.copy(shelf("trains")["vt642"], "project/mine.toml")
    Path("project/stop.toml").write_text(SCENARIO)
    Path("elsewhere").mkdir()
    os.chdir("elsewhere")
    return load(Path("../project/stop.toml"))


def test_a_revised_scenario_keeps_its_train_file(scenario: Scenario) -> None:
    revised = scenario.revised({"start": {"speed": "100 km/h"}})
    assert revised.vehicle == scenario.vehicle
    assert revised.start.speed == pytest.approx(100 / 3.6)
    assert revised.resolved()["vehicle"]["train"] == "mine.toml"


def test_a_replaced_table_keeps_no_key_and_the_others_keep_their_files(scenario: Scenario) -> None:
    patched = scenario.revised({"adhesion": {"patch": [{"begin": "10 m", "length": "5 m", "mu0": 0.05}]}})
    replaced = patched.replaced({"adhesion": {"kind": "constant", "mu0": 0.6, "polach": "dry"}})
    assert patched.adhesion.patch
    assert not replaced.adhesion.patch
    assert replaced.vehicle == scenario.vehicle


def test_the_ideal_bound_finds_the_train_file(scenario: Scenario) -> None:
    assert _full_brake(scenario).vehicle == scenario.vehicle


def test_python_scenarios_keep_their_files(scenario: Scenario) -> None:
    of_interface = railgrip.Scenario.load("../project/stop.toml")
    assert of_interface.changed({"start.speed": "100 km/h"}).vehicle == scenario.vehicle
    assert of_interface.with_plant({"train": "vt642"}).vehicle.train is not None


@pytest.mark.parametrize("name", sorted(shelf("scenarios")))
def test_tables_and_recorded_values_of_a_scenario_give_an_equal_one(name: str) -> None:
    path = shelf("scenarios")[name]
    if "build/fmus" in path.read_text():
        pytest.skip("names an FMU that is built on request")
    scenario = load(path)
    of_tables = Scenario.model_validate(scenario.tables())
    of_record = scenario_of(scenario.resolved(), directory=path.parent, origin=name)
    assert of_tables == of_record == scenario
    assert of_tables.resolved() == scenario.resolved()
    assert of_record.digest() == scenario.digest()


def test_no_module_validates_what_results_record() -> None:
    """`resolved` has paths relative to the scenario's folder; validated again they would start at the current one."""
    folder = Path(railgrip.__file__).parent
    texts = {file: file.read_text(encoding="utf-8") for file in folder.rglob("*.py")}
    offences = [file.name for file, text in texts.items() if re.search(r"model_validate\([^()]*\.resolved\(", text)]
    assert not offences
    others = [file.name for file, text in texts.items() if "Scenario.model_validate(" in text]
    assert not others, (
        f"{', '.join(others)} validates the tables of a scenario itself: use Scenario.revised, which overlays keys, or "
        "Scenario.replaced, which replaces tables; both keep the files that the scenario names"
    )
