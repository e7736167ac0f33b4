"""The Kalman filter knows the forces on the train that are known on board: brakes on the rail itself, and traction.

Without the former, a filter whose radar is dead assumes that the train runs on: its speed was 20 m/s when the train
stood. Without the latter, its speed was 10 m/s too low.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_own_prediction_fmu import own
from test_stop_at_target import DRY
from test_stops_with_dynamic_brakes import RAIL, one_braked_bogie
from test_stops_with_dynamic_brakes import scenario as dry

from railgrip.base import registry
from railgrip.base.errors import ScenarioError
from railgrip.base.registry import shelf
from railgrip.rolling_stock.schema import load_train
from railgrip.rolling_stock.stopping import developed_forces
from railgrip.scenario.load import load
from railgrip.simulate.assembly import assemble
from railgrip.simulate.estimator import body_force_of
from railgrip.simulate.export.c_parts import part_in_c
from railgrip.simulate.run import trace_of
from railgrip.studies.stop_at_target.stop_at_target_study import LIBRARY, MANAGED, scenario_of_case

SPEEDS = (55.0, 30.0, 17.0, 8.0, 1.0)


def speed_error(trace, above=3.0):
    """Return the largest error of the estimated speed while the train is faster than a speed [m/s]."""
    speed = trace["speed"].values
    return np.abs(trace["estimate_speed"].values - speed)[speed > above].max()


ON_RAIL = [path for path in (LIBRARY / "railcar.toml", *shelf("trains").values()) if load_train(path).rail_brakes]


@pytest.mark.parametrize("path", ON_RAIL, ids=lambda path: path.stem)
def test_developed_forces_are_those_of_the_hand_calculation(path):
    train = load_train(path)
    force = body_force_of(train, 0.005)
    assert force is not None
    assert train.linear_resistance == 0.0  # it would add to the force
    for speed in SPEEDS:
        for _ in range(4000):  # 20 s, more than ten time constants
            (found,) = force.call([speed, 1.0, 1.0, 1.0])
        assert found == pytest.approx(developed_forces(train, speed)(speed).rail.sum(), rel=1e-4)


COMMANDS = [(0.05, 0), (0.6, 1), (0.12, 0), (0.31, 1), (0.9, 0), (0.08, 1), (0.6, 0), (0.4, 1)]
"""Duration [s] and command of the phases of a test, some of them shorter than the delay of magnets."""


@pytest.mark.parametrize("period", [0.001, 0.005, 0.01, 0.02])
@pytest.mark.parametrize("kind", ["magnets", "eddy current"])
def test_brakes_on_the_rail_have_the_dynamics_of_the_plant_both_ways(kind, period, tmp_path):
    """Against an integration in steps of 0.1 ms: a command acts after the delay, on or off, and a first-order lag.

    Commands are sampled each 10 ms, and the lag of the formula is of backward Euler: in one period of both a field
    may change by a share period/T.
    """
    train = load_train(Path("tram") if kind == "magnets" else eddy_current_train(tmp_path))
    brake, force = next(brake for *_, brake in train.rail_brakes), body_force_of(train, period)
    full, fine = developed_forces(train, 17.0)(17.0).rail.sum(), 1e-4
    ends = np.cumsum([duration for duration, _ in COMMANDS])

    def command(time):
        return 0 if time < 0 else COMMANDS[min(np.searchsorted(ends, time, side="right"), len(COMMANDS) - 1)][1]

    delay, field, known = getattr(brake, "delay", 0.0), [], []
    for step in range(round(ends[-1] / fine)):
        before = field[-1] if field else 0.0
        field.append(before + fine / brake.time_constant * (command(step * fine - delay) - before))
    for step in range(round(ends[-1] / period)):
        on = command(step * period)
        (found,) = force.call([17.0, 1.0, *((1.0, on) if kind == "magnets" else (on, 1.0))])
        known.append(found / full)
    true = np.array(field)[np.rint((np.arange(len(known)) + 1) * period / fine).astype(int) - 1]
    assert np.ptp(true) > 0.7
    assert np.abs(true - known).max() < 1.5 * (0.01 + period) / brake.time_constant
    assert force.call([17.0, 0.0, 0.0, 0.0])[0] > 0.1 * full  # not at once


def test_magnets_wait_for_the_brakes_and_for_their_highest_speed():
    force = body_force_of(load_train(Path("tram")), 0.01)
    for inputs in ([17.0, 0.0, 1.0, 1.0], [57.0, 1.0, 1.0, 1.0]):
        assert {force.call(inputs)[0] for _ in range(200)} == {0.0}


def test_a_train_without_such_forces_has_none():
    assert body_force_of(load_train(Path("vt642")), 0.005) is None


def test_linear_resistance_is_known():
    """110 N.s/m of the published train: A, B and C of its resistance."""
    force = body_force_of(load_train(Path("two_car_unit")), 0.005)
    assert force.call([30.0, 0.0, 0.0, 0.0]) == pytest.approx((3300.0,), rel=1e-12)


def test_the_speed_does_not_drift_by_linear_resistance_while_the_radar_is_dead():
    """Without it the filter errs by 0.2 m/s in this stop from 100 km/h; sensors are ideal."""
    faults = [{"part": "radar", "kind": "dead", "begin": "1 s"}]
    stop = dry(Path("two_car_unit"), mu0=0.5, estimator={"kind": "compiled"}, faults=faults)
    trace = trace_of(stop.revised({"vehicle": {"train": "two_car_unit"}}))
    assert speed_error(trace) < 0.1


def dead_radar(**changes):
    stop = scenario_of_case(("driver", {}, replace(DRY, friction=0.05, rail="slippery", fault="radar dead"), True))
    return stop.revised({"demand": {"phases": [{"pressure": "full"}]}, "sanders": [], **changes})


@pytest.mark.parametrize("kind", ["decentralised", "compiled"])
def test_the_speed_does_not_drift_while_magnets_brake_and_the_radar_is_dead(kind):
    """Within 1 m/s: gradient and load are nominal, and radii, accelerometer and pads err as in service.

    Magnets take 0.3 to 0.7 m/s² of the train's deceleration; over 15 s a filter without them errs by 5 m/s or more.
    """
    trace = trace_of(dead_radar(estimator={"kind": kind, "noise": "service"}))
    assert trace["magnets"].values.max() == 1.0
    assert np.isnan(trace["reading_speed"].values[trace["time"].values > 4.1]).all()
    assert speed_error(trace) < 1.0


def eddy_current_train(tmp_path):
    """Return the file of a car with a rail brake and no electric brake on axles."""
    return one_braked_bogie(tmp_path / "eddy.toml", "rail", RAIL)


SWITCHED = [{"pressure": each, "until": {"duration": "2 s"}} for each in ("full", "1 bar", "full")] + [{"pressure": 0}]


@pytest.mark.parametrize("changes", [{}, {"demand": {"phases": SWITCHED}, "limits": {"horizon": "8 s"}}])
def test_a_linear_eddy_current_brake_is_known_on_and_off(changes, tmp_path):
    """Ideal sensors, no radar reading from 1 s on; a service brake switches it off."""
    file = eddy_current_train(tmp_path)
    faults = [{"part": "radar", "kind": "dead", "begin": "1 s"}]
    trace = trace_of(dry(file, mu0=0.05, estimator={"kind": "compiled"}, faults=faults, **changes))
    assert speed_error(trace) < (0.1 if changes else 0.5)


def test_a_tram_that_lifts_its_magnets_stops_at_its_target_without_a_radar():
    """The law lowers and lifts them; a filter that dropped the force at once ran 4.4 m/s too fast, 38 m short."""
    stop = dry(
        Path("tram"),
        mu0=0.3,
        start={"speed": "55 km/h"},
        controller={"kind": "deceleration_control", "parameters": {"target": "120 m"}},
        estimator={"kind": "decentralised", "noise": "service"},
        actuation={"kind": "pneumatic"},
        sensors=dead_radar().tables()["sensors"],
        faults=[{"part": "radar", "kind": "dead", "begin": "1 s"}],
    )
    trace = trace_of(stop)
    assert np.abs(np.diff(trace["magnets"].values)).sum() >= 2
    assert speed_error(trace, above=0.5) < 0.5
    assert abs(trace["distance"].values[-1] - 120.0) < 5.0


@pytest.mark.parametrize("kind", registry.modules(registry.FILTERS))
def test_the_speed_does_not_drift_while_the_train_accelerates_and_the_radar_is_dead(kind):
    """Traction of 50 kN is on until 4 s, at 0.6 m/s², and then off, without a reading of the speed; sensors are ideal.

    A filter without the traction errs by 2 m/s; pads and adhesion that some filters assume take a part of 0.1 m/s.
    """
    trace = trace_of(accelerated(kind, [{"part": "radar", "kind": "dead", "begin": "1 s"}]))
    assert np.ptp(trace["speed"].values) > 2.0
    assert speed_error(trace, above=0.0) < 0.1


def accelerated(kind, faults=()):
    traction = {"force": "50 kN", "power": "500 kW", "rate": "100 kN/s"}
    changes = {
        "start": {"speed": "20 km/h"},
        "demand": {"phases": [{"pressure": 0, "traction": traction, "until": {"time": "4 s"}}, {"pressure": 0}]},
        "faults": faults,
        "estimator": {"kind": kind, "noise": "service"},
        "periods": dict.fromkeys(("communication", "estimator", "controller", "trace"), "10 ms"),
        "limits": {"horizon": "6 s"},
    }
    return load(Path("service_steps")).revised(changes)


def test_a_filter_that_knows_traction_does_not_leave_as_an_fmu():
    for part in ("onboard", "estimator"):
        with pytest.raises(ScenarioError, match=r"has traction, which the filter knows"):
            part_in_c(accelerated("compiled"), part)


def test_the_estimator_alone_does_not_leave_as_an_fmu(tmp_path):
    """It has no input for the commands, by which the filter assumes the force."""
    with pytest.raises(ScenarioError, match=r"export the onboard part"):
        part_in_c(dead_radar(), "estimator")
    assert "call_body_force" in part_in_c(dead_radar(), "onboard").step.text


def test_a_law_that_switches_magnets_leaves_neither_with_the_filter_nor_without_the_track():
    stop = scenario_of_case((MANAGED, {}, DRY, True)).revised({"sanders": []})
    for kind in ("onboard", "track"):
        with pytest.raises(ScenarioError, match=r"switches the magnetic track brakes"):
            part_in_c(stop, kind)


def test_a_prediction_without_track_force_is_reported(tmp_path):
    of_input = 'forward" causality="input" variability="continuous"'
    file = own(tmp_path, (of_input, 'forward" causality="local" variability="continuous"'))
    stop, notes = dead_radar(estimator={"kind": "fmu", "file": str(file), "trust": True, "noise": "service"}), []
    with assemble(stop, notify=notes.append):
        pass
    assert sum("does not know the force of the brakes on the rail itself" in note for note in notes) == 1
