"""The best possible stop is found on any grid, and one that the horizon cuts off says so."""

from pathlib import Path

import pytest

import railgrip.scenario
from railgrip.scenario.load import load, read_toml, scenario_of
from railgrip.scenario.merge import merged
from railgrip.simulate.ideal import ideal_stop
from railgrip.simulate.run import run_stop
from railgrip.trace.metrics import meanings

LIBRARY = Path(railgrip.scenario.__file__).parent / "library"


def bound(name, period, *changes):
    every = [f"periods.{part}={period}" for part in ("communication", "estimator", "controller", "trace")]
    return ideal_stop(
        load(LIBRARY / f"{name}.toml", ["controller.kind=ideal_bound", "estimator.kind=none", *every, *changes])
    )


@pytest.mark.parametrize(("name", "distance"), [("plain", 344.3937), ("sine_sweep", 257.8800)])
def test_the_best_stop_hardly_hangs_on_the_grid(name, distance):
    """Against the distance at 1 ms; the end of the stop is known to a sample, a millimetre of travel at 0.1 m/s."""
    assert bound(name, "10 ms").metrics.distance == pytest.approx(distance, abs=2e-3)


def test_a_braked_wheelset_exceeds_its_share_by_bearing_and_rolling_resistance():
    """Under full brake on a good rail; the bound is what the brakes draw, without these resistances."""
    overrides = ["controller.kind=full_brake", "adhesion.mu0=0.4", "limits.alpha_max=1", "start.speed=40 km/h"]
    stop = run_stop(load(LIBRARY / "plain.toml", ["estimator.kind=none", *overrides]))
    beyond = (stop.trace["group_adhesion"] - stop.trace["brake_limit"]).values
    # Modelica's Components.Wheelsets: mu_bearing r_bearing/r + e_rolling/r.
    resistance = (0.0018 * 0.065 + 0.0004) / 0.38
    # 3 %: slip changes slowly, and a hundredth of the torque goes into that.
    assert beyond[len(beyond) // 4 :: 100] == pytest.approx(resistance, rel=0.03)
    assert max(stop.metrics.utilisation_wheelset) > 1.01
    assert "bearing and rolling resistance" in meanings()["utilisation_wheelset"][1]


def test_a_horizon_that_cuts_off_the_best_stop_is_its_outcome():
    stop = bound("plain", "10 ms", "limits.horizon=20 s")
    assert stop.outcome.value == "horizon"
    assert stop.metrics.duration == pytest.approx(20.0, abs=0.011)


@pytest.mark.parametrize(
    "change",
    [("track.gradient=[{begin=0.0, slope=-0.02}]",), ("truth.gradient=-0.02",)],
    ids=["of the track", "that nobody told"],
)
def test_the_bound_feels_a_gradient_once(change):
    """On even friction the mean deceleration falls by g times the slope."""
    level, falling = bound("plain", "10 ms"), bound("plain", "10 ms", *change)
    lost = level.metrics.mean_deceleration - falling.metrics.mean_deceleration
    # Friction falls with speed, and the slower stop is faster for longer.
    assert lost == pytest.approx(0.02 * 9.81, rel=0.05)


@pytest.mark.parametrize(
    ("curve", "most", "used"), [("dry", 1.05, 0.97), ("soap", 1.05, 0.97), ("poor_wheelset_study", 1.055, 0.965)]
)
def test_who_knows_the_truth_stops_with_valves_within_five_percent_of_the_bound(curve, most, used):
    """The rest is what pressure takes to build up, and valves to follow; a radar that is dead does not matter.

    Where the peak is sharp, valves follow its slip less well. The stop was 14 % longer than the bound there while a
    wheel was led by its slip alone, which the valves' band swallowed.
    """
    equipment = Path(railgrip.scenario.__file__).parent / "equipment" / "service.toml"
    table = merged(read_toml(LIBRARY / "plain.toml"), read_toml(equipment))
    table = merged(
        table,
        {
            "start": {"speed": "40 km/h"}, "adhesion": {"polach": curve}, "estimator": {"kind": "none"},
            "faults": [{"part": "radar", "kind": "zero"}],
        },
    )  # fmt: skip
    bound, tracking = (
        run_stop(scenario_of(merged(table, {"controller": {"kind": kind}}), directory=LIBRARY, origin="test"))
        for kind in ("ideal_bound", "ideal_tracking")
    )
    assert tracking.scenario.controller.kind == "ideal_tracking"
    assert bound.metrics.distance < tracking.metrics.distance < most * bound.metrics.distance
    assert tracking.metrics.utilisation > used
    assert max(tracking.metrics.longest_lock_fast) == 0.0
