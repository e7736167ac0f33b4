"""A runner without FMUs: braking depends on the scenario's seed; worker processes of a campaign can import it."""

import time
from pathlib import Path

from synthetic import COARSE, LIBRARY, stop_of

from railgrip.base.errors import ScenarioError
from railgrip.report.stop import Stop
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario

DECELERATION = {
    "full_brake": 0.5,
    "slip_two_state": 0.8,
    "slip_three_state": 0.85,
    "adhesion_based": 0.95,
    "slope_seeking": 0.96,
    "adhesion_literal": 0.9,
    "ideal_bound": 1.0,
}


def stop_with(*overrides: str) -> Stop:
    """Return the coarse stop of the scenario `trapezoid` with these overrides."""
    return run_stop(load(LIBRARY / "trapezoid.toml", [*COARSE, *overrides]))


def run_stop(scenario: Scenario, progress=None, notify=None):
    """Brake at the controller's deceleration; the scenario's description may request a failure."""
    if progress is not None:
        progress(scenario.start.speed / 2)
    match scenario.description.split():
        case ["refuse"]:
            raise ScenarioError(f"{scenario.name}: the plant has no brakes")
        case ["break"]:
            raise RuntimeError("a mistake of the program")
        case ["slide"]:
            return stop_of(scenario, 0.4, Outcome.HORIZON, "Still moving at 3 m/s.")
        case ["wait", marker]:
            # Signal the start, then run longer than any test waits.
            Path(marker).touch()
            time.sleep(3600)
    return stop_of(scenario, DECELERATION[scenario.controller.kind])
