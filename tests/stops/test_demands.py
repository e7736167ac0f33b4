"""Stops under the demands of a driver."""

import numpy as np
import pytest
from synthetic import LIBRARY

import railgrip as rg
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.run import run_stop

GRIPPY = {
    "adhesion": {"kind": "constant", "polach": "dry", "mu0": 0.3},
    "estimator": {"kind": "none"},
    "controller": {"kind": "slip_three_state"},
}


@pytest.fixture(scope="module")
def steps():
    return run_stop(load(LIBRARY / "service_steps.toml"))


def at(stop, time):
    return stop.trace.sel(time=time, method="nearest")


def phase_begins(stop):
    """Times at which the driver's demand changes [s]."""
    demand = stop.trace["driver_demand"].values[:, 0]
    return stop.trace["time"].values[1:][np.diff(demand) != 0] - 1e-3


def test_steps_brake_according_to_their_pressures(steps):
    """With rolling wheels a = n μ η i (p A − F) r/(R M), plus drag and rotating masses.

    The step from 1 to 2 bar, some seconds each, adds deceleration in proportion to the pad force, within the drift of
    pad friction and drag.
    """
    first, second, _, _ = phase_begins(steps)
    coasting, one, two = (-float(at(steps, t)["acceleration"]) for t in (first, second, second + 5.0))
    pressing = 1e5 * 0.0324 - 1200.0, 2e5 * 0.0324 - 1200.0
    data = steps.trace["pad_friction"].values
    index = [int(np.searchsorted(steps.trace["time"].values, t)) for t in (second, second + 5.0)]
    expected = pressing[1] * data[index[1]].mean() / (pressing[0] * data[index[0]].mean())
    assert (two - coasting) / (one - coasting) == pytest.approx(expected, rel=0.03)


def test_a_release_empties_the_cylinders(steps):
    """Within half a second cylinders are empty, and the train coasts with less drag than at the earlier speed."""
    first, _, release, again = phase_begins(steps)
    rolling = steps.trace.sel(time=slice(release + 0.5, again))
    assert float(rolling["cylinder_pressure"].max()) < 100.0
    assert float(rolling["acceleration"].min()) > float(at(steps, first)["acceleration"])
    assert float(rolling["brake_torque"].max()) < 1e-3 * float(steps.trace["brake_torque"].max())


def test_distance_and_duration_count_from_the_first_brake_demand(steps):
    first = phase_begins(steps)[0]
    whole = steps.trace["distance"].values[-1]
    assert steps.outcome is Outcome.STANDSTILL
    assert steps.metrics.distance == pytest.approx(float(whole - at(steps, first)["distance"]), abs=1e-9)
    assert steps.metrics.duration == pytest.approx(float(steps.trace["time"].values[-1] - first))
    assert f"{steps.metrics.distance:.2f} m of that since the first brake demand" in steps.reason


def test_energy_balances_under_traction(steps):
    assert abs(steps.metrics.energy_residual) < 1e-4


def test_traction_accelerates_by_its_force(steps):
    """Above 48 km/h the power limits it, 800 kW."""
    trace = steps.trace.sel(time=slice(5.0, 15.0))
    pushed = trace["track_force"].values * trace["speed"].values
    assert pushed == pytest.approx(8e5, rel=1e-3)


def from_rest(force):
    """Return a stop of a train that accelerates from rest to 30 km/h, or for 4 s, and then brakes."""
    driven = {"pressure": 0, "traction": {"force": force}}
    phases = [driven | {"until": {"time": "4 s"}}, driven | {"until": {"speed_above": "30 km/h"}}, {"pressure": "full"}]
    phases = phases if force != "1 N" else [phases[0], phases[-1]]
    return run_stop(rg.Scenario.load("service_steps", {"start.speed": 0, "demand": {"phases": phases}} | GRIPPY))


def test_a_train_starting_from_rest_ends_at_its_second_standstill():
    """Standstill at the start does not end the stop; the distance counts from the brake demand."""
    stop = from_rest("80 kN")
    assert stop.outcome is Outcome.STANDSTILL
    assert float(stop.trace["speed"].max()) == pytest.approx(30.0 / 3.6, abs=0.01)
    assert 0.0 < stop.metrics.distance < float(stop.trace["distance"][-1])
    # Level track: only traction accelerates the train, recorded next to the force sent to the plant.
    np.testing.assert_array_equal(stop.trace["traction"], stop.trace["track_force"])
    assert float(stop.trace["traction"].max()) == 80e3


def test_a_train_that_never_moves_ends_once_the_driver_brakes():
    stop = from_rest("1 N")
    assert stop.outcome is Outcome.STANDSTILL
    assert float(stop.trace["time"][-1]) == pytest.approx(4.0, abs=2e-3)


def test_full_brake_from_the_start_is_a_stop_without_a_demand():
    """Bit-identical, except for the variable of the driver's demand."""
    plain = {"start.speed": "20 km/h", **GRIPPY}
    without = rg.run(rg.Scenario.load("plain", plain))
    full = rg.run(rg.Scenario.load("plain", plain | {"demand": {"phases": [{"pressure": "full"}]}}))
    assert repr(full.metrics) == repr(without.metrics)  # NaN is not equal to NaN
    assert set(full.trace.data_vars) == {*without.trace.data_vars, "driver_demand"}
    for name, values in without.trace.data_vars.items():
        assert values.values.tobytes() == full.trace[name].values.tobytes(), name


def test_a_driver_stops_at_the_target_if_the_rail_allows_it():
    """Within half a metre: the cylinders lag, and the last metres are slow."""
    stop = run_stop(
        rg.Scenario.load("stop_at_target", {"adhesion": GRIPPY["adhesion"], "limits.stop_speed": "0.05 m/s"})
    )
    assert stop.outcome is Outcome.STANDSTILL
    assert float(stop.trace["distance"][-1]) == pytest.approx(700.0, abs=0.5)
    assert stop.metrics.mean_deceleration == pytest.approx(0.6, rel=0.02)


def test_a_slippery_rail_carries_the_train_beyond_the_target():
    stop = run_stop(load(LIBRARY / "stop_at_target.toml"))
    assert stop.outcome is Outcome.STANDSTILL
    assert float(stop.trace["distance"][-1]) > 705.0
    assert float((stop.trace["command"] - stop.trace["driver_demand"]).max()) == 0.0


def test_valve_commands_do_not_exceed_the_driver_demand():
    """Valve logic has a band of pressure around the demand, and a shortest stroke."""
    stop = run_stop(
        load(
            LIBRARY / "service_steps.toml",
            ["vehicle.plant=TwoPartTrainPneumatic", "actuation.kind=pneumatic", "limits.horizon=40 s"],
        )
    )
    over = stop.trace["cylinder_pressure"].values - stop.trace["driver_demand"].values
    held = stop.trace["time"].values > 24.0
    assert over[held & (stop.trace["driver_demand"].values[:, 0] > 0)].max() < 0.1e5


class Eager:
    """Always demands full pressure, and records the driver's demand."""

    def start(self, formation):
        self.full, self.demands = formation.pressure_max, []

    def decide(self, observation):
        self.demands.append(float(observation.driver_demand[0]))
        return self.full


def test_a_controller_of_a_user_receives_the_demand_and_cannot_exceed_it():
    """Without a demand the driver brakes fully."""
    phases = [{"pressure": "1 bar", "until": {"time": "0.5 s"}}, {"pressure": 0}]
    plain = rg.Scenario.load("plain", {"limits.horizon": "1 s", **GRIPPY})
    law = Eager()
    stop = rg.run(plain.changed({"demand": {"phases": phases}}), controller=law)
    assert law.demands == [1e5] * 500 + [0.0] * 501
    assert float(stop.trace["command"].max()) == 1e5
    assert float(stop.trace["demand"].max()) == law.full[0]
    rg.run(plain, controller=law)
    assert set(law.demands) == {law.full[0]}


def test_a_sweep_over_demands():
    demands = [{"phases": [{"pressure": f"{bar} bar"}]} for bar in (1, 2, 3)]
    short = {"start.speed": "20 km/h", **GRIPPY}
    table = rg.sweep(rg.Scenario.load("plain", short), {"demand": demands}).to_pandas()
    assert list(table["outcome"]) == ["standstill"] * 3
    assert table["distance"].is_monotonic_decreasing
