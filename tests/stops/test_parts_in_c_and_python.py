"""Plants, filters and laws called in C give the same stop as those for which the loop returns to Python."""

import numpy as np
import pytest
from python_parts import hidden, same_stop
from synthetic import LIBRARY
from table_1 import table_1_scenario

from railgrip.fmus.build import fmu
from railgrip.scenario.file import merge
from railgrip.scenario.load import load
from railgrip.scenario.schema import Scenario
from railgrip.simulate.assembly import assemble
from railgrip.simulate.loop.loop import Loop
from railgrip.simulate.run import braking_distance, run_stop
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of
from railgrip.studies.type_test.track_case import HEADLINES

WITHOUT = ("estimator.kind=none",)
SHORT = ("limits.horizon=4 s",)


def stop_of(scenario: str, *overrides: str):
    return same_stop(load(LIBRARY / f"{scenario}.toml", list(overrides)))


@pytest.mark.parametrize(
    ("controller", "others"),
    [
        ("slip_three_state", WITHOUT),
        ("wheel_reference", WITHOUT),
        ("extremum_seeking", ()),
        ("adhesion_based", ("periods.estimator=2 ms", "periods.controller=5 ms")),
        ("adhesion_based", ("estimator.model=TrainPredictionReduced",)),
    ],
)
def test_laws_with_ideal_parts(controller, others):
    stop_of("trapezoid", f"controller.kind={controller}", *SHORT, *others)


@pytest.mark.parametrize("controller", ["slip_three_state", "adhesion_literal", "slope_seeking"])
def test_laws_with_valves_and_service_sensors(controller):
    same_stop(table_1_scenario(f"random-service-{controller}", *SHORT))


def test_a_law_that_seeks_deep_slip_on_a_rail_cleaned_by_slip():
    (case,) = (case for case in HEADLINES if case.name == "cleaned rail")
    (planned,) = campaign_of([case], {"law": entrants(2)["two_maxima"]}, train_of(None)).stops
    changes = {"limits": {"horizon": "11 s"}}
    one = same_stop(Scenario.model_validate(merge(planned.scenario.resolved(), changes)))
    assert one.trace["law_deep_slip"].values[-1] == 1.0


def test_a_filter_that_lost_a_wheelset_and_rejects_the_radar():
    """The law must be notified: it then follows the other wheelsets."""
    scenario = table_1_scenario("random-service-slope_seeking")
    changes = {
        "estimator": {"model": "TrainPredictionDisturbed", "outlier_limit": {"speed": 4.0}, "load_deviation": "10 %"},
        "faults": [
            {"part": "speed_sensor", "kind": "dead", "group": 1, "begin": "1 s"},
            {"part": "radar", "kind": "stuck", "begin": "4 s"},
        ],
        "limits": {"horizon": "7 s"},
    }
    one = same_stop(Scenario.model_validate(merge(scenario.resolved(), changes)))
    # The filter uses the radar from 4 s until its speed becomes impossible.
    speed = one.trace["speed"].values
    assert np.nanmax(one.trace["reading_speed"].values - speed) > 1.0
    assert np.abs(one.trace["estimate_speed"].values - speed).max() < 0.5


def test_wheels_that_replace_a_silent_radar():
    """On a falling track unknown to the filter, so that its estimated speed drifts."""
    scenario = table_1_scenario("random-service-slope_seeking")
    changes = {
        "estimator": {"model": "TrainPredictionDisturbed"},
        "faults": [
            {"part": "radar", "kind": "dead", "begin": "1 s"},
            {"part": "accelerometer", "kind": "biased", "value": "0.3 m/s**2"},
        ],
        "truth": {"gradient": -0.01},
        "adhesion": {"kind": "constant", "polach": "low_steep", "mu0": 0.04},
        "limits": {"horizon": "30 s"},
    }
    alone = Scenario.model_validate(merge(scenario.resolved(), changes))
    helped = Scenario.model_validate(merge(alone.resolved(), {"estimator": {"free_wheels": True}}))
    one = run_stop(helped)
    same_stop(Scenario.model_validate(merge(helped.resolved(), {"limits": {"horizon": "10 s"}})))

    def error(stop):
        return np.abs(stop.trace["estimate_speed"] - stop.trace["speed"]).values[-5000:].max()

    # Between two releases 5 s apart 0.3 m/s² cause 1.5 m/s at first, less once the filter has estimated the bias; a
    # filter without releases is lost.
    assert error(one) < 0.5
    assert error(run_stop(alone)) > 2.0
    trace = one.trace.sel(time=slice(2.0, None))
    released = trace["test_release"].values > 0.0
    assert np.all(released.sum(axis=1) <= 1)  # never more than one group
    assert np.all(released.any(axis=0))  # one after the other
    given = np.isfinite(trace["reference_speed"].values)
    assert np.all(np.isnan(trace["reading_speed"].values))
    # A rolling wheel reads the train's speed, apart from reading noise and the lag of the last spin-up.
    assert np.abs(trace["reference_speed"] - trace["speed"]).values[given].max() < 0.4


@pytest.mark.parametrize("controller", ["slip_two_state", "full_brake"])
def test_a_foreign_plant_without_slip_output(controller, tmp_path):
    """Slip follows from the output speeds."""
    rest = (LIBRARY / "foreign_train.toml").read_text(encoding="utf-8")
    without = "\n".join(line for line in rest.splitlines() if not line.startswith("slip = "))
    path = tmp_path / "foreign_train.toml"
    path.write_text(without.replace("../../../build/fmus/ForeignTrain.fmu", str(fmu("ForeignTrain"))))
    question = load(path, ["vehicle.trust=true", f"controller.kind={controller}", *SHORT])
    assert not np.isnan(same_stop(question).trace["slip"].values).any()


@pytest.mark.parametrize("wrap", [hidden, lambda parts: parts], ids=["python", "c"])
def test_a_stop_that_keeps_two_samples_ends_like_one_that_keeps_all(wrap):
    question = load(LIBRARY / "plain.toml", ["start.speed=20 km/h"])
    with assemble(question, capacity=2) as parts:
        ending = Loop(wrap(parts.parts)).run()
        rows = parts.recorder.rows
    whole = run_stop(question)
    assert rows.shape[0] == parts.recorder.written == 2
    assert (ending.reason, ending.samples) == (whole.reason, whole.trace.sizes["time"])
    for name in ("distance", "speed", "estimate_slip", "estimate_adhesion_sd"):
        ends = whole.trace[name].values[[0, -1]].reshape(2, -1)
        assert rows[:, parts.recorder.columns[name]].tobytes() == ends.tobytes(), name


@pytest.mark.parametrize("scenario", ["plain", "service_steps"])
def test_the_distance_alone_equals_that_of_the_whole_stop(scenario):
    question = load(LIBRARY / f"{scenario}.toml", ["start.speed=30 km/h"])
    assert braking_distance(question) == run_stop(question).metrics.distance
