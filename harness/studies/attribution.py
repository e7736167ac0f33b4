"""Loss of slope seeking over the ideal bound, divided into those of information, actuation and the law."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from typer import Option

from railgrip.api import Estimate, Observation
from railgrip.campaign.work import Work
from railgrip.report.marked import write_tables
from railgrip.report.page import Page
from railgrip.report.statistics import CONFIDENCE
from railgrip.report.table import ReportTable
from railgrip.scenario.faults import READ_BY
from railgrip.scenario.merge import merge
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.simulate.parts import NO_CUSTOM_PARTS, CustomParts
from railgrip.simulate.run import run_stop
from railgrip.studies.study import Study
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of, training_cases, trains_of
from railgrip.vehicle.formation import Formation

Array = NDArray[np.float64]

PAGE = Path("docs/type_test.md")
"""From the folder of the project, where the command runs."""

LAW = "slope_seeking"
GIVEN = ((False, False), (False, True), (True, False), (True, True))
"""Whether the law is given the truth, and an actuation without valves."""
_READINGS = ("speed", "wheelset_speed", "deflection", "acceleration", "cylinder_pressure")
_RESAMPLES, _SEED = 2000, 8


@dataclass(frozen=True, slots=True)
class TruthSensors:
    """Exact sensors, which leave the true signals for `TruthEstimator`."""

    truth: dict[str, Array] = field(default_factory=dict[str, Array])

    def start(self, formation: Formation, random: np.random.Generator) -> None:
        """Start a stop."""

    def read(self, time: float, truth: Mapping[str, Array]) -> dict[str, Array]:
        """Return the true values."""
        self.truth.update({name: np.copy(value) for name, value in truth.items()})
        return {name: self.truth[name] for name in _READINGS}


class TruthEstimator:
    """The true state in place of estimates. Adhesion is the true force over the load that the law knows."""

    provides: tuple[str, ...] = ("speed", "wheelset_speed", "slip", "adhesion", "pad_friction")

    def __init__(self, truth: dict[str, Array]) -> None:
        """Estimate from signals that the sensors leave."""
        self._truth = truth

    def start(self, first: Observation, formation: Formation) -> None:
        """Start a stop with the loads that the law knows."""
        self._formation = formation
        self._known = np.array([brake.load for brake in formation.brakes])

    def step(self, observation: Observation) -> Estimate:
        """Return the true state."""
        truth = self._truth
        load = self._formation.sum_by_group(truth["wheelset_load"][None, :])[0]
        return Estimate(
            speed=float(truth["speed"]),
            wheelset_speed=truth["wheelset_speed"],
            slip=truth["slip"],
            adhesion=truth["group_adhesion"] * load / self._known,
            pad_friction=truth["pad_friction"],
        )


def scenario_with(scenario: Scenario, *, truth: bool, ideal_actuation: bool) -> Scenario:
    """Return a stop without the faults and valves that the law is relieved of."""
    parts = (*(READ_BY if truth else ()), *(("valve", "supply") if ideal_actuation else ()))
    table = scenario.resolved()
    table["faults"] = [fault for fault in table.get("faults", ()) if fault["part"] not in parts]
    if ideal_actuation:
        vehicle = {"vehicle": {"plant": "TwoPartTrain"}} if "train" not in table["vehicle"] else {}
        table = merge(table, {"actuation": {"kind": "ideal"}, **vehicle})
    return Scenario.model_validate(table)


def distance_with(case: tuple[Scenario, bool, bool]) -> float:
    """Return the distance of a stop whose law is given the truth, an ideal actuation or both [m]; NaN without stop."""
    scenario, truth, ideal_actuation = case
    sensors = TruthSensors()
    objects = CustomParts(sensors=sensors, estimator=TruthEstimator(sensors.truth)) if truth else NO_CUSTOM_PARTS
    stop = run_stop(scenario_with(scenario, truth=truth, ideal_actuation=ideal_actuation), objects=objects)
    return stop.metrics.distance if stop.outcome is Outcome.STANDSTILL else np.nan


def losses(distances: Array) -> dict[str, Array]:
    """Return the parts of the loss of each case over the bound, relative to the bound.

    The loss that information causes is the mean of two differences, with and without valves, as is that of the
    actuation (Shapley 1953), so that their sum does not depend on the order. The rest is the loss of the law.

    Args:
        distances: As it is, with ideal actuation, with the truth, with both, and the bound, shape (n, 5) [m].
    """
    as_is, actuated, informed, both, bound = distances.T
    return {
        "information": 0.5 * ((as_is - informed) + (actuated - both)) / bound,
        "actuation": 0.5 * ((as_is - actuated) + (informed - both)) / bound,
        "law": (both - bound) / bound,
        "all": (as_is - bound) / bound,
    }


def table_of(distances: Array) -> ReportTable:
    """Return mean losses over the bound and their shares of the whole, with bootstrap intervals over the cases."""
    parts = losses(distances)
    draws = np.random.default_rng(_SEED).integers(0, len(distances), (_RESAMPLES, len(distances)))
    tail = 50.0 * (1.0 - CONFIDENCE)

    def with_interval(value: float, of_draws: Array) -> str:
        low, high = np.percentile(of_draws, (tail, 100.0 - tail))
        return f"{100 * value:.1f} % [{100 * low:.1f}, {100 * high:.1f}]"

    rows: list[dict[str, Any]] = []
    for name, values in parts.items():
        means, whole = values[draws].mean(axis=1), parts["all"][draws].mean(axis=1)
        rows.append(
            {
                "loss through": name,
                "mean over the bound": with_interval(values.mean(), means),
                "share of the loss": with_interval(values.mean() / parts["all"].mean(), means / whole),
                "largest": f"{100 * values.max():.1f} %",
            }
        )
    return ReportTable(rows, left=("loss through",))


def cases_table(names: Sequence[str], distances: Array) -> ReportTable:
    """Return the distances of each case."""
    columns = ("as it is", "ideal actuation", "truth", "both", "bound")
    rows = [{"case": name, **dict(zip(columns, row, strict=True))} for name, row in zip(names, distances, strict=True)]
    return ReportTable(rows, dict.fromkeys(columns, "{:.1f} m"), left=("case",))


@dataclass(frozen=True)
class Attribution(Study):
    """Give slope seeking the truth piece by piece, in training cases that have an ideal bound."""

    cases: Annotated[int, Option(min=1, help="Training cases; those with a bound are used.")] = 32
    write: Annotated[bool, Option("--write", help=f"Write the table into {PAGE}.")] = False

    def page(self, work: Work) -> Page:
        """Run the cases, and return the shares of the loss."""
        design = [case for case in training_cases(self.cases, 2) if case.has_bound]
        compared = {name: entrants(2)[name] for name in (LAW, "ideal_bound")}
        stops = campaign_of(design, compared, train_of(None), trains=trains_of(design)).stops
        laws, bounds = stops[::2], stops[1::2]
        runs = [(law.scenario, truth, ideal_actuation) for law in laws for truth, ideal_actuation in GIVEN]
        runs += [(bound.scenario, False, False) for bound in bounds]
        found = np.array(work.map(distance_with, runs))
        distances = np.column_stack([found[: -len(bounds)].reshape(-1, len(GIVEN)), found[-len(bounds) :]])
        stopped = np.isfinite(distances).all(axis=1)
        table = table_of(distances[stopped])
        each = cases_table([law.variants["case"] for law in laws], distances)
        if self.write:
            write_tables(PAGE, {"attribution": f"{int(stopped.sum())} training cases of version 2:\n\n{table}"})
        return Page(
            title="What limits slope seeking",
            question="How much of the loss of slope seeking over the ideal bound is one of information, of actuation "
            "and of the law?",
            answer="The law was given the truth in place of estimates, a pressure without valves, and both.",
            template="studies/attribution.md.jinja",
            values={"table": table, "each": each},
            tables={"attribution.csv": table, "cases.csv": each},
            screen=(table, each),
        )


STUDY = Attribution
