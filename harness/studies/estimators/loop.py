"""Estimators in the loop: the same laws stop in the same cases with other estimates.

The present estimator of the type test is compared with filters of this study, with their searched noises and outlier
limit, and with the true state, which limits what any estimator can achieve.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
import pandas

from railgrip.api import Scenario
from railgrip.base.arrays import Vector
from railgrip.base.tables import TomlTable
from railgrip.campaign.work import Work
from railgrip.estimators.compiled import CompiledFilter
from railgrip.report.frame import Frame, groups_of
from railgrip.report.statistics import bootstrap_interval, endless, quantile, quantile_interval, relative_change
from railgrip.report.stop import Stop
from railgrip.report.table import ReportTable, with_interval
from railgrip.scenario import schema
from railgrip.simulate.assembly import assemble
from railgrip.simulate.loop.interfaces import Parts, StateEstimator
from railgrip.simulate.loop.loop import Ending, Loop
from railgrip.studies.estimators.replay import OUTLIER_LIMITS, entry_of, noise_of
from railgrip.studies.type_test.case_set import VERSIONS
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of
from railgrip.studies.type_test.stop_frames import EQUAL
from railgrip.studies.type_test.track_case import TrackCase
from railgrip.vehicle.signals import Layout

ESTIMATES: Final = ("present", "fmu", "disturbed", "disturbed, 10 ms", "true state")
"""Estimates of a stop: those of the scenario, of an estimator of the study in every sample or every 10 ms, as on its
recordings, or the truth."""

BEST: Final = "disturbed"
"""Estimator on board with the smallest error on the recordings."""

LAWS: Final = ("slope_seeking", "adhesion_based", "two_maxima")
"""Entrants of the type test with estimates that are compared."""

TABLE_1: Final = ("trapezoid", "sine_sweep", "random")
"""Scenarios of the accepted distances, with ideal sensors and actuation."""
LAWS_OF_TABLE_1: Final = ("adhesion_based", "slope_seeking")
"""Laws that are compared there; the law of two maxima is slope seeking where no rail is cleaned."""
ESTIMATES_OF_TABLE_1: Final = ("present", "disturbed", "true state")


LoopCase = tuple[schema.Scenario, str]
"""The scenario of a stop, with the present estimator, and the estimates that replace those."""


class TrueState:
    """The true state in place of a filter: `railgrip.simulate.loop.interfaces.Filter`.

    Speeds of wheelsets are those that give the true slip with the wheel radii that the estimator assumes.
    """

    def __init__(self, layout: Layout, estimator: StateEstimator) -> None:
        """Take size, start and places of the states from an estimator of the same stop."""
        self._output, self._estimator = layout.output, estimator
        self._radius = np.array(estimator.wheel_radius)
        self.mean, self.covariance = estimator.filter.mean.copy(), 1e-12 * np.eye(estimator.filter.mean.size)
        self.inputs, self.readings = estimator.filter.inputs.copy(), estimator.filter.readings.copy()
        self.selection, self.squared_innovation = np.zeros(self.readings.size), 0.0
        self.outputs: Vector = np.zeros(0)
        """Outputs of the plant, which the loop updates."""

    def advance(self) -> None:
        """Read the outputs of the plant."""
        at, estimator = self._output, self._estimator
        speed = float(self.outputs[at["speed"].start])
        self.mean[estimator.speed] = speed
        self.mean[estimator.wheelset_speed] = (1.0 - self.outputs[at["slip"]]) * speed / self._radius
        self.mean[estimator.adhesion] = self.outputs[at["group_adhesion"]]
        self.mean[estimator.pad_friction] = self.outputs[at["pad_friction"]]


def stop_in_loop(case: LoopCase) -> dict[str, float]:
    """Run a stop with its estimates and return its figures.

    `distance`: infinite without a standstill [m]; `lock`: longest of any group above 15 km/h [s]; `error`: RMS error of
    the estimated adhesion above 10 km/h, mean of the groups; `nees`: mean squared error of adhesion over its variance,
    mean of the groups, NaN for the true state.
    """
    scenario, name = case
    sensors = "ideal" if scenario.sensors.kind == "ideal" else "service"
    with assemble(scenario_of_case(case)) as opened:
        estimator = opened.parts.estimator
        assert isinstance(estimator, StateEstimator)
        if name == "true state":
            truth = TrueState(opened.parts.layout, estimator)
            parts = replace(opened.parts, estimator=replace(estimator, filter=truth))
            return _figures(opened.stop(_run(parts, truth))) | {"nees": math.nan}
        if name != "present":
            assert isinstance(estimator.filter, CompiledFilter)
            noise, design = noise_of(name.partition(",")[0], sensors), estimator.filter.design
            estimator.filter.retune(noise.process_noise(design.states), noise.reading_noise(design.outputs))
        return _figures(opened.stop(opened.run()))


def _run(parts: Parts, truth: TrueState) -> Ending:
    loop = Loop(parts)
    truth.outputs = loop.structs.plant.target("outputs")
    return loop.run()


def _figures(stop: Stop) -> dict[str, float]:
    metrics = stop.figures
    return {
        "distance": endless(stop.braking_distance),
        "lock": metrics.of_train("longest_lock_fast"),
        "error": metrics.of_train("adhesion_rmse"),
        "nees": metrics.of_train("adhesion_nees"),
    }


def scenario_of_case(case: LoopCase) -> schema.Scenario:
    """Return the scenario of a case with the prediction, outlier limit and period of its estimates."""
    scenario, estimates = case
    changes: TomlTable = {}
    if estimates == "true state":
        # It does not use the radar, whose failure would release a group.
        changes["estimator"] = {"free_wheels": False}
    elif estimates != "present":
        name, _, period = estimates.partition(", ")
        model = entry_of(name).model
        changes["estimator"] = {"model": model, "noise": "service", "outlier_limit": dict(OUTLIER_LIMITS)}
        if period:
            changes["periods"] = {"estimator": period}
    return scenario.revised(changes)


def stops_of_type_test(work: Work, count: int) -> Frame:
    """Run the laws in cases of the test set of version 2 of the type test, all on the two-part train."""
    cases = VERSIONS[2].draw(count, VERSIONS[2].test)
    design = [replace(case, train="") if isinstance(case, TrackCase) else case for case in cases]
    # With the numbers of version 1, which are those of the published tables.
    taking_part = {law: (entrants(2) | entrants(1))[law] for law in LAWS}
    stops = campaign_of(design, taking_part, train_of(None)).stops
    rows = [
        (law, name, stop.scenario)
        for law in LAWS
        for name in ESTIMATES
        for stop in stops
        if stop.variants["controller"] == law
    ]
    return _stops(work, rows)


def stops_of_table_1(work: Work) -> Frame:
    """Run the laws of Table 1 in its scenarios, with ideal sensors and actuation."""
    rows = [
        (law, name, Scenario.load(scenario, {"controller.kind": law}))
        for law in LAWS_OF_TABLE_1
        for name in ESTIMATES_OF_TABLE_1
        for scenario in TABLE_1
    ]
    return _stops(work, rows)


def _stops(work: Work, rows: Sequence[tuple[str, str, schema.Scenario]]) -> Frame:
    """Return a row for each stop given by law, estimates and scenario, with these and its figures."""
    results = work.map(stop_in_loop, [(scenario, name) for _, name, scenario in rows])
    return pandas.DataFrame(
        [{"law": law, "estimates": name, **found} for (law, name, _), found in zip(rows, results, strict=True)]
    )


def compare(found: Frame) -> ReportTable:
    """Return distances over those with the present estimates in the same cases, with intervals over the cases.

    Args:
        found: Stops by law and estimates, of each the same cases in the same order; others are refused.
    """
    rows: list[tuple[str | float, ...]] = []
    for (law, name), stops in groups_of(found, ("law", "estimates")):
        pairs = zip(stops["distance"], _present(found, law), strict=True)
        ratios = [1.0 + relative_change(*pair) for pair in pairs]
        rows.append(
            (
                law,
                name,
                f"{np.isfinite(stops['distance']).sum()} of {len(stops)}",
                sum(ratio < 1.0 - EQUAL for ratio in ratios),
                sum(ratio > 1.0 + EQUAL for ratio in ratios),
                with_interval(quantile(ratios, 0.5), quantile_interval(ratios, 0.5), "{:.4f}"),
                with_interval(float(np.exp(np.mean(np.log(ratios)))), _interval_of_mean(ratios), "{:.4f}"),
                max(ratios),
                float(stops["lock"].max()),
                float(np.median(stops["error"])),
                float(np.mean(stops["nees"])),
            )
        )
    forms = dict.fromkeys(("law", "estimates", "stops", "shorter", "longer", "median", "mean"), "{}")
    forms |= {"maximum": "{:.3f}", "longest lock": "{:.2f} s", "RMSE": "{:.4f}", "NEES": "{:.2f}"}
    return ReportTable.of(forms, rows, left=2, title="Distance over that with the present estimates")


def compare_table_1(found: Frame) -> ReportTable:
    """Return the distances of Table 1, and their changes by other estimates."""
    rows: list[tuple[str, ...]] = []
    for (law, name), stops in groups_of(found, ("law", "estimates")):
        cells = [
            f"{distance:.1f} m" + ("" if name == "present" else f" ({distance - before:+.1f} m)".replace("-", "−"))
            for distance, before in zip(stops["distance"], _present(found, law), strict=True)
        ]
        rows.append((law, name, *cells))
    return ReportTable.of(("law", "estimates", *TABLE_1), rows, left=2, title="Table 1")


def _present(found: Frame, law: str) -> Frame:
    return found["distance"][(found["law"] == law) & (found["estimates"] == "present")]


def _interval_of_mean(ratios: Sequence[float]) -> tuple[float, float] | None:
    """Return the percentile bootstrap interval of the geometric mean; None with too few or infinite ratios."""
    if math.isinf(max(ratios)):
        return None
    interval = bootstrap_interval(np.log(ratios), lambda draws: draws.mean(axis=1))
    return None if interval is None else (math.exp(interval[0]), math.exp(interval[1]))
