"""Errors of the filters of the two-part train and their claimed deviations, under each load and each fault."""

from typing import Any

import numpy as np

import railgrip as rg
from railgrip.base.registry import shelf
from railgrip.estimation.judgement import rms
from railgrip.report.baseline import Finding, mean
from railgrip.scenario.file import merge
from railgrip.scenario.load import read_toml
from railgrip.studies.type_test.design import FAULTS
from railgrip.trace.measures import SLOWEST

FILTERS: dict[str, dict[str, Any]] = {
    "disturbed": {"model": "TrainPredictionDisturbed"},
    "disturbed, load ±10 %": {"model": "TrainPredictionDisturbed", "load_deviation": 0.1},
    "loaded": {"model": "TrainPredictionLoaded"},
}
"""Filters by their assumption on the load: nominal, uncertain, or estimated."""

_SERVICE = read_toml(shelf("equipment")["service"])


def errors_of(scenario: str, load: float, fault: str, seed: int, filter: str) -> dict[str, float]:
    """Run a stop under slip control without estimates, so that no filter affects it; return the errors of adhesion.

    Args:
        scenario: Name of the rail.
        load: Mass relative to the assumed one.
        fault: Key of the faults of the type test.
        seed: Seed of sensors and rail.
        filter: Key of `FILTERS`.

    Returns:
        RMS error and mean of estimate minus truth, and the mean squared error over variance (NEES), over all groups
        above 10 km/h.
    """
    changes = merge({"estimator": FILTERS[filter], "truth.load": load, "seed": seed}, FAULTS[fault])
    case = rg.Scenario.load(scenario, _SERVICE).changed(changes).replaced({"controller": {"kind": "slip_three_state"}})
    trace = rg.run(case).trace
    moving = trace["speed"].values > SLOWEST
    error = (trace["estimate_adhesion"].values - trace["group_adhesion"].values)[moving]
    squares = (error / trace["estimate_adhesion_sd"].values[moving]) ** 2
    return {"rmse": rms(error), "bias": float(np.mean(error)), "nees": float(np.mean(squares))}


def headlines() -> list[Finding]:
    """Return the errors of two filters in a train that is lighter by a fifth, for the regression."""
    lighter = {"scenario": "trapezoid", "load": 0.8, "fault": "none", "seed": 1}
    frame = rg.evaluate(errors_of, [lighter | {"filter": name} for name in ("disturbed", "loaded")])
    return [mean(f"{stop.filter}, a fifth lighter: adhesion RMSE", stop.rmse) for stop in frame.itertuples()]
