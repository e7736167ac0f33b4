"""What the communication step does to a stop."""

import numpy as np
from synthetic import LIBRARY

from railgrip.assemble import braking_distance
from railgrip.scenario.load import load, scenario_of
from railgrip.scenario.merge import merged, read_overrides

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
