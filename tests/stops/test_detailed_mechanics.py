"""Stops of a train with other contacts, elastic shafts and hysteresis, unknown to filter and controller."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import railgrip as rg
from railgrip.base.errors import ScenarioError
from railgrip.scenario.load import scenario_of
from railgrip.scenario.merge import merge
from railgrip.scenario.outcome import Outcome
from railgrip.studies.two_maxima import energy_error
from railgrip.studies.type_test.case_set import VERSIONS
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of

DETAILED = {"truth.mechanics": "detailed"}
SERVICE = {"actuation.kind": "pneumatic", "vehicle.plant": "TwoPartTrainPneumatic", "controller.tuning": "searched"}


@pytest.fixture(scope="module")
def stop_of():
    """Return a function that runs the trapezoid with changes, once for the same ones."""
    return cache(lambda *changes: rg.run(rg.Scenario.load("trapezoid", dict(changes))))


def error_of(stop):
    """Return the RMSE of the estimated adhesion above 3 m/s."""
    trace = stop.trace.isel(time=stop.trace["speed"].values > 3.0)
    return float(np.sqrt(((trace["estimate_adhesion"].values - trace["group_adhesion"].values) ** 2).mean()))


@pytest.mark.parametrize("actuation", [{}, SERVICE])
def test_the_kinetic_energy_becomes_heat(stop_of, actuation):
    stop = stop_of(*(DETAILED | actuation).items())
    assert stop.outcome is Outcome.STANDSTILL
    # The solver's tolerance is 1e-5 per step; the oscillating shafts cause thousands of steps in a stop, with errors of
    # either sign.
    assert energy_error(stop) < 1e-5


def test_the_estimator_keeps_its_prediction_and_errs_more(stop_of):
    simple, detailed = (stop_of(*(changes | SERVICE).items()) for changes in ({}, DETAILED))
    assert abs(detailed.metrics.distance / simple.metrics.distance - 1) > 0.01
    assert error_of(detailed) > error_of(simple)


def test_heated_contacts_keep_their_law_on_elastic_shafts():
    stop = rg.run(rg.Scenario.load("wet_two_maxima", {**DETAILED, "limits.horizon": "1 s"}))
    assert stop.metrics.utilisation <= 1.0


def test_a_train_file_has_detailed_mechanics():
    table = {"name": "short", "truth": {"mechanics": "detailed"}, "limits": {"horizon": "1 s"}}
    stop = rg.run(scenario_of(merge(train_of("vt642"), table), directory=Path(), origin="test"))
    assert float(stop.trace["speed"].values[-1]) < float(stop.trace["speed"].values[0])


def test_a_plant_without_these_parts_is_refused():
    with pytest.raises(ScenarioError, match=r"mechanics = 'detailed' needs the two-part train"):
        rg.run(rg.Scenario.load("foreign_train", DETAILED))


def test_cases_of_the_type_test_are_detailed_only_with_a_suitable_plant():
    design = [case for case in VERSIONS[2].draw(24, VERSIONS[2].test) if case.mechanics == "detailed"]
    assert 2 <= len(design) <= 8  # 24 draws with probability 0.2: outside with probability 0.1
    one = {"fuzzy_slip": entrants(2)["fuzzy_slip"]}
    for argument, expected in ((None, "detailed"), ("foreign_train", "simple")):
        train = train_of(argument)
        stops = campaign_of(design, one, train, trains={}).stops
        assert {stop.scenario.truth.mechanics for stop in stops} == {expected}
