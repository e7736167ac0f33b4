"""Stops with other contacts, elastic shafts, hysteresis and an uneven rail, unknown to filter and controller."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import rumoca

import railgrip as rg
from railgrip.base.errors import ScenarioError
from railgrip.scenario.load import scenario_of
from railgrip.scenario.merge import merge
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.track.irregularity import spectrum
from railgrip.studies.two_maxima import energy_error
from railgrip.studies.type_test.case_set import VERSIONS
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of

LIBRARY = Path(__file__).parents[2] / "modelica"
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


@pytest.fixture(scope="module")
def train_file():
    """A train file under a demand that rises and falls, with simple and with detailed mechanics."""
    steps = {"phases": [{"pressure": "1.5 bar", "until": {"duration": "2 s"}}, {"pressure": "0.5 bar"}]}
    table = {"name": "short", "limits": {"horizon": "4 s"}, "demand": steps, "estimator": {"kind": "none"}}
    table |= {"controller": {"kind": "full_brake"}, "adhesion": {"kind": "constant", "mu0": 0.3}}

    def traced(mechanics):
        changed = merge(train_of("vt642"), table | {"truth": {"mechanics": mechanics}})
        return rg.run(scenario_of(changed, directory=Path(), origin="test")).trace

    return {mechanics: traced(mechanics) for mechanics in ("simple", "detailed")}


def test_the_rigging_of_a_train_file_has_hysteresis(train_file):
    """At the same pressure the pad force is 12 % of the mean larger in the release than in the application."""

    def ratio_at(trace, pressure):
        read, force = (trace[name].values[:, 0] for name in ("cylinder_pressure", "pad_force"))
        time = trace["time"].values
        applying, releasing = (time > 0.5) & (time < 1.2), (time > 2.05) & (time < 2.3)
        applied = np.interp(pressure, read[applying], force[applying])
        return float(np.interp(-pressure, -read[releasing], force[releasing]) / applied)

    # 65 kPa below the reversal, of which `p_reverse` is 10 kPa; the recorded samples are linear between each other.
    assert ratio_at(train_file["detailed"], 0.8e5) == pytest.approx(1.06 / 0.94, rel=5e-3)
    assert ratio_at(train_file["simple"], 0.8e5) == pytest.approx(1.0, abs=5e-3)


def test_the_loads_of_a_train_file_vary_on_an_uneven_rail(train_file):
    end = train_file["simple"]["time"].values > 1.0
    simple, detailed = (train_file[name]["wheelset_load"].values[end].std(axis=0) for name in ("simple", "detailed"))
    assert (detailed > 1.2 * simple).all()


def test_the_waves_of_the_rail_have_the_published_spectrum():
    """The mean square of the acceleration is v⁴ ∫ k⁴ S(k) dk with the spectrum of the sensors' irregularity."""
    text = (
        "model Ride RailBraking.Tracks.UnevenRail rail(n=1); Real square(start=0, fixed=true); "
        "equation rail.v = 40; der(square) = rail.acceleration[1]^2; end Ride;"
    )
    model = rumoca.Session(roots=[str(LIBRARY)]).loads(text, model="Ride", filename="Ride.mo")
    result = model.simulate((0, 60), dt=1.0, config=rumoca.SimConfig(solver="rk-like", rtol=1e-6, atol=1e-6))
    found = result["square"][-1] / 60
    frequencies = np.linspace(1 / 125, 1 / 1.25, 20001)
    density = spectrum("erri-high", "vertical", frequencies) * (2 * np.pi * frequencies) ** 4
    expected = 40**4 * np.trapezoid(density, frequencies)
    # Sixteen waves replace the integral; over 2400 m their products average to within a few per cent.
    assert found == pytest.approx(expected, rel=0.05)


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
