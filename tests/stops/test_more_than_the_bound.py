"""A stop that uses more adhesion than the ideal bound explains it, and one that uses more than the rail has fails."""

from dataclasses import replace

import numpy as np
import pytest

import railgrip as rg
from railgrip.simulate.assembly import assemble
from railgrip.trace.measures import over_the_rail

SLOW = {"start.speed": "8 km/h", "estimator": {"kind": "none"}, "controller": {"kind": "full_brake"}}
RAIL = {"kind": "points", "over": "time", "polach": "dry"}


class Pulled:
    """A plant with another force between its wheels and the rail, a factor on adhesion that no output explains."""

    def __init__(self, plant, layout, factor):
        self._plant, self._factor = plant, factor
        self._places = [layout.output[name] for name in ("adhesion", "group_adhesion")]

    def start(self, inputs):
        return self._with_force(self._plant.start(inputs))

    def step(self, inputs):
        return self._with_force(self._plant.step(inputs))

    def _with_force(self, outputs):
        for place in self._places:
            outputs[place] *= self._factor
        return outputs


def pulled(scenario, factor):
    with assemble(scenario) as whole:
        plant = Pulled(whole.parts.plant, whole.parts.layout, factor)
        whole = replace(whole, parts=replace(whole.parts, plant=plant))
        return whole.stop(whole.run())


def test_a_brake_that_the_bound_does_not_know_is_a_remark():
    """On a dry rail the brakes are the bound, which full braking uses entirely."""
    scenario = rg.Scenario.load("plain", {**SLOW, "adhesion.mu0": 0.6, "limits.alpha_max": 0.5})
    right, wrong = pulled(scenario, 1.0), pulled(scenario, 1.245)
    assert right.outcome is wrong.outcome is rg.Outcome.STANDSTILL
    assert right.metrics.utilisation < 1.002
    assert not any("possible adhesion" in remark for remark in right.remarks)
    assert wrong.metrics.utilisation > 1.2
    (remark,) = [remark for remark in wrong.remarks if "100 % of the possible adhesion" in remark]
    assert "whose torque the plant does not include in brake_torque" in remark
    assert "alpha_max" not in remark
    assert remark in repr(wrong)


def test_a_stop_beyond_the_permitted_adhesion_says_so():
    stop = rg.run(rg.Scenario.load("plain", {**SLOW, "adhesion.mu0": 0.6, "limits.alpha_max": 0.05}))
    assert any("[limits] alpha_max, which groups exceeded" in remark for remark in stop.remarks)


def test_more_adhesion_than_the_rail_has_is_an_error_from_two_thousandths_on():
    """Peak seeking uses most of the rail; larger factors end the stop before, as more friction than mu0."""
    scenario = rg.Scenario.load("plain", {"start.speed": "15 km/h"})
    share = over_the_rail(pulled(scenario, 1.0).trace)
    assert 0.97 < share < 1.0
    assert pulled(scenario, 1.0015 / share).outcome is rg.Outcome.STANDSTILL
    wrong = pulled(scenario, 1.003 / share)
    assert wrong.outcome is rg.Outcome.IMPLAUSIBLE
    assert "100.3 % of the adhesion at the peak of the creep curve" in wrong.reason


@pytest.mark.parametrize("low", [0, 9])
def test_friction_that_changes_within_10_ms_makes_no_right_stop_an_error(low):
    """Sliding wheels use less than the peak at every instant, whatever the friction of the rail over time is."""
    points = [[f"{k} ms", 0.05 if k % 10 == low else 0.1] for k in range(4000)]
    stop = rg.run(rg.Scenario.load("plain", {**SLOW, "adhesion": RAIL | {"points": points}}))
    assert stop.outcome is rg.Outcome.STANDSTILL
    assert 0.5 < over_the_rail(stop.trace) <= 1.0


@pytest.mark.parametrize("controller", ["full_brake", "slope_seeking", "ideal_tracking"])
def test_a_right_stop_on_the_fastest_rail_of_the_library_stays_below_the_limit(controller):
    changes = {"start.speed": "8 km/h", "controller": {"kind": controller}}
    trace = rg.run(rg.Scenario.load("random", changes)).trace
    # Peaks 10 ms apart are wrong by 1e-4 of the impulse on this rail.
    assert over_the_rail(trace) <= 1.0 + 2e-4
    assert np.nanmax(trace["group_adhesion"].values) > 0.0
