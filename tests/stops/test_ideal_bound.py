"""The best possible stop is found on any grid, and one that the horizon cuts off says so."""

from pathlib import Path

import pytest

import railgrip.scenario
from railgrip.ideal import ideal_stop
from railgrip.scenario.load import load

LIBRARY = Path(railgrip.scenario.__file__).parent / "library"


def bound(name, period, *changes):
    every = [f"periods.{party}={period}" for party in ("communication", "estimator", "controller", "trace")]
    return ideal_stop(
        load(LIBRARY / f"{name}.toml", ["controller.kind=ideal_bound", "estimator.kind=none", *every, *changes])
    )


@pytest.mark.parametrize(("name", "distance"), [("plain", 344.3937), ("sine_sweep", 257.8800)])
def test_the_best_stop_hardly_hangs_on_the_grid(name, distance):
    """Against the distance at 1 ms; the end of the stop is known to a sample, a millimetre of travel at 0.1 m/s."""
    assert bound(name, "10 ms").metrics.distance == pytest.approx(distance, abs=2e-3)


def test_a_horizon_that_cuts_off_the_best_stop_is_its_outcome():
    stop = bound("plain", "10 ms", "limits.horizon=20 s")
    assert stop.outcome.value == "horizon"
    assert stop.metrics.duration == pytest.approx(20.0, abs=0.011)


def test_the_bound_feels_a_gradient_once():
    """On even friction the mean deceleration falls by g times the slope."""
    level, falling = (
        bound("plain", "10 ms", f"track.gradient=[{{begin=0.0, slope={slope}}}]", "track.train_mass=84 t")
        for slope in (0.0, -0.02)
    )
    lost = level.metrics.mean_deceleration - falling.metrics.mean_deceleration
    # Friction falls with speed, and the slower stop is faster for longer.
    assert lost == pytest.approx(0.02 * 9.81, rel=0.05)
