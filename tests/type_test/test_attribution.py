"""Laws with the truth in place of estimates and valves, and of the rail; the division of the loss, and the gains."""

from dataclasses import replace

import given_truth
import numpy as np
import pandas as pd
import pytest
from given_truth import (
    BOTH,
    DECISIONS,
    ENTRANTS,
    LAW,
    LAWS,
    NO_VALVES,
    NOTHING,
    TRUE_STATE,
    distance_with,
    gains,
    losses,
    scenario_with,
)

from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.type_test.entrants import campaign_of, train_of
from railgrip.studies.type_test.track_case import HEADLINES

PATCHES = replace(HEADLINES[0], speed=8.0, faults=("radar stuck", "valve slow"))


def scenario_of(case, law=LAW):
    return campaign_of([case], {law: ENTRANTS[law]}, train_of(None)).stops[0].scenario


@pytest.fixture(scope="module")
def scenario():
    return scenario_of(PATCHES)


def test_faults_go_with_the_parts_that_are_replaced(scenario):
    faults = {given: [fault.part for fault in scenario_with(scenario, given).faults] for given in (NOTHING, TRUE_STATE)}
    assert faults == {NOTHING: ["radar", "valve"], TRUE_STATE: ["valve"]}
    ideal = scenario_with(scenario, NO_VALVES)
    assert ([fault.part for fault in ideal.faults], ideal.actuation.kind) == (["radar"], "ideal")


def test_a_law_that_is_given_the_truth_stops(scenario):
    # The law seeks by exact signals: the distance is near that of the stop with estimates.
    assert distance_with(scenario, BOTH) == pytest.approx(distance_with(scenario, NO_VALVES), rel=0.2)


def test_the_parts_of_a_loss_add_up_to_it():
    columns = [NOTHING, NO_VALVES, TRUE_STATE, BOTH, "bound"]
    parts = losses(
        pd.DataFrame([[120.0, 110.0, 112.0, 104.0, 100.0], [102.0, 101.0, 101.0, 100.5, 100.0]], columns=columns)
    )
    assert parts.iloc[0].to_list() == pytest.approx([0.07, 0.09, 0.04, 0.2])
    assert parts.drop(columns="all").sum(axis=1).to_list() == pytest.approx(parts["all"].to_list())


def test_on_an_even_rail_the_adhesion_ahead_changes_nothing():
    even = scenario_of(replace(PATCHES, rail="even", faults=()))
    assert distance_with(even, "adhesion ahead") == pytest.approx(distance_with(even, NOTHING), rel=1e-9)


@pytest.mark.parametrize("given", ["slip of the peak", "deep slip once compared"])
def test_a_law_that_knows_the_rail_stops(given):
    case = scenario_of(replace(HEADLINES[2], speed=8.0), "two_maxima")
    assert distance_with(case, given) == pytest.approx(distance_with(case, NOTHING), rel=0.3)


def test_deep_slip_from_the_start_is_shorter_where_slip_cleans_the_rail():
    cleaned = replace(HEADLINES[2], speed=12.0)
    deep = distance_with(scenario_of(cleaned, "two_maxima"), "deep slip")
    assert deep < distance_with(scenario_of(cleaned), NOTHING)


def test_valves_without_dead_time_are_those_of_plant_and_law(scenario):
    vehicle = VehicleData(scenario_with(scenario, "valves without dead time"))
    for data in (vehicle.true, vehicle.nominal):
        assert data.valves["dead_fill"] == data.valves["dead_vent"] == 0.0


def test_gains_are_relative_to_each_law_and_the_true_decision_is_the_shorter_stop():
    deep = {(LAWS[1], piece): [80.0, np.nan] for piece in DECISIONS}
    distances = pd.DataFrame(
        {(LAW, NOTHING): [100.0, 200.0], (LAW, "a piece"): [90.0, np.nan], (LAWS[1], NOTHING): [160.0, 50.0],
         (LAWS[1], "a piece"): [200.0, 49.0], **deep}
    ).rename_axis(columns=["law", "given"])  # fmt: skip
    found = gains(distances)
    assert found[LAW, "a piece"].to_list() == pytest.approx([-0.1, np.nan], nan_ok=True)
    assert found[LAWS[1], "a piece"].to_list() == pytest.approx([0.25, -0.02])
    for piece in DECISIONS:
        assert found[LAW, f"{piece}, or not"].to_list() == pytest.approx([-0.2, 0.0])
        assert found[LAWS[1], f"{piece}, or not"].to_list() == pytest.approx([-0.5, 3.0])


def test_rows_are_means_over_all_training_cases_those_of_further_parts_included(monkeypatch):
    """Laws that stop 10 % earlier with each piece of the truth, and a bound at 80 m."""

    def stops(training, names, given):
        distances = {(LAW, NOTHING): 100.0, (LAWS[1], NOTHING): 100.0, ("ideal_bound", NOTHING): 80.0}
        rows = [(case, law, piece, distances.get((law, piece), 90.0)) for case in names for law, piece in given]
        frame = pd.DataFrame(rows, columns=["case", "law", "given", "distance"])
        return frame.assign(rails=np.where(frame["case"] == names[0], "cleaned", "other"))

    monkeypatch.setattr(given_truth, "_stops", stops)
    rows = given_truth.gain_rows(16)
    assert [row["change"] for row in rows] == pytest.approx([-0.1] * len(rows))
    cases = {row["rails"]: row["cases"] for row in rows}
    assert cases["cleaned"] == 1
    assert sum(cases.values()) == len(given_truth.cases_of(16)) > 16
    information, actuation, law, whole = given_truth.loss_rows(32)
    assert (information["of"], information["stopped"]) == (12, 12)
    assert information["mean over the bound"] == actuation["mean over the bound"] == pytest.approx(5 / 80)
    assert law["largest"] == pytest.approx(10 / 80)
    assert (law["share of the loss"], whole["share of the loss"]) == (pytest.approx(0.5), 1.0)
