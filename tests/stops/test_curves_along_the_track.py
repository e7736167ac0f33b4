"""A rail whose creep curve varies from place to place, and from wheelset to wheelset."""

from pathlib import Path

import numpy as np
import pytest
from python_parts import same_stop
from small_train import one_bogie

from railgrip.base.errors import RailgripError
from railgrip.scenario.load import load, scenario_of
from railgrip.simulate.run import run_stop
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.vehicle.signals import CURVE

LEAF = "{ begin = '20 m', length = '30 m', mu0 = 0.07, polach = 'leaf' }"
PATCH = f"adhesion.patch=[{LEAF}]"
WITHOUT = ("estimator.kind=none", "controller.kind=slip_two_state")
ALL_LEAF = f"adhesion.polach_of_wheelset={['leaf'] * 6}"
COARSE = tuple(f"periods.{part}=10 ms" for part in ("communication", "estimator", "controller", "trace"))
"""For the ideal bound, whose distance hardly depends on the grid (test_ideal_bound.py)."""


def scenario(*overrides):
    return load(Path("plain"), ["start.speed=60 km/h", *overrides])


def test_a_curve_sent_as_input_equals_one_set_as_a_parameter():
    """The two are different FMUs; their internal steps are equal up to rounding, which slides double some ten times."""
    sent, parameter = (run_stop(scenario(*WITHOUT, *lying)).trace for lying in ((ALL_LEAF,), ("adhesion.polach=leaf",)))
    assert np.allclose(sent["adhesion"].values, parameter["adhesion"].values, rtol=0, atol=1e-9)
    assert sent["distance"].values[-1] == pytest.approx(parameter["distance"].values[-1], rel=1e-9)
    assert np.allclose(sent["peak_adhesion"].values, parameter["peak_adhesion"].values, rtol=0, atol=1e-9)
    assert "curve_k_A" not in parameter


def test_each_wheelset_has_the_curve_of_its_place():
    """The output adhesion is that of Polach's law with the curve at the place of the wheelset."""
    question = scenario(*WITHOUT, PATCH)
    trace, vehicle = run_stop(question).trace, VehicleData(question)
    distance, position = trace["distance"].values[:, None], vehicle.formation.position
    # Set for the place of the train one communication step earlier, up to 17 mm behind.
    into = distance - position - 20.0
    sure = np.minimum(np.abs(into), np.abs(into - 30.0)) > 0.02
    on_leaf = (into > 0) & (into < 30.0)
    dry, leaf = question.adhesion.curves
    for signal, key in zip(CURVE, ("k_A", "k_S", "A", "B"), strict=True):
        expected = np.where(on_leaf, getattr(leaf, key), getattr(dry, key))
        assert np.array_equal(trace[signal.name].values[sure], expected[sure]), signal.name
    slip, speed = trace["slip"].values[:, vehicle.formation.group_of_wheelset], trace["speed"].values[:, None]
    for curve, there in ((dry, ~on_leaf), (leaf, on_leaf)):
        alone = VehicleData(scenario(f"adhesion.polach={curve.name}")).contact
        law = alone(slip, np.broadcast_to(speed, slip.shape), trace["wheelset_load"].values, trace["mu0"].values)
        rolling = sure & there & (speed > 2.0)  # the plant rounds slip below its v_small of 0.1 m/s
        assert rolling.sum() > 1000
        # By (0.1/v)²/2 of the slip even above: 1.3e-3 at 2 m/s, of which the steepest part of a curve makes 2e-4.
        assert np.allclose(trace["adhesion"].values[rolling], law[rolling], rtol=0, atol=2e-4)


def test_the_curve_changes_in_the_middle_of_an_edge_and_friction_across_it():
    edged = "{ begin = '20 m', length = '30 m', mu0 = 0.07, polach = 'leaf', edge = '4 m' }"
    trace = run_stop(scenario(*WITHOUT, f"adhesion.patch=[{edged}]")).trace
    place, first = trace["distance"].values, trace["curve_k_A"].values[:, 0]
    assert place[np.argmax(first < 1.0)] == pytest.approx(22.0, abs=0.04)  # two communication steps
    back = np.argmax(first < 1.0) + np.argmax(first[np.argmax(first < 1.0) :] == 1.0)
    assert place[back] == pytest.approx(48.0, abs=0.04)


@pytest.mark.parametrize(
    "rail",
    [
        (PATCH,),
        (PATCH, "adhesion.polach_of_wheelset=['soap', 'soap', 'wet', 'wet', 'dry', 'dry']"),
        (PATCH, "adhesion.recovery={mu0=0.3, A=0.4, B=0.6, rate='1.9e-4 m/J'}"),
    ],
)
def test_parts_in_python_with_an_estimator(rail):
    stop = same_stop(scenario(*rail, "limits.horizon=6 s"))
    assert set(np.unique(stop.trace["curve_k_A"].values)) >= {0.04, 1.0}


def test_valves_service_sensors_and_a_train_file(tmp_path):
    (tmp_path / "small.toml").write_text(one_bogie(), encoding="utf-8")
    parts = ("actuation.kind=pneumatic", "sensors.kind=white", "limits.horizon=4 s")
    table = scenario(*WITHOUT, *parts, PATCH).resolved() | {"vehicle": {"train": "small.toml"}}
    assert run_stop(scenario_of(table, directory=tmp_path, origin="small")).trace["curve_k_A"].values.min() == 0.04


def test_wheelsets_of_a_wagon():
    trace = run_stop(load(Path("wagon_stop"), ["adhesion.polach_of_wheelset=['leaf', 'dry']"])).trace
    assert trace["curve_k_A"].values[0].tolist() == [0.04, 1.0]
    # Both wheelsets are braked equally, so the one on the flatter curve slips more.
    assert trace["slip"].values[1000, 0] > 5 * trace["slip"].values[1000, 1] > 0


def test_slip_cleans_a_patch_by_the_law_of_its_curve():
    """A clean rail equals the leaf: nothing changes on the patch, and friction falls less on the surrounding rail."""
    clean = "adhesion.recovery={mu0=0.07, A=0.5, B=0.1, rate='1 m/J'}"
    trace = run_stop(scenario(*WITHOUT, PATCH, clean)).trace
    on_leaf = trace["curve_k_A"].values == 0.04
    assert trace["mu0"].values[on_leaf] == pytest.approx(0.07, rel=1e-12)
    assert trace["mu0"].values[~on_leaf].max() > 0.09


def test_the_bound_is_between_those_of_its_curves():
    """From 20 km/h, as the tracking stop, whose law knows the curve under each wheelset."""
    mixed = (PATCH, "adhesion.polach_of_wheelset=['leaf', 'leaf', 'dry', 'dry', 'dry', 'dry']")
    dry, bound, tracking, sent, leaf = (
        run_stop(scenario("start.speed=20 km/h", f"controller.kind={kind}", "estimator.kind=none", *lying, *COARSE))
        .metrics.distance
        for kind, lying in (
            ("ideal_bound", ("adhesion.polach=dry",)), ("ideal_bound", mixed), ("ideal_tracking", mixed),
            ("ideal_bound", (ALL_LEAF,)), ("ideal_bound", ("adhesion.polach=leaf",)),
        )
    )  # fmt: skip
    assert dry < bound < tracking < min(1.05 * bound, leaf)
    assert sent == pytest.approx(leaf, rel=1e-12)


def test_an_onboard_unknown_error_of_the_creep_curve_scales_all_curves():
    vehicle = VehicleData(scenario(PATCH, "truth.creep={k_A=0.5}"))
    assert vehicle.curves.tolist() == [[0.5, 0.4, 0.4, 0.6], [0.02, 0.015, 0.5, 0.1]]
    trace = run_stop(scenario(*WITHOUT, PATCH, "truth.creep={k_A=0.5}", "limits.horizon=3 s")).trace
    assert set(np.unique(trace["curve_k_A"].values)) == {0.5, 0.02}


def test_a_plant_without_such_inputs_is_refused():
    question = load(Path("foreign_train"), [f"adhesion.polach_of_wheelset={['leaf'] * 3}"])
    with pytest.raises(RailgripError, match=r"(?s)curve_k_A"):
        run_stop(question)
