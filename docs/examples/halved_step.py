"""Prints what half a communication step does to stops: python docs/examples/halved_step.py [LOTS].

Each lot of instruments stops three times: as it is, with half the step, and with the plant's parameters moved by 1e-7.
"""

import sys
from pathlib import Path

import numpy as np

import railgrip.scenario
from railgrip.scenario.file import merge, read_overrides
from railgrip.scenario.load import read_toml, scenario_of
from railgrip.simulate.run import braking_distance

SCENARIOS = Path(railgrip.scenario.__file__).parent
LAWS = {"slope_seeking": "compiled", "adhesion_based": "compiled", "slip_three_state": "none"}
"""Laws and their kind of estimator."""

CHANGES = {
    "half the step": ("periods.communication=0.5 ms",),
    "moved": ("vehicle.nudge.relative=1e-7", "vehicle.nudge.seed=1"),
}


def distance(rail: str, law: str, lot: int, *changes: str) -> float:
    """Return the distance of a stop from 80 km/h with service sensors and ideal actuation [m], NaN if none."""
    service = read_toml(SCENARIOS / "equipment/service.toml")
    tables = {name: table for name, table in service.items() if name not in ("vehicle", "actuation")}
    train = merge(read_toml(SCENARIOS / f"library/{rail}.toml"), tables)
    overrides = [f"controller.kind={law}", f"estimator.kind={LAWS[law]}", f"seed={lot}", *changes]
    scenario = scenario_of(merge(train, read_overrides(overrides)), directory=SCENARIOS / "library", origin=rail)
    return braking_distance(scenario) or np.nan


def moved(rail: str, law: str, lots: int) -> dict[str, np.ndarray]:
    """Return by how much each change moves the stops of those lots with which the train comes to a stand [%]."""

    def distances(*changes: str) -> np.ndarray:
        return np.array([distance(rail, law, lot, *changes) for lot in range(1, lots + 1)])

    as_it_is = distances()
    change = {name: 100.0 * (distances(*changes) / as_it_is - 1.0) for name, changes in CHANGES.items()}
    return {name: values[np.isfinite(values)] for name, values in change.items()}


if __name__ == "__main__":
    LOTS = int(sys.argv[1]) if len(sys.argv) > 1 else 16
    print("stops, mean with its standard error, and standard deviation of one stop [%]")
    for rail in ("plain", "trapezoid"):
        for law in LAWS:
            for name, change in moved(rail, law, LOTS).items():
                one = np.std(change, ddof=1)
                mean = f"{np.mean(change):+.3f} ± {one / change.size**0.5:.3f}"
                print(f"{rail:10} {law:17} {name:14} {change.size:3}  {mean}  {one:.3f}", flush=True)
