"""Laws with the truth in place of estimates and valves, and of the rail; the division of the loss, and the gains."""

from dataclasses import replace

import numpy as np
import pytest

from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.attribution import (
    AS_IS,
    ENTRANTS,
    LAW,
    distance_with,
    gains_of,
    gains_table,
    informed_distance,
    losses,
    scenario_with,
    table_of,
    without_dead_time,
)
from railgrip.studies.type_test.entrants import campaign_of, train_of, training_cases
from railgrip.studies.type_test.track_case import HEADLINES

PATCHES = replace(HEADLINES[0], speed=8.0, faults=("radar stuck", "valve slow"))


def scenario_of(case, law=LAW):
    return campaign_of([case], {law: ENTRANTS[law]}, train_of(None)).stops[0].scenario


@pytest.fixture(scope="module")
def scenario():
    return scenario_of(PATCHES)


def test_faults_go_with_the_parts_that_are_replaced(scenario):
    def faults(**given):
        return [fault.part for fault in scenario_with(scenario, **given).faults]

    assert faults(truth=False, ideal_actuation=False) == ["radar", "valve"]
    assert faults(truth=True, ideal_actuation=False) == ["valve"]
    assert faults(truth=False, ideal_actuation=True) == ["radar"]
    assert scenario_with(scenario, truth=False, ideal_actuation=True).actuation.kind == "ideal"


def test_a_law_that_is_given_the_truth_stops(scenario):
    # The law seeks by exact signals: the distance is near that of the stop with estimates.
    informed, as_is = (distance_with((scenario, truth, True)) for truth in (True, False))
    assert informed == pytest.approx(as_is, rel=0.2)


def test_the_parts_of_a_loss_add_up_to_it():
    distances = np.array([[120.0, 110.0, 112.0, 104.0, 100.0], [102.0, 101.0, 101.0, 100.5, 100.0]])
    parts = losses(distances)
    assert parts["information"][0] == pytest.approx(0.07)
    assert parts["actuation"][0] == pytest.approx(0.09)
    assert sum(parts[name] for name in ("information", "actuation", "law")) == pytest.approx(parts["all"])
    table = table_of(distances)
    assert [row["largest"] for row in table.rows] == ["7.0 %", "9.0 %", "4.0 %", "20.0 %"]


def test_on_an_even_rail_the_adhesion_ahead_changes_nothing():
    even = scenario_of(replace(PATCHES, rail="even", faults=()))
    assert informed_distance(even, "adhesion ahead") == pytest.approx(distance_with((even, False, False)), rel=1e-9)


@pytest.mark.parametrize("knowledge", ["slip of the peak", "deep slip once compared"])
def test_a_law_that_knows_the_rail_stops(knowledge):
    case = scenario_of(replace(HEADLINES[2], speed=8.0), "two_maxima")
    assert informed_distance(case, knowledge) == pytest.approx(distance_with((case, False, False)), rel=0.3)


def test_deep_slip_from_the_start_is_shorter_where_slip_cleans_the_rail():
    cleaned = replace(HEADLINES[2], speed=12.0)
    assert informed_distance(scenario_of(cleaned, "two_maxima"), "deep slip") < distance_with(
        (scenario_of(cleaned), False, False)
    )


def test_valves_without_dead_time_are_those_of_plant_and_law(scenario):
    vehicle = VehicleData(without_dead_time(scenario))
    for data in (vehicle.true, vehicle.nominal):
        assert data.valves["dead_fill"] == data.valves["dead_vent"] == 0.0


def test_gains_are_means_over_the_cases_that_stop():
    distances = {
        LAW: {AS_IS: np.array([100.0, 100.0, 200.0]), "a piece": np.array([90.0, np.nan, 198.0])},
        "another": {AS_IS: np.array([100.0, 50.0, 50.0]), "a piece": np.array([100.0, 50.0, 49.0])},
    }
    (row,) = gains_table(np.array([True, True, False]), distances).rows
    assert row == {
        "given": "a piece",
        f"{LAW}, 2 cleaned rails": "−10.0 % (1 of 2 cases)",
        f"{LAW}, 1 other rails": "−1.0 %",
        "another, 2 cleaned rails": "+0.0 %",  # two cases have no interval
        "another, 1 other rails": "−2.0 %",
    }


def test_gains_have_all_training_cases_those_of_further_parts_included():
    """A law that stops 10 % earlier with each piece of truth: the table has this for all rows and kinds of rails."""

    class Stops:
        def map(self, function, runs):
            return [100.0 if piece == AS_IS else 90.0 for _, piece in runs]

    design = training_cases(16, 2)
    assert len(design) > 16
    rows = gains_of(Stops(), design).rows
    assert {text for row in rows for column, text in row.items() if column != "given"} == {"−10.0 %"}
