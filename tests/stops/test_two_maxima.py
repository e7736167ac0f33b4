"""Stops on rails cleaned and heated by slip: two maxima, a balance of energy, and invalid combinations."""

import itertools

import pytest
from maxima_stops import CAUSES, LAWS, energy_error, maxima_of, slide_of, stop_of
from small_train import one_bogie
from wrong import table

import railgrip as rg
from railgrip.base.errors import ScenarioError
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.run import run_stop

COUNTS = {"film alone": 1, "heat": 1, "cleaning": 1, "cleaning and heat": 2}


@pytest.fixture(scope="module")
def stops():
    cases = [(rail, causes, "full brake") for rail, causes in itertools.product(("wet", "leaves"), CAUSES)]
    return {case[:2]: stop_of(*case) for case in cases}


def test_the_train_stops_and_its_energy_becomes_heat_with_each_switch(stops):
    for stop in stops.values():
        assert stop.outcome is Outcome.STANDSTILL
        # Ten times the tolerance of the plant's solver, 1e-5 a step, leaves 1e-7 over a stop.
        assert energy_error(stop) < 1e-6


def test_a_slide_has_two_maxima_only_with_cleaning_and_heat(stops):
    for (_, causes), stop in stops.items():
        peaks = maxima_of(*slide_of(stop))
        assert len(peaks) == COUNTS[causes]
        assert peaks[0] < 0.1
        if causes == "cleaning and heat":
            assert 0.2 < peaks[1] < 0.6


def test_locking_is_shorter_than_not_sliding_only_without_heat(stops):
    """Cleaning alone favours locking: with heat, holding the second maximum is a fifth shorter than locking."""
    for rail in ("wet", "leaves"):
        locked = stops[rail, "cleaning and heat"].metrics.distance
        held = stop_of(rail, "cleaning and heat", "slip of 20 to 30 %").metrics.distance
        assert held < 0.9 * locked


def test_the_name_of_the_creep_curve_is_sufficient():
    """Library scenarios name the curve; the plant, the rail and the bound use it."""
    scenario = rg.Scenario.load("wet_two_maxima", {"limits.horizon": "1 s"})
    assert scenario.adhesion.cleaning is not None
    stop = rg.run(scenario, controller=LAWS["slip of 20 to 30 %"])
    assert stop.metrics.utilisation <= 1.0
    assert float(stop.trace["mu0"].max()) > 0.15


def test_friction_lost_a_kelvin_is_that_of_the_scenario():
    """Where the contacts of the plant had another one, the trial of its creep curve would refuse it."""
    strong, weak = (
        rg.run(
            rg.Scenario.load("wagon", BRAKED | {"adhesion": SLIPPERY | {"polach": CURVE | {"temperature_loss": loss}}})
        )
        for loss in (1.2e-3, 2e-4)
    )
    assert strong.trace["adhesion"].values.sum() < weak.trace["adhesion"].values.sum()


CURVE = {"k_A": 0.3, "k_S": 0.1, "A": 0.4, "B": 0.2}
WARM = {"temperature_loss": 8.3e-4}
SLIPPERY = {"kind": "constant", "mu0": 0.08}
BRAKED = {"limits.horizon": "4 s", "estimator": {"kind": "none"}, "controller": {"kind": "full_brake"}}


@pytest.mark.parametrize(
    ("name", "changes", "has_patch"),
    [
        ("wagon", {}, True),
        ("plain", {"vehicle.plant": None, "vehicle.train": "small.toml"}, False),
        ("plain", {"actuation.kind": "pneumatic", "vehicle.plant": "TwoPartTrainPneumatic"}, False),
    ],
)
def test_heat_lowers_adhesion_in_slides_of_every_train_of_the_library(name, changes, has_patch, tmp_path):
    """Also where curves differ along the track, with the plant that is compiled fastest."""

    if "vehicle.train" in changes:
        (tmp_path / "small.toml").write_text(one_bogie(), encoding="utf-8")
        changes = changes | {"vehicle.train": str(tmp_path / "small.toml")}

    def stop(heat):
        patch = {"begin": "30 m", "length": "200 m", "mu0": 0.06, "polach": CURVE | {"B": 0.3} | heat}
        adhesion = SLIPPERY | {"polach": CURVE | heat, "patch": [patch] if has_patch else []}
        return rg.run(rg.Scenario.load(name, BRAKED | changes | {"adhesion": adhesion}))

    cold, warm = (stop(heat).trace for heat in ({}, WARM))
    slides = (cold["slip"].values > 0.5).any(axis=1)
    assert slides.any()
    ratio = (warm["adhesion"] / cold["adhesion"]).values[slides].min()
    assert 0.4 < ratio < 0.9


@pytest.mark.parametrize(("scenario", "changes", "words"), table(__file__, "tables.toml")["contradicting_curves"])
def test_a_curve_that_contradicts_the_scenario_is_refused(scenario, changes, words):
    with pytest.raises(ScenarioError, match=words):
        run_stop(load(scenario, changes))
