"""Stops of vehicles that are no two-part train: both engines, to the same bytes."""

import pytest
from synthetic import LIBRARY

from railgrip.assemble import run_stop
from railgrip.engine import Engine
from railgrip.record.stop import write_stop
from railgrip.scenario.error import ScenarioError
from railgrip.scenario.load import load

WAGON = [
    "name=wagon", "vehicle.plant=Wagon", "vehicle.wheelset_offsets=[]", "estimator.kind=none",
    "controller.kind=slip_three_state",
]  # fmt: skip


@pytest.mark.parametrize("further", [[], ["adhesion.mu0=[0.05, 0.08]", "adhesion.kind=constant"]], ids=["rail", "each"])
def test_a_wagon_of_two_wheelsets_stops_alike_in_both_engines(tmp_path, further):
    base = "plain" if further else "trapezoid"
    scenario = load(LIBRARY / f"{base}.toml", [*WAGON, *further])
    stops = {engine: run_stop(scenario, engine=engine) for engine in (Engine.PYTHON, Engine.COMPILED)}
    for engine, stop in stops.items():
        assert stop.outcome.value == "standstill"
        assert len(stop.metrics.longest_lock) == len(stop.metrics.utilisation_wheelset) == 2
        assert 0.5 < stop.metrics.utilisation < 1.0
        write_stop(stop, tmp_path / engine.value)
    python, compiled = ((tmp_path / engine.value / "trace.nc").read_bytes() for engine in stops)
    assert python == compiled


def test_an_estimator_for_another_vehicle_is_refused():
    scenario = load(LIBRARY / "trapezoid.toml", [*WAGON[:3], "controller.kind=full_brake"])
    with pytest.raises(ScenarioError, match="model 'TrainPrediction' is for 4 groups, the vehicle has 2"):
        run_stop(scenario)


def test_how_a_plant_is_made_cannot_be_set():
    scenario = load(LIBRARY / "trapezoid.toml", ["vehicle.parameters.wheelsets_per_group=[3, 1, 1, 1]"])
    with pytest.raises(ScenarioError, match=r"wheelsets_per_group\[1\] says how TwoPartTrain.fmu is made"):
        run_stop(scenario)


def test_a_table_that_contradicts_the_plant_is_refused():
    scenario = load(LIBRARY / "trapezoid.toml", ["vehicle.formation.wheelsets_per_group=[3, 3]"])
    with pytest.raises(ScenarioError, match=r"wheelsets_per_group is \[3, 3\], TwoPartTrain.fmu has \[2, 1, 1, 2\]"):
        run_stop(scenario)
