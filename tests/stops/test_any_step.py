"""What the communication step does to a stop."""

import runpy
from pathlib import Path

import numpy as np
from synthetic import LIBRARY

from railgrip.scenario.load import load, scenario_of
from railgrip.scenario.merge import merged, read_overrides
from railgrip.simulate.run import braking_distance

SERVICE = load(LIBRARY / "degraded.toml").resolved()["sensors"]


def distance(step, *overrides, **sensors):
    """Of adhesion-based control with service sensors and ideal actuation [m]."""
    changes = [f"periods.communication={step}", "periods.controller=10 ms", "estimator.noise=service", *overrides]
    table = merged(load(LIBRARY / "plain.toml").resolved(), read_overrides(changes)) | {"sensors": SERVICE | sensors}
    return braking_distance(scenario_of(table, directory=LIBRARY, origin="step"))


def test_half_and_quarter_step_move_a_stop_no_more_than_its_last_digits_do():
    """What those do is the most that six draws of the plant's parameters, moved by 1e-7, move it: some 0.2 %. With
    noise drawn anew for each step it was 0.6 %."""
    full = distance("1 ms")
    nudged = [distance("1 ms", "vehicle.nudge.relative=1e-7", f"vehicle.nudge.seed={seed}") for seed in range(1, 7)]
    last_digits = np.abs(np.array(nudged) / full - 1.0).max()
    moved = np.array([distance(step) / full - 1.0 for step in ("0.5 ms", "0.25 ms")])
    assert np.abs(moved).max() <= last_digits < 3e-3
    assert abs(distance("0.5 ms", period="0.5 ms") / full - 1.0) > 3e-3


def test_half_a_step_moves_stops_of_slope_seeking_by_less_than_a_twentieth_of_a_percent():
    """In the mean over six lots of instruments; its standard error is some 0.012 %, that of 0.03 % of one stop."""
    example = runpy.run_path(str(Path(__file__).parents[2] / "docs/examples/halved_step.py"))
    half = example["moved"]("plain", "slope_seeking", lots=6)["half the step"]
    assert half.size == 6
    assert np.abs(half).max() > 0.0
    assert abs(half.mean()) < 0.05
