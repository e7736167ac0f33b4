"""The study of trains: one distance of the trial of sanders is fitted, and dry stops are those by hand."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
import train_stops
from small_train import one_bogie

from railgrip.base.registry import shelf
from railgrip.rolling_stock.schema import load_train, train_of
from railgrip.rolling_stock.stopping import by_hand


def laid(scenario):
    """A rail on which each sander shortens the distance by a fifth, depending on the density of its sand."""
    density = scenario.adhesion.sand.density if scenario.sanders else 1.0
    variable = sum(2 if sander.density else 1 for sander in scenario.sanders)
    return 1300.0 * np.exp(-variable * 0.01 / density) if variable else None


def test_one_distance_is_fitted_and_the_others_follow(monkeypatch):
    monkeypatch.setattr(train_stops, "braking_distance", laid)
    rows = {row["sanders"]: row for row in train_stops.sander_rows("one fixed")}
    assert [row["measured"] for row in rows.values()] == [1200, 800, 650, 600, 400]
    assert rows["none"]["density"] == pytest.approx(0.01 / np.log(1300 / 800), rel=0.01)
    assert rows["one fixed"]["simulated"] == pytest.approx(800, rel=0.01)
    assert rows["two fixed"]["simulated"] == pytest.approx(1300 * (800 / 1300) ** 2, rel=0.02)
    assert rows["none"]["simulated"] is None


def test_the_demand_gives_the_deceleration_of_the_trial():
    """By hand, with the pressures of the scenario instead of the maximum ones."""
    tables = tomllib.loads(shelf("trains")[train_stops.TRIAL_TRAIN].read_text(encoding="utf-8"))
    train = load_train(Path(train_stops.TRIAL_TRAIN))
    for group, pressure in enumerate(train_stops.demand()):
        tables["brakes"][train.bogie_of(group).data.brake]["pressure_max"] = pressure
    found = by_hand(train_of(tables, "demanded"), train_stops.TRIAL_SPEED).deceleration
    assert found == pytest.approx(0.9, rel=0.03)


def test_a_train_stops_dry_as_by_hand(tmp_path):
    """One car without couplers and brake pipe, which other tests have."""
    (tmp_path / "small.toml").write_text(one_bogie(), encoding="utf-8")
    row = train_stops.dry_row(str(tmp_path / "small.toml"))
    assert row["speed"] == pytest.approx(120 / 3.6)
    assert row["simulated"] == pytest.approx(row["by hand"], rel=0.01)
    assert row.keys() == {"speed", "simulated", "by hand"}
