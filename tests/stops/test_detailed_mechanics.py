"""Stops with other contacts, elastic shafts, hysteresis and an uneven rail, unknown to filter and controller."""

import tomllib
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import rumoca
from maxima_stops import energy_error
from small_train import without_command

import railgrip as rg
from railgrip.base.errors import ScenarioError
from railgrip.base.registry import shelf
from railgrip.base.units import GRAVITY
from railgrip.scenario.file import merge
from railgrip.scenario.load import scenario_of
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.track_geometry import spectrum
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
    """On the wagon, whose FMU is built in half of the time of the two-part train."""
    adhesion = {"kind": "constant", "polach": "wet_two_maxima", "mu0": 0.05}
    changes = {**DETAILED, "adhesion": adhesion, "limits.horizon": "3 s"}
    stop = rg.run(rg.Scenario.load("wagon", changes), controller="full_brake")
    assert float(stop.trace["slip"].max()) > 0.25  # where the second maximum is
    assert stop.metrics.utilisation <= 1.0


@pytest.fixture(scope="module")
def train_file(tmp_path_factory):
    """A train file under a demand that rises and falls at once, with simple and with detailed mechanics.

    Its pressure follows in 0.1 s. tests/stops/test_trains_in_files.py has the same class, which is built once.
    """
    text = shelf("trains")["vt642"].read_text(encoding="utf-8")
    file = tmp_path_factory.mktemp("direct") / "direct.toml"
    file.write_text(without_command(text), encoding="utf-8")
    steps = {"phases": [{"pressure": "1.5 bar", "until": {"duration": "2 s"}}, {"pressure": "0.5 bar"}]}
    table = {"name": "short", "limits": {"horizon": "4 s"}, "demand": steps, "estimator": {"kind": "none"}}
    table |= {"controller": {"kind": "full_brake"}, "adhesion": {"kind": "constant", "mu0": 0.3}}
    table |= {"actuation": {"kind": "ideal"}, "vehicle": {"parameters": {"T_pressure": "0.1 s"}}}

    def traced(mechanics):
        changed = merge(train_of(str(file)), table | {"truth": {"mechanics": mechanics}})
        return rg.run(scenario_of(changed, directory=Path(), origin="test")).trace

    return {mechanics: traced(mechanics) for mechanics in ("simple", "detailed")}


def test_the_rigging_of_a_train_file_has_hysteresis(train_file):
    """At the same pressure the pad force is 12 % of the mean larger in the release than in the application."""

    def ratio_at(trace, pressure):
        read, force = (trace[name].values[:, 0] for name in ("cylinder_pressure", "pad_force"))
        time = trace["time"].values
        applying, releasing = (time > 0.05) & (time < 0.3), (time > 2.05) & (time < 2.3)
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


VARIANTS = """package Variants
  block Uneven
    extends RailBraking.Plants.TwoPartTrain(redeclare block TrainRail = RailBraking.Tracks.UnevenRail);
  end Uneven;
  block Elastic
    extends RailBraking.Plants.Wagon(redeclare block TrainShaft = RailBraking.Components.ElasticShaft);
  end Elastic;
end Variants;
"""
"""The two-part train with one part in more detail, and the wagon, which is compiled faster, with another."""


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The file of the variants."""
    file = tmp_path_factory.mktemp("library") / "Variants.mo"
    file.write_text(VARIANTS)
    return str(file)


@pytest.fixture(scope="module")
def full_brake_of(library):
    """Return a function that brakes a variant of the two-part train, or the plain one, without slide protection."""

    @cache
    def stop(variant, *changes):
        scenario = rg.Scenario.load("plain", {**SERVICE, "estimator.kind": "none", **dict(changes)})
        if variant != "Plain":
            scenario = scenario.with_plant({"model": f"Variants.{variant}", "library": library})
        return rg.run(scenario, controller="full_brake")

    return stop


DRY = ("adhesion.mu0", 0.3)
IDEAL = {"actuation.kind": "ideal", "vehicle.plant": "TwoPartTrain"}


@pytest.mark.parametrize("parameter", [("hysteresis", 0.06), ("p_seal", 5e3)])
def test_friction_of_rigging_and_seal_lengthens_a_dry_stop(full_brake_of, parameter):
    """Friction takes a share of the pad force of an applied brake; running resistance and filling keep theirs."""
    name, value = parameter
    frictionless = full_brake_of("Plain", DRY)
    stop = full_brake_of("Plain", DRY, (f"vehicle.parameters.{name}", value))
    force, without = (float(of.trace["pad_force"].values.max()) for of in (stop, frictionless))
    assert force < without
    assert 1.0 < stop.metrics.distance / frictionless.metrics.distance < without / force + 0.01


def test_elastic_shafts_do_not_change_a_dry_stop(library):
    plain = rg.Scenario.load("wagon", {"adhesion": {"kind": "constant", "polach": "dry", "mu0": 0.3}})
    own = plain.with_plant({"model": "Variants.Elastic", "library": library})
    rigid, elastic = (rg.run(scenario, controller="full_brake").metrics.distance for scenario in (plain, own))
    assert elastic == pytest.approx(rigid, rel=1e-4)


def test_wheels_slip_more_where_an_uneven_rail_unloads_them(full_brake_of):
    """Near the peak of the creep curve a smaller load requires more slip for the same force."""
    fast = (("start.speed", "160 km/h"), ("adhesion.mu0", 0.15), ("limits.horizon", "8 s"), *IDEAL.items())
    even, uneven = (full_brake_of(variant, *fast) for variant in ("Plain", "Uneven"))
    load, slip = (
        np.stack([stop.trace[name].values[300:] for stop in (even, uneven)]) for name in ("wheelset_load", "slip")
    )
    assert (load[1].min(axis=0) < 0.95 * load[0].min(axis=0)).all()
    assert (slip[1].max(axis=0) > slip[0].max(axis=0)).all()


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


@pytest.fixture(scope="module")
def locomotive(tmp_path_factory):
    """Return a stop of half of the six-axle locomotive on one bogie, with detailed mechanics, on a dry rail."""
    text = shelf("trains")["loco_coaches"].read_text(encoding="utf-8")
    only = text[: text.index('[[cars]]\nname = "Bpmz-1"')].replace('\ncoupler = "screw"\n', "\n")
    halves = (('mass = "114 t"', 'mass = "57 t"'), (', { kind = "locomotive", at = "14.55 m" }', ""))
    for whole, half in halves:
        assert whole in only
        only = only.replace(whole, half)
    file = tmp_path_factory.mktemp("train") / "locomotive.toml"
    file.write_text(without_command(only), encoding="utf-8")
    assert len(tomllib.loads(text)["bogies"]["locomotive"]["axles"]) == 3
    phases = [{"pressure": "3.4 bar", "until": {"duration": "6 s"}}, {"pressure": "0 bar"}]
    changes = {"name": "locomotive", "vehicle": {"train": str(file)}, "truth": {"mechanics": "detailed"}}
    changes |= {"start": {"speed": "120 km/h"}, "limits": {"horizon": "16 s"}, "demand": {"phases": phases}}
    changes |= {"estimator": {"kind": "none"}, "controller": {"kind": "full_brake"}}
    changes |= {"adhesion": {"kind": "constant", "mu0": 0.3}, "actuation": {"kind": "ideal"}}
    changes |= {"sensors": {"kind": "ideal"}}
    return rg.run(scenario_of(merge(train_of(str(file)), changes), directory=Path(), origin="test"))


def test_the_loads_of_three_axles_return_to_their_static_values(locomotive):
    """Without a force on the pattern +1, -2, +1 of the deflections of a bogie, they must not drift apart."""
    trace = locomotive.trace
    time, load = trace["time"].values, trace["wheelset_load"].values
    static = 57e3 * GRAVITY / 3
    assert (load > 0.5 * static).all()
    released = load[time > 9.0]
    # The mean over 7 s and some 200 m of rail: waves up to 125 m change the load by 5 % of it, with either sign.
    assert released.mean(axis=0) == pytest.approx(static, rel=5e-3)
    assert load[(time > 2.0) & (time < 6.0)].sum(axis=1).mean() == pytest.approx(3 * static, rel=5e-3)
    # Least squares line through the released part: a drift of 1 kN/s would be seen at once.
    slope = np.polyfit(time[time > 9.0], released, 1)[0]
    assert np.abs(slope).max() < 1e3


def test_the_energy_of_three_axles_on_an_uneven_rail_closes(locomotive):
    assert energy_error(locomotive) < 1e-5
