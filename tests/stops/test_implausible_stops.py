"""Stops whose numbers could not be: refused, or counted right."""

from pathlib import Path

import pytest

from railgrip.assemble import run_stop
from railgrip.errors import ScenarioError
from railgrip.scenario.load import load
from railgrip.trace.outcome import Outcome

PLAIN = Path("harness/scenario/library/plain.toml")
FULL = ("controller.kind=full_brake", "estimator={kind='none'}", "start.speed=20 km/h")


@pytest.mark.parametrize("changed", ["vehicle.parameters.B_falling=0", "vehicle.parameters.k_A=1"])
def test_a_plant_with_another_creep_curve_has_the_bound_of_that_curve(changed):
    """With friction that does not fall, locked wheels are at the peak: all is used, and not 105 %."""
    stop = run_stop(load(PLAIN, (*FULL, changed)))
    assert stop.outcome is Outcome.STANDSTILL
    assert stop.metrics.utilisation <= 1.0


def test_a_track_that_holds_more_than_the_steepest_gradient_is_refused():
    with pytest.raises(ScenarioError, match=r"\[track\] puts -900000 N on a train of .* kg, but a gradient of 20%"):
        run_stop(load(PLAIN, (*FULL, "track.force=-900 kN")))
