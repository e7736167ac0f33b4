"""The study of trains: one distance of the trial of sanders is fitted, and the results state which."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from railgrip.base.registry import shelf
from railgrip.rolling_stock.schema import load_train, train_of
from railgrip.rolling_stock.stopping import by_hand
from railgrip.studies.trains import stops as of_trains
from railgrip.studies.trains.stops import DryStop, Filling, protected_stop, repeat_cars
from railgrip.studies.trains.study import page_of, table_of_sanders


def laid(scenario):
    """A rail on which each sander shortens the distance by a fifth, depending on the density of its sand."""
    density = scenario.adhesion.sand.density if scenario.sanders else 1.0
    variable = sum(2 if sander.density else 1 for sander in scenario.sanders)
    return 1300.0 * np.exp(-variable * 0.01 / density) if variable else None


def test_the_trial_is_the_published_one():
    trial = of_trains.trial_of()
    assert [row.measured for row in trial.rows] == [1200, 800, 650, 600, 400]
    assert trial.speed == pytest.approx(24.587, abs=1e-3)
    assert [row.sanders for row in trial.rows if row.at_least] == ["none"]


def test_one_distance_is_fitted_and_the_others_follow(monkeypatch):
    monkeypatch.setattr(of_trains, "braking_distance", laid)
    trial = of_trains.trial_of()
    density, rows = of_trains.compare(trial)
    assert density == pytest.approx(0.01 / np.log(1300 / 800), rel=0.01)
    assert [row["sanders"] for row in rows if row["fitted"]] == ["one fixed"]
    one, two = rows[1], rows[2]
    assert one["distance_m"] == pytest.approx(800, rel=0.01)
    assert two["distance_m"] == pytest.approx(1300 * (800 / 1300) ** 2, rel=0.02)
    assert rows[0]["distance_m"] is None
    assert table_of_sanders(rows).texts[0]["difference"] == ""


def test_the_demand_gives_the_deceleration_of_the_trial():
    """By hand, with the pressures of the scenario instead of the maximum ones."""
    trial = of_trains.trial_of()
    pressures = of_trains.scenario_tables(trial)["demand"]["phases"][0]["pressure"]
    tables = tomllib.loads(shelf("trains")[str(trial.train)].read_text(encoding="utf-8"))
    train = load_train(Path(trial.train))
    for group, pressure in enumerate(pressures):
        tables["brakes"][train.bogie_of(group).data.brake]["pressure_max"] = pressure
    assert by_hand(train_of(tables, "demanded"), trial.speed).deceleration == pytest.approx(0.9, rel=0.03)


def stop_of(train, **changes):
    """A stop that was not run."""
    values = {
        "train": train, "speed": 30.0, "distance": 400.0, "hand": by_hand(train, 30.0), "states": 9, "build_s": 2.5,
        "plant_step_us": 3.0, "cycle_us": 5.0, "coupler_force": np.zeros(len(train.couplers)),
        "chain": np.zeros(len(train.couplers)), "filling": None,
    }  # fmt: skip
    return DryStop(**values | changes)


def test_the_files_state_the_fit_and_the_source_of_the_reference(tmp_path):
    train = load_train(Path("emu387"))
    filling = Filling(begin=np.array([0.1, 0.4]), filling=np.array([4.0, 4.1]), propagation=280.0)
    text = shelf("trains")["emu387"].read_text(encoding="utf-8")
    series = [stop_of(train_of(tomllib.loads(repeat_cars(text, cars)), "cars")) for cars in (1, 2)]
    rows = [
        {"sanders": "one fixed", "distance_m": 801.0, "measured_m": 800.0, "fitted": True},
        {"sanders": "none", "distance_m": None, "measured_m": 1200.0, "at_least": True, "fitted": False},
    ]
    protected = {"estimator_period_s": 0.01, "simulated_s": 30.0, "processor_s": 1.2, "times_real_time": 25.0}
    stops = [stop_of(train, filling=filling)]
    page = page_of(stops, series, [protected], of_trains.trial_of(), 0.011, rows).write(tmp_path)
    written = json.loads((tmp_path / "trains.json").read_text(encoding="utf-8"))
    trains = written["trains"]
    assert [one["times_real_time"] for one in written["protected_stop"]] == [pytest.approx(25.0)]
    assert all(one["build_s"] > 0 for one in trains)
    assert [one["train"] for one in trains] == ["emu387", "emu387_1", "emu387_2"]
    assert [one["axles"] for one in trains] == [16, 4, 8]
    assert trains[0]["reference_m"] == pytest.approx(by_hand(train, 30.0).distance)
    assert trains[0]["source"] == "EN 14531-1 by hand"
    found = json.loads((tmp_path / "sanders.json").read_text(encoding="utf-8"))["rows"]
    assert [(one["sanders"], one["fitted"]) for one in found] == [("one fixed", True), ("none", False)]
    html = page.read_text(encoding="utf-8")
    assert "11.0 g/m" in html
    assert "&gt; 1200\u00a0m" in html
    assert "280\u00a0m/s" in html


def test_the_stop_with_estimator_and_valves_ends(monkeypatch, tmp_path):
    """With one of its four cars, which takes a tenth of the build time; other tests have cars with couplers."""
    for name in ("dry.toml", "protected.toml"):
        text = (of_trains.LIBRARY / name).read_text(encoding="utf-8")
        (tmp_path / name).write_text(text.replace('"emu387"', f'"{tmp_path}/car.toml"'), encoding="utf-8")
    whole = shelf("trains")["emu387"].read_text(encoding="utf-8")
    (tmp_path / "car.toml").write_text(repeat_cars(whole, 1), encoding="utf-8")
    monkeypatch.setattr(of_trains, "LIBRARY", tmp_path)
    monkeypatch.setattr(of_trains, "_ROUNDS", 1)  # more would only cost time
    stop = protected_stop(0.01)
    assert 20.0 < stop["simulated_s"] < 60.0  # the rail supports 0.08 g from 80 km/h: 28 s or longer
    assert stop["processor_s"] > 0
    assert stop["times_real_time"] == stop["simulated_s"] / stop["processor_s"]
