"""Stops with other estimates differ in nothing else, and are compared case by case."""

import math

import numpy as np
import pandas
import pytest

import railgrip as rg
from railgrip.base.errors import InputError
from railgrip.campaign.work import work
from railgrip.simulate.run import run_stop
from railgrip.studies.estimators.estimators_study import Estimators
from railgrip.studies.estimators.loop import (
    ESTIMATES,
    compare,
    compare_table_1,
    scenario_of_case,
    stop_in_loop,
)
from railgrip.studies.type_test.entrants import train_of


@pytest.fixture(scope="module")
def scenario():
    """A short stop with valves and service sensors on a slippery rail."""
    changes = {"start.speed": "25 km/h", "controller.kind": "slope_seeking", "adhesion.mu0": 0.06}
    return rg.Scenario.load(train_of(None), changes)


def test_the_present_estimates_are_those_of_the_scenario(scenario):
    found = stop_in_loop((scenario, "present"))
    stop = run_stop(scenario)
    assert found["distance"] == stop.braking_distance
    assert found["nees"] == pytest.approx(np.mean(stop.figures.adhesion_nees), rel=1e-12)


def test_the_true_state_has_no_error(scenario):
    found = stop_in_loop((scenario, "true state"))
    assert found["error"] == 0.0
    assert 0.0 < found["distance"] < math.inf
    assert math.isnan(found["nees"])


def test_other_estimates_replace_only_the_estimator_and_its_period(scenario):
    for name in ESTIMATES:
        tables = scenario_of_case((scenario, name)).resolved()
        changed = {key for key, value in scenario.resolved().items() if tables[key] != value}
        assert changed <= {"estimator", "periods"}
    searched = stop_in_loop((scenario, "disturbed"))
    assert searched != stop_in_loop((scenario, "present"))


def test_ratios_are_those_of_the_same_cases():
    """Distances scaled by powers of two: the median and the geometric mean are exact, the arithmetic mean is not."""
    distances = {"present": (100.0, 200.0, 300.0), "fmu": (50.0, 200.0, 600.0), "true state": (100.0, 200.0, math.inf)}
    stops = [(name, distance) for name, of_name in distances.items() for distance in of_name]
    found = pandas.DataFrame(stops, columns=["estimates", "distance"]).assign(
        law="law", lock=0.5, error=0.005, nees=1.0
    )
    rows = {row["estimates"]: row for row in compare(found).rows}
    assert rows["present"]["median"] == rows["present"]["mean"] == "1.0000"  # three have no interval
    assert rows["fmu"]["median"] == rows["fmu"]["mean"] == "1.0000"
    assert (rows["fmu"]["shorter"], rows["fmu"]["longer"], rows["fmu"]["maximum"]) == (1, 1, 2.0)
    assert (rows["true state"]["stops"], rows["true state"]["longer"]) == ("2 of 3", 1)
    assert compare_table_1(found).rows[1]["trapezoid"] == "50.0 m (−50.0 m)"


def test_options_that_change_the_cases_are_refused(tmp_path):
    for wrong in (Estimators(loop=True, train="tram"), Estimators(loop=True, estimator=["fmu"])):
        with work("estimators", tmp_path) as job, pytest.raises(InputError, match="leave out other options"):
            wrong.page(job)
    assert Estimators(loop=True).place == "loop"
