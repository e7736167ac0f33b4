"""The default horizon of a stop."""

import numpy as np
import pytest
from synthetic import LIBRARY

from railgrip.scenario.adhesion import profile_of
from railgrip.scenario.load import load
from railgrip.simulate.run import run_stop
from railgrip.simulate.vehicle_data import VehicleData

PLAIN = LIBRARY / "plain.toml"


@pytest.mark.parametrize("speed", ["40 km/h", "160 km/h"])
@pytest.mark.parametrize("curve", ["dry", "soap", "poor_wheelset_study"])
@pytest.mark.parametrize("mu0", [0.03, 0.08])
def test_locked_wheels_come_to_standstill_within_it(speed, curve, mu0):
    changes = [f"start.speed={speed}", f"adhesion.polach={curve}", f"adhesion.mu0={mu0}", "controller.kind=full_brake"]
    step = ["periods.communication=10 ms", "estimator.kind=none"]
    stop = run_stop(load(PLAIN, [*changes, *step]))
    assert stop.outcome.value == "standstill"
    assert stop.metrics.duration < stop.scenario.horizon <= 600.0


@pytest.mark.parametrize(
    ("changes", "horizon"),
    [
        (["limits.horizon=60 s"], 60.0),
        # v / (g A mu0 / 2), with A = 0.4 of the dry curve
        ([], np.ceil(22.2222 / (9.81 * 0.4 * 0.08 / 2))),
        (["adhesion.mu0=0.3"], 120.0),
        (["truth.gradient=-0.005"], np.ceil(22.2222 / (9.81 * (0.4 * 0.08 / 2 - 0.005)))),
        (["track.gradient=[{begin=0, slope=-0.005}]", "track.train_mass=84 t"], np.ceil(22.2222 / (9.81 * 0.011))),
        (["truth.gradient=-0.02"], 600.0),
        (["adhesion.patch=[{begin=50, length=10, mu0=0.06}]"], np.ceil(22.2222 / (9.81 * 0.4 * 0.06 / 2))),
        (["periods.communication=0.1 ms"], 100.0),
        # Friction over distance is tabulated for 20 km.
        (["start.speed=40 m/s", "adhesion.patch=[{begin=50, length=10, mu0=0.02}]"], 500.0),
        (["start.speed=40 m/s", "adhesion.mu0=0.02"], 600.0),
    ],
)
def test_it_follows_from_speed_friction_and_gradient_unless_it_is_given(changes, horizon):
    assert load(PLAIN, changes).horizon == horizon


@pytest.mark.parametrize(
    "path",
    sorted(path for path in LIBRARY.glob("*.toml") if path.stem != "foreign_train"),  # its FMU is not built
    ids=lambda path: path.stem,
)
def test_no_friction_of_a_scenario_is_below_its_minimum(path):
    scenario = load(path)
    formation = VehicleData(scenario).formation
    times = np.arange(0.0, 100.0, 0.01)
    found = profile_of(scenario, formation).table(times, scenario.start.speed * times).min()
    assert 0.0 < scenario.adhesion.lowest <= found + 1e-12
