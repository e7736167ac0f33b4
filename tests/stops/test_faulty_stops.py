"""Stops of trains with faults, and of trains whose true data differ from the nominal ones."""

import numpy as np
import pytest
from python_parts import same_stop
from synthetic import LIBRARY

from railgrip.scenario.file import merge
from railgrip.scenario.load import load, scenario_of
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.faults.site import FREE
from railgrip.simulate.run import run_stop

HEALTHY = {"faults": [], "truth": {"load": 1, "wheel_radius": 1, "pad_friction": 1, "gradient": 0}}
SHORT = {"start": {"speed": "25 km/h"}, "limits": {"horizon": "20 s"}}


def train(*faults, **changes):
    """The library's scenario from 25 km/h with other faults, or none."""
    table = merge(load(LIBRARY / "degraded.toml").resolved(), merge(merge(HEALTHY, SHORT), changes))
    return scenario_of(table | {"faults": list(faults)}, directory=LIBRARY, origin="broken")


def stuck(begin):
    """Return faults of the valves of the first three groups."""
    return [{"part": "valve", "kind": kind, "group": g, "begin": begin}
            for g, kind in enumerate(("filled", "dumped", "held"), start=1)]  # fmt: skip


@pytest.fixture(scope="module")
def healthy():
    return run_stop(train())


def test_the_faulty_train_of_the_library_stops():
    """Parts in Python have the same faults while the radar is dead and after."""
    stop = run_stop(load(LIBRARY / "degraded.toml"))
    same_stop(load(LIBRARY / "degraded.toml", ["limits.horizon=6 s"]))
    assert stop.outcome is Outcome.STANDSTILL
    radar = stop.trace["reading_speed"].values
    assert np.isnan(radar[3000:5000]).all()
    assert not np.isnan(radar[5000:6000]).all()
    assert [fault.kind for fault in stop.scenario.faults] == ["missing_teeth", "dead", "slow", "isolated"]


def test_stuck_valves_act_according_to_the_name_of_the_fault(healthy):
    stop = run_stop(train(*stuck("2 s")))
    late = stop.trace.sel(time=slice(4.0, None))
    command, pressure = late["command"].values, late["cylinder_pressure"].values
    assert (command[:, :3] == [1, -1, 0]).all()
    # For a first-order lag of 0.4 s, e^-5 remains after 2 s; a held cylinder only loses the leak of 1 kPa/s.
    assert pressure[0, 0] == pytest.approx(3.4e5, rel=0.01)
    assert pressure[:, 1].max() < 1e3
    drop = pressure[0, 2] - pressure[-1, 2]
    assert drop == pytest.approx(1e3 * (len(late["time"]) - 1) * 1e-3, rel=0.2)
    assert stop.trace["demand"].values[-1, 1] > 0.0  # the controller does not know
    before = slice(0, 2000)
    assert np.array_equal(stop.trace["speed"].values[before], healthy.trace["speed"].values[before])


def test_a_sagging_supply_fills_no_cylinder_beyond_its_pressure():
    """Isothermal reservoir of 30 l at 4 bar: no fill valve opens once a cylinder has the pressure of the reservoir."""
    stop = run_stop(train({"part": "supply", "kind": "sagging", "value": "30 l", "pressure": "4 bar"}))
    trace = stop.trace
    reservoir = 4e5 - FREE * (trace["air_used"].values - trace["air_used"].values[0]) / 0.03
    inside, command = trace["cylinder_pressure"].values[:-1], trace["command"].values[1:]
    assert not (command[inside >= reservoir[:-1, None]] > 0).any()
    assert (trace["demand"].values[1:][inside >= reservoir[:-1, None]] > 0).any()


def test_an_isolated_unit_lowers_the_torque_by_its_share(healthy):
    """Two of three units remain: 2/3 of the torque at the same pressure and pad friction."""
    stop = run_stop(train({"part": "brake", "kind": "isolated", "group": 1, "value": 1}))

    def torque_per_force(trace):
        at = trace.isel(time=1500)
        force = at["pad_force"].values * at["pad_friction"].values
        return (at["brake_torque"].values / force)[0]

    assert torque_per_force(stop.trace) == pytest.approx(2 / 3 * torque_per_force(healthy.trace), rel=1e-9)
    whole = run_stop(train({"part": "brake", "kind": "isolated", "group": 1}))
    assert np.abs(whole.trace["brake_torque"].values[:, 0]).max() < 50.0
    assert (whole.trace["brake_limit"].values[:, 0] == 0.0).all()


def test_valve_faults_also_apply_to_ideal_actuation():
    ideal = {"vehicle": {"plant": "TwoPartTrain"}, "actuation": {"kind": "ideal"}}
    stop = run_stop(train(*stuck("1 s"), {"part": "valve", "kind": "slow", "group": 4, "value": "50 ms"}, **ideal))
    command = stop.trace["command"].values
    assert (command[1001:, 0] == 3.4e5).all()
    assert (command[1001:, 1] == 0.0).all()
    assert (command[1001:, 2] == command[1000, 2]).all()
    assert np.array_equal(command[51:, 3], stop.trace["demand"].values[1:-50, 3])


def test_a_lighter_train_downhill_decelerates_accordingly():
    """No slip on a dry rail: with the same pressures, a = (F - m g i)/m, to the drift of pads and drag."""
    grip = {"adhesion": {"kind": "constant", "polach": "dry", "mu0": 0.5}, "controller": {"kind": "full_brake"}}
    nominal, lighter = (
        run_stop(train(truth=truth, **grip)) for truth in ({"load": 1}, {"load": 0.8, "gradient": -0.01})
    )
    a, b = (-stop.trace["acceleration"].values[2500] for stop in (nominal, lighter))
    mass, rotating = 84e3, (2 * 222 + 2 * 209) / 0.38**2
    assert b == pytest.approx((a * (mass + rotating) - 0.8 * mass * 9.81 * 0.01) / (0.8 * mass + rotating), rel=0.01)


def test_sensors_with_realistic_errors_read_accordingly():
    """A radar with drift and dropouts, an accelerometer on an unknown gradient of 1 %, deflections due to the rail."""
    sensors = {
        "speed": {"drift": "0.5 %", "drift_time": "5 s", "dropouts": "20 %", "dropout_time": "0.3 s"},
        "acceleration": {"feels_gradient": True},
        "deflection": {"noise": 0, "irregularity": {"track": "erri-high", "frequency": "5.9 Hz", "damping": 0.19}},
    }
    stop = run_stop(train(sensors=sensors, truth={"gradient": 0.01}))
    trace = stop.trace
    felt = trace["reading_acceleration"].values - trace["acceleration"].values
    plain = run_stop(train(truth={"gradient": 0.01})).trace
    assert felt.mean() - (plain["reading_acceleration"] - plain["acceleration"]).values.mean() == pytest.approx(
        0.0981, abs=2e-3
    )
    due = trace["reading_speed"].values[50::50]
    assert 0 < np.isnan(due).sum() < len(due)
    # Without noise only the rail remains: at 7 m/s hardly any wave is as short as the frame's bounce mode requires.
    shaken = (trace["reading_deflection"] - trace["deflection"]).values
    assert 1e-5 < shaken[:1000].std() < 3e-4
    assert np.abs(shaken[-100:]).max() < np.abs(shaken).max()  # it decays as the train stops
