"""The goods wagon of Schwarz and Keck (2020): recordings of its stops, and estimates of its filter."""

import numpy as np
import pytest

import railgrip as rg
from railgrip.base.errors import ScenarioError
from railgrip.estimation.judgement import judge
from railgrip.estimation.models import of_class, units_of
from railgrip.estimation.run import estimate
from railgrip.estimation.sources import recording_of_stop
from railgrip.estimation.spec import LIBRARY, load_specification, settings_for
from railgrip.recording.samples import reading_of, truth_of

PRINTED = {"adhesion_share": 0.5, "resistance_transfer": 1.0, "adhesion_transfer": 0.0}


NOISE = load_specification(LIBRARY / "wagon.toml").source_scenario().noise


def run(name="wagon_stop", seed=None, noise=NOISE):
    return recording_of_stop(name, seed, noise)


@pytest.fixture(scope="module")
def stop():
    return run()


def estimates_for(recorded, **parameters):
    specification = load_specification(LIBRARY / "wagon.toml")
    prediction = of_class("WagonPrediction").prediction(parameters)
    return estimate(
        recorded, prediction, settings_for(specification, recorded.attrs["period"]), units=units_of("WagonPrediction")
    )


def test_load_moves_to_the_front_by_inertia():
    """By ±m|a| h/L, with the lag of the suspension."""
    changes = {"demand": {"phases": [{"pressure": "1.5 bar"}]}, "start.speed": 20.0, "limits.horizon": "3 s"}
    trace = rg.run(rg.Scenario.load("wagon_stop", changes | {"adhesion.mu0": 0.3})).trace
    load, speed = trace["wheelset_load"].values, trace["speed"].values
    acceleration = (speed[-1] - speed[-11]) / 0.1
    assert load.sum(axis=1) == pytest.approx(40e3 * 9.81, rel=1e-12)
    # Friction still increases: loads lag by T_pitch times their rate, and the difference quotient by 50 ms.
    assert load[-1, 0] - load[-1, 1] == pytest.approx(-2 * 1.5 / 9 * 40e3 * acceleration, rel=0.01)


def test_readings_are_the_truth_with_independent_white_noise(stop):
    """Standard deviations of 5000 samples are accurate to 1 %, times four; correlations of instruments to 1.4 %."""
    noise = {key: reading_of(stop, key) - truth_of(stop, state) for key, state in READ.items()}
    for values in noise.values():
        assert np.std(values) == pytest.approx(1e-2, rel=0.04)
    assert np.abs(np.corrcoef(list(noise.values())) - np.eye(3)).max() < 0.06
    rolling = stop["time"].values < 3.9
    assert np.std(reading_of(stop, "pad_force[1]")[rolling]) == pytest.approx(200.0, rel=0.15)
    again, other = run(), run(seed=8)
    assert again.equals(stop)
    assert not other["reading_speed"].equals(stop["reading_speed"])
    assert other["speed"].equals(stop["speed"])


READ = {"speed": "speed", "wheelset_speed[1]": "wheelset_speed[1]", "wheelset_speed[2]": "wheelset_speed[2]"}


def test_bearing_and_rolling_resistance_decelerate_every_wheelset(stop):
    """−(μ r + e) F_z: the loads add up to the weight of the wagon."""
    both = reading_of(stop, "wheel_torque[1]") + reading_of(stop, "wheel_torque[2]")
    assert both == pytest.approx(-(0.0018 * 0.065 + 0.0004) * 40e3 * 9.81, rel=1e-6)


def test_only_signals_of_the_plant_can_be_read():
    with pytest.raises(ScenarioError, match=r"wagon_stop: \[source.noise\] has no parameter 'yaw_rate'"):
        run(noise=NOISE | {"yaw_rate": NOISE["speed"]})


def test_the_corrected_factor_finds_the_adhesion_and_the_printed_one_twice_it(stop):
    braking = (stop["time"].values > 6.0) & (stop["time"].values < 9.5)
    truth = truth_of(stop, "alpha")[braking].mean()
    consistent, printed = (
        estimates_for(stop, **p)["mean"].sel(state="group_adhesion").values[braking].mean() for p in ({}, PRINTED)
    )
    assert consistent == pytest.approx(truth, rel=0.01)
    assert printed == pytest.approx(2 * truth, rel=0.01)


def test_the_printed_factor_biases_pad_friction(stop):
    braking = (stop["time"].values > 6.0) & (stop["time"].values < 9.5)
    for pads in ("mu_b[1]", "mu_b[2]"):
        # Better than the initial value; pad friction hardly changes within the window.
        baseline_error = np.sqrt(np.mean((truth_of(stop, pads)[braking] - 0.35) ** 2))
        assert judge(stop, estimates_for(stop), pads, braking).rmse < 0.8 * baseline_error
    assert judge(stop, estimates_for(stop, **PRINTED), "mu_b[1]", braking).bias > 0.3


def test_a_common_adhesion_of_unequally_braked_wheelsets_biases_their_pads():
    """A limit of the six-state model: rolling wheelsets use the adhesion that their brakes demand."""
    unequal = run("wagon_unequal")
    braking = (unequal["time"].values > 6.0) & (unequal["time"].values < 9.5)
    estimated = estimates_for(unequal)
    assert abs(judge(unequal, estimated, "alpha", braking).bias) < 0.002
    assert judge(unequal, estimated, "mu_b[1]", braking).bias < -0.03
    assert judge(unequal, estimated, "mu_b[2]", braking).bias > 0.03
