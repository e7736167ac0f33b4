"""A train file runs: compiled from parts of RailBraking, to the distance of the same train written by hand."""

import shutil
from pathlib import Path

import pytest

import railgrip.scenario
from railgrip.assemble import braking_distance, run_stop
from railgrip.assemble.files import plant_description
from railgrip.assemble.vehicle import VehicleData
from railgrip.errors import ScenarioError
from railgrip.rolling_stock.files import load_train
from railgrip.rolling_stock.stopping import by_hand
from railgrip.scenario.load import load, scenario_of
from railgrip.trace.outcome import Outcome

TRAINS = Path(railgrip.scenario.__file__).parent / "trains"


def dry(vehicle, speed, directory=Path(), **changes):
    """A full brake on a dry rail."""
    table = load(Path("plain")).resolved() | {
        "vehicle": vehicle,
        "start": {"speed": speed},
        "estimator": {"kind": "none"},
        "controller": {"kind": "full_brake"},
    }
    table["adhesion"]["mu0"] = 0.5
    return scenario_of(table | changes, directory=directory, origin="dry")


def test_the_two_part_train_from_parts_stops_as_the_one_written_by_hand(tmp_path):
    """Without its electropneumatic command, which the plant written by hand has not."""
    text = (TRAINS / "vt642.toml").read_text(encoding="utf-8")
    begin = text.index("[command]")
    (tmp_path / "direct.toml").write_text(text[:begin] + text[text.index("[resistance]") :], encoding="utf-8")
    direct = braking_distance(dry({"train": "direct.toml"}, "85 km/h", tmp_path))
    assert direct == pytest.approx(braking_distance(dry({"plant": "TwoPartTrain"}, "85 km/h")), rel=5e-4)


@pytest.mark.parametrize("actuation", ["ideal", "pneumatic"])
def test_a_named_train_stops_as_calculated_by_hand(actuation):
    """Within 3 %; valves take their dead time and time constant of filling, 0.45 s, more at most."""
    scenario = dry({"train": "tram"}, "50 km/h", actuation={"kind": actuation})
    stop = run_stop(scenario)
    assert stop.outcome is Outcome.STANDSTILL, stop.reason
    expected = by_hand(load_train(Path("tram")), 50 / 3.6).distance
    late = stop.metrics.distance - expected
    assert -0.03 * expected < late < 0.03 * expected + (0.45 * 50 / 3.6 if actuation == "pneumatic" else 0.0)


def test_its_formation_is_that_of_the_file():
    scenario = dry({"train": "tram"}, "50 km/h")
    formation = VehicleData(scenario).formation
    assert formation.wheelsets_per_group == (1, 1, 1, 1)
    assert formation.wheelset_position == pytest.approx((0, 1.9, 6.4, 8.3))


def test_a_changed_file_is_another_train_and_a_moved_one_the_same(tmp_path):
    shutil.copy(TRAINS / "tram.toml", tmp_path / "mine.toml")
    named, copied = dry({"train": "tram"}, "50 km/h"), dry({"train": "mine.toml"}, "50 km/h", tmp_path)
    assert plant_description(named).digest == plant_description(copied).digest
    assert named.resolved()["vehicle"]["train"] == "tram"
    before = copied.digest()
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(text.replace('mass = "16 t"', 'mass = "17 t"'), encoding="utf-8")
    changed = dry({"train": "mine.toml"}, "50 km/h", tmp_path)
    assert changed.digest() != before


def test_a_train_that_is_none_ends_in_a_sentence(tmp_path):
    with pytest.raises(ScenarioError, match=r"\[vehicle\] train names 'nothing', but there is no file"):
        dry({"train": "nothing"}, "50 km/h")
    (tmp_path / "bad.toml").write_text('name = "bad"\n', encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"bad.toml: \[resistance\] is missing"):
        plant_description(dry({"train": "bad.toml"}, "50 km/h", tmp_path))
    with pytest.raises(ScenarioError, match="has two plants"):
        dry({"train": "tram", "plant": "TwoPartTrain"}, "50 km/h")


def test_a_load_that_nobody_was_told_changes_the_mass_and_not_the_speed():
    """A fifth more mass takes about a fifth further: brakes do not know of it, and what turns stays the same."""
    stop, heavy = (run_stop(dry({"train": "tram"}, "50 km/h", truth={"load": load})) for load in ([1.0], [1.2]))
    assert float(heavy.trace["speed"].values[0]) == pytest.approx(50 / 3.6, rel=1e-9)
    assert 1.1 < heavy.metrics.distance / stop.metrics.distance < 1.25
