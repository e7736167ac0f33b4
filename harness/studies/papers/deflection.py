"""Braking distances with and without the deflections Δz of the primary suspension in the filter.

Schwarz, Posielek and Goetjes (2021), section 2: deflections are readings (6) and states of the prediction (7), but the
estimator does not necessarily need their readings.
"""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from railgrip.api import Scenario
from railgrip.campaign.work import Work
from railgrip.report.table import ReportTable
from railgrip.simulate.run import run_stop
from railgrip.studies.papers.table1 import SCENARIOS

LAWS: Final[Mapping[str, str]] = {"adhesion_based": "peak seeking (railgrip)", "slope_seeking": "slope-seeking control"}
"""Kind of controller → its name in the table."""

FILTERS: Final[Mapping[str, Mapping[str, Any]]] = {
    "Δz predicted and read": {"estimator.model": "TrainPrediction"},
    # The filter rejects readings that deviate by more than this number of standard deviations: all deflections.
    "Δz predicted, not read": {"estimator.model": "TrainPrediction", "estimator.outlier_limit": {"deflection": 1e-9}},
    "no Δz: static loads": {"estimator.model": "TrainPredictionReduced"},
}
"""Filter → changes of the scenario that select it."""


def deflections(work: Work) -> dict[str, dict[str, dict[str, list[float]]]]:
    """Return distance [m] and rms error of the estimated adhesion, by law, filter and scenario; equipment is ideal."""
    cases = [(law, name, scenario) for law in LAWS for name in FILTERS for scenario in SCENARIOS]
    found: dict[str, dict[str, dict[str, list[float]]]] = {}
    for (law, name, scenario), result in zip(cases, work.map(_stop, cases), strict=True):
        found.setdefault(law, {}).setdefault(name, {})[scenario] = result
    return found


def _stop(case: tuple[str, str, str]) -> list[float]:
    law, name, scenario = case
    metrics = run_stop(Scenario.load(scenario, {"controller.kind": law, **FILTERS[name]})).metrics
    errors = metrics.adhesion_rmse
    if errors is None:
        raise ValueError(f"{scenario} with {law} and a filter '{name}' has no estimates of adhesion")
    return [metrics.distance, float(np.sqrt(np.mean(np.square(errors))))]


def deflection_table(found: Mapping[str, Mapping[str, Mapping[str, list[float]]]]) -> ReportTable:
    """Return distance, change against the filter that reads deflections, and rms error; see `deflections`."""
    rows: list[tuple[str, ...]] = []
    columns: dict[str, None] = {}
    for law, filters in found.items():
        first, *_ = filters.values()
        columns |= dict.fromkeys(first)
        for name, scenarios in filters.items():
            cells = [
                f"{distance:.1f} m"
                + ("" if scenarios is first else f" ({distance - first[scenario][0]:+.1f} m)".replace("-", "−"))
                + f", {error:.4f}"
                for scenario, (distance, error) in scenarios.items()
            ]
            rows.append((f"{LAWS[law]}: {name}", *cells))
    return ReportTable.of(("distance, rms error of adhesion", *(name.replace("_", " ") for name in columns)), rows)
