"""Slope seeking with the truth in place of estimates and valves, and the division of its loss."""

from dataclasses import replace

import numpy as np
import pytest

from railgrip.studies.attribution import LAW, distance_with, losses, scenario_with, table_of
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of
from railgrip.studies.type_test.track_case import HEADLINES

PATCHES = replace(HEADLINES[0], speed=8.0, faults=("radar stuck", "valve slow"))


@pytest.fixture(scope="module")
def scenario():
    return campaign_of([PATCHES], {LAW: entrants(2)[LAW]}, train_of(None)).stops[0].scenario


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
