"""A short scenario runs on defaults; one file extends another; equipment overrides both."""

import tomllib
from pathlib import Path

import pytest

import railgrip as rg
from railgrip.base.errors import ScenarioError
from railgrip.base.registry import shelf
from railgrip.estimation.spec import load_specification
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.load import load, read_toml

TEN_LINES = """\
[vehicle]
plant = "TwoPartTrain"
[start]
speed = "80 km/h"
[adhesion]
kind = "constant"
polach = "dry"
mu0 = 0.08
[controller]
kind = "slip_two_state"
"""


def written(folder: Path, **files: str) -> Path:
    """Write files, and return the path of the first."""
    for name, text in files.items():
        path = folder / f"{name.replace('__', '/')}.toml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder / f"{next(iter(files))}.toml"


def test_ten_lines_equal_a_complete_scenario(tmp_path):
    """`plain` contains all values that the ten lines leave out, apart from its horizon and estimator."""
    assert len(TEN_LINES.splitlines()) == 10
    path = written(tmp_path, ten=TEN_LINES)
    plain = load(shelf("scenarios")["plain"], ["estimator.kind=none", "controller.kind=slip_two_state"])
    short = load(path)
    assert short.name == "ten"
    assert short.resolved() | {"name": "plain", "description": plain.description} == plain.resolved()


def test_the_stop_of_ten_lines_reaches_standstill(tmp_path):
    """The distance is between that of a rail whose friction is fully used and that of a rail with half of it."""
    stop = rg.run(written(tmp_path, ten=TEN_LINES.replace("80 km/h", "20 km/h")))
    best = (20 / 3.6) ** 2 / (2 * 9.81 * 0.08)
    assert stop.outcome == "standstill"
    assert best < stop.metrics.distance < 2 * best


@pytest.mark.parametrize(("step", "trace"), [("1 ms", 0.01), ("3 ms", 0.009), ("20 ms", 0.02)])
def test_periods_follow_the_step_of_the_plant(tmp_path, step, trace):
    # Slip control takes steps of up to 10 ms.
    changes = [f"periods.communication={step}", "controller.kind=full_brake"]
    periods = load(written(tmp_path, ten=TEN_LINES), changes).periods
    assert periods.estimator == periods.controller == periods.communication
    assert periods.trace == pytest.approx(trace, rel=1e-12)


def test_a_file_extends_a_scenario_of_the_library_by_the_rules_of_overrides(tmp_path):
    mine = load(
        written(tmp_path, mine='extends = "trapezoid"\nstart.speed = "60 km/h"\ncontroller.kind = "full_brake"\n')
    )
    by_overrides = load(Path("trapezoid"), ["start.speed=60 km/h", "controller.kind=full_brake", "name=mine"])
    assert mine == by_overrides
    assert mine.digest() == by_overrides.digest()


def test_a_chain_of_files_is_read_from_the_last_base_up(tmp_path):
    top = written(
        tmp_path,
        top='extends = "sub/middle.toml"\nseed = 3\n',
        sub__middle='extends = "../base.toml"\nseed = 2\nstart.speed = "50 km/h"\n',
        base=f"seed = 1\nlimits.stop_speed = 0.2\n{TEN_LINES}",
    )
    scenario = load(top)
    assert (scenario.name, scenario.seed) == ("top", 3)
    assert scenario.start.speed == pytest.approx(50 / 3.6)
    assert scenario.limits.stop_speed == 0.2


def test_a_file_named_by_a_base_is_found_from_the_folder_of_the_base(tmp_path):
    """There are two files of that name; results name it from the folder of the scenario, where it loads again."""
    rail = TEN_LINES.replace('kind = "constant"', 'kind = "table"').replace("mu0 = 0.08", 'file = "rail.csv"')
    top = written(tmp_path, top='extends = "sub/base.toml"\n', sub__base=rail)
    (tmp_path / "rail.csv").write_text("time,mu0\n0,0.2\n9,0.2\n")
    (tmp_path / "sub" / "rail.csv").write_text("time,mu0\n0,0.1\n9,0.1\n")
    scenario = rg.Scenario.load(top)
    assert scenario.adhesion.curve.values.max() == 0.1
    assert Path(scenario.resolved()["adhesion"]["file"]) == Path("sub/rail.csv")
    assert scenario.changed({"seed": 1}).digest() == scenario.digest()
    own = written(tmp_path, own='extends = "sub/base.toml"\nadhesion.file = "rail.csv"\n')
    assert load(own).adhesion.curve.values.max() == 0.2


@pytest.mark.parametrize("vehicle", ['train = "tram"', 'plant = "Wagon"'])
def test_a_file_may_name_another_plant_than_its_base(tmp_path, vehicle):
    base = TEN_LINES.replace('plant = "TwoPartTrain"', 'train = "emu387"\nparameters = { mu_bearing = 0.002 }')
    scenario = load(
        written(tmp_path, top=f'extends = "base"\n[vehicle]\n{vehicle}\n'.replace('"base"', '"./base.toml"'), base=base)
    )
    given = {key: value for key, value in scenario.resolved()["vehicle"].items() if key in ("plant", "train")}
    key, _, value = vehicle.partition(" = ")
    assert given == {key: value.strip('"')}
    assert "mu_bearing" in scenario.vehicle.parameters


WRONG = tomllib.loads(Path(__file__).with_name("wrong_bases.toml").read_text(encoding="utf-8"))["case"]


@pytest.mark.parametrize("case", WRONG, ids=lambda case: case["sentences"][0])
def test_the_message_names_the_file_that_contains_the_key(tmp_path, case):
    with pytest.raises(ScenarioError) as refusal:
        load(written(tmp_path, **case["files"]))
    for sentence in case["sentences"]:
        assert sentence in str(refusal.value)


@pytest.mark.parametrize("equipment", shelf("equipment"))
def test_equipment_changes_a_scenario_like_a_campaign_does(equipment, tmp_path):
    campaign = f'name = "c"\nscenarios = ["trapezoid"]\n[axes.equipment]\nx = "{equipment}"\n'
    (stop,) = load_campaign(written(tmp_path, c=campaign)).stops
    assert load(Path("trapezoid"), equipment=[equipment]) == stop.scenario


def test_equipment_is_below_overrides_and_above_the_extended_file(tmp_path):
    path = written(tmp_path, mine='extends = "trapezoid"\nsensors.kind = "ideal"\n')
    assert load(path, ["sensors.speed.noise=0.3 m/s"], ["service"]).sensors.speed.noise == 0.3
    text = shelf("equipment")["service"].read_text(encoding="utf-8").replace("pulses", "plses")
    wrong = str(written(tmp_path, service=text))
    with pytest.raises(ScenarioError, match=r"service\.toml: \[sensors\.wheel\] has no key 'plses'"):
        load(path, equipment=[wrong])


@pytest.mark.parametrize("vehicle", ['train = "tram"', 'plant = "Wagon"'])
def test_equipment_does_not_change_another_train_or_add_an_estimator(tmp_path, vehicle):
    scenario = load(written(tmp_path, ten=TEN_LINES.replace('plant = "TwoPartTrain"', vehicle)), equipment=["service"])
    assert scenario.actuation.kind == "pneumatic"
    assert scenario.sensors.kind == "service"
    assert scenario.estimator.kind == "none"
    assert vehicle.split('"')[1] in scenario.resolved()["vehicle"].values()


def test_a_campaign_reads_what_its_scenarios_extend(tmp_path):
    path = written(
        tmp_path,
        c='name = "c"\nscenarios = ["mine.toml"]\n[axes.case.fast]\nstart.speed = "120 km/h"\n[axes.case.slow]\n',
        mine='extends = "plain"\nstart.speed = "50 km/h"\n',
    )
    stops = {stop.name: stop.scenario for stop in load_campaign(path).stops}
    assert {name: round(3.6 * scenario.start.speed) for name, scenario in stops.items()} == {
        "mine-fast": 120,
        "mine-slow": 50,
    }
    written(tmp_path, mine='extends = "base.toml"\n', base=TEN_LINES.replace("0.08", "8"))
    with pytest.raises(ScenarioError, match=r"^base\.toml: \[adhesion\] mu0 must be at most 1, got 8"):
        load_campaign(path)


def test_extends_works_in_python():
    tables = {"name": "mine", "extends": "trapezoid", "start": {"speed": "60 km/h"}}
    assert rg.Scenario.load(tables).start.speed == pytest.approx(60 / 3.6)
    assert read_toml(shelf("scenarios")["trapezoid"])["start"]["speed"] == "80 km/h"


def test_another_plant_replaces_a_train():
    scenario = rg.Scenario.load("plain", {"estimator.kind": "none"}).with_plant({"train": "tram"})
    assert "plant" not in scenario.resolved()["vehicle"]
    assert scenario.with_plant("Wagon").resolved()["vehicle"] == {"plant": "Wagon"} | {
        key: value for key, value in scenario.resolved()["vehicle"].items() if key != "train"
    }


@pytest.mark.parametrize(
    ("read", "table"), [(load, "[start]"), (load_specification, "[gate]")], ids=["scenario", "estimation"]
)
def test_a_chain_of_1500_files_is_refused_in_a_sentence(tmp_path, read, table):
    for number in range(1500):
        written(tmp_path, **{f"f{number}": f'extends = "f{number - 1}.toml"\n{table}\n'})
    with pytest.raises(ScenarioError, match=r"f1499\.toml: extends a chain of more than 30 files"):
        read(tmp_path / "f1499.toml")
