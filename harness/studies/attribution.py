"""Loss of slope seeking over the ideal bound by its causes, and what knowledge of the rail would gain."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import log
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from typer import Option

from railgrip.api import Estimate
from railgrip.base.arrays import Array
from railgrip.campaign.work import Work
from railgrip.controllers.law import Law
from railgrip.controllers.observation import Observation
from railgrip.report.page import Page
from railgrip.report.statistics import bootstrap_interval
from railgrip.report.table import ReportTable, with_interval, write_tables
from railgrip.scenario.faults import READ_BY
from railgrip.scenario.schema import Scenario
from railgrip.simulate.assembly import StopAssembly, assemble
from railgrip.simulate.ideal import KnownRail
from railgrip.simulate.run import run_stop
from railgrip.simulate.user_parts import NO_CUSTOM_PARTS, CustomParts
from railgrip.studies.study import Study
from railgrip.studies.type_test.case_set import AnyCase
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of, training_cases, trains_of
from railgrip.studies.type_test.track_case import BY_THE_CURVE
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.parameters import VALVES

Knowledge = Literal["deep slip", "deep slip once compared", "slip of the peak", "adhesion ahead"]
"""Pieces of the truth of the rail: that deep slip pays, from the start or from the first comparison of groups on, the
best slip, and the adhesion that a command will meet."""

_PERIOD = 0.04  # s, between two looks at the rail: friction of scenarios changes over tenths of a second
_AHEAD = 0.15  # s, until a command takes effect: dead time and part of the filling
_SLOWEST = 0.5  # m/s, below which a law does not seek slip


class InformedLaw:
    """A built-in law that seeks slip and is given a piece of the truth at every decision.

    With deep slip, the law of two maxima is in deep slip from the start, or from the time on at which it first compares
    a group behind with the first one. With the slip of the peak, the set point is its mean over the groups, without
    dither. With the adhesion ahead, the estimate is multiplied by the ratio of the peak that a command will meet to the
    present one. Peaks are those of the rail that no slip has cleaned.
    """

    def __init__(self, stop: StopAssembly, knowledge: Knowledge) -> None:
        """Give the law of a stop a piece of the truth."""
        law = stop.parts.controller
        assert isinstance(law, Law), "only laws of one formula have states by name"
        self._law, self._knowledge, self.needs = law, knowledge, law.needs
        self._rail, self._recorder, self._due = KnownRail(stop.vehicle), stop.recorder, 0.0
        self._rail.time = _AHEAD
        self._period = stop.vehicle.scenario.periods.communication
        self._slip = self._change = np.ones(stop.vehicle.formation.groups)
        self._states = [variable.name for variable in law.formula.states]
        self._is_deep = knowledge == "deep slip"
        if knowledge == "slip of the peak":
            law.parameters[[variable.name for variable in law.formula.parameters].index("dither")] = 0.0

    def decide(self, observation: Observation) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa]."""
        if self._knowledge.startswith("deep slip"):
            self._is_deep = self._is_deep or self._law.state[self._states.index("advantage")] != 0.0
            if self._is_deep:
                self._law.state[self._states.index("deep")] = 1.0
            return self._law.decide(observation)
        row, at = self._recorder.rows[round(observation.time / self._period)], self._recorder.columns
        speed, distance = float(row[at["speed"]][0]), float(row[at["distance"]][0])
        if observation.time >= self._due and speed > _SLOWEST:
            self._due = observation.time + _PERIOD
            self._slip, _, self._change = self._rail.look(observation.time, distance, speed, row[at["wheelset_load"]])
        if self._knowledge == "slip of the peak":
            self._law.state[self._states.index("set_point")] = log(float(np.mean(self._slip)))
            return self._law.decide(observation)
        assert observation.adhesion is not None, "the law needs an estimate of adhesion"
        return self._law.decide(observation._replace(adhesion=observation.adhesion * self._change))


def informed_distance(scenario: Scenario, knowledge: Knowledge) -> float:
    """Return the distance of a stop whose law is given a piece of the truth [m]; NaN without standstill."""
    with assemble(scenario) as stop:
        stop = replace(stop, parts=replace(stop.parts, controller=InformedLaw(stop, knowledge)))
        return stop.stop(stop.run()).metrics.distance


def without_dead_time(scenario: Scenario) -> Scenario:
    """Return a stop whose valves, and the law's model of them, have no dead time."""
    dead = {name: "0 s" for name in VALVES if name.startswith("dead")}
    return scenario.revised({"vehicle": {"parameters": dead}, "controller": {"parameters": dead}})


PAGE = Path("docs/type_test.md")
"""From the folder of the project, where the command runs."""

LAW = "slope_seeking"
LAWS = (LAW, "two_maxima")
ENTRANTS = entrants(2) | entrants(1)
"""Entrants with the numbers of version 1: those of version 2 are for valves alone."""
GIVEN = ((False, False), (False, True), (True, False), (True, True))
"""Whether the law is given the truth, and an actuation without valves."""
_READINGS = ("speed", "wheelset_speed", "deflection", "acceleration", "cylinder_pressure")


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
    tables = scenario.tables()
    changes: dict[str, Any] = {"faults": [fault for fault in tables.get("faults", ()) if fault["part"] not in parts]}
    if ideal_actuation:
        changes["actuation"] = {"kind": "ideal"}
        if "train" not in tables["vehicle"]:
            changes["vehicle"] = {"plant": "TwoPartTrain"}
    return scenario.revised(changes)


def distance_with(case: tuple[Scenario, bool, bool]) -> float:
    """Return the distance of a stop whose law is given the truth, an ideal actuation or both [m]; NaN without stop."""
    scenario, truth, ideal_actuation = case
    sensors = TruthSensors()
    objects = CustomParts(sensors=sensors, estimator=TruthEstimator(sensors.truth)) if truth else NO_CUSTOM_PARTS
    stop = run_stop(scenario_with(scenario, truth=truth, ideal_actuation=ideal_actuation), objects=objects)
    return stop.metrics.distance


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
    rows = [
        {
            "loss through": name,
            "mean over the bound": _mean(values, "{:.1f}"),
            "share of the loss": _with_interval(np.column_stack([values, parts["all"]]), _ratio_of_means, "{:.1f}"),
            "largest": f"{100 * values.max():.1f} %",
        }
        for name, values in parts.items()
    ]
    return ReportTable(rows, left=("loss through",))


def _ratio_of_means(draws: Array) -> Array:
    return np.divide(*np.moveaxis(draws.mean(axis=-2), -1, 0))


def _mean(values: Array, form: str) -> str:
    finite = values[np.isfinite(values)]
    mean = _with_interval(finite, lambda draws: draws.mean(axis=-1), form) if len(finite) else "no stop"
    return mean if len(finite) == len(values) else f"{mean} ({len(finite)} of {len(values)} cases)"


def gains_table(cleans: NDArray[np.bool_], distances: Mapping[str, Mapping[str, Array]]) -> ReportTable:
    """Return the mean change of the distance by each piece of truth, with bootstrap intervals over the cases.

    Args:
        cleans: Whether slip cleans the rail of each case strongly, shape (n,).
        distances: Law → piece → distance of each case [m], NaN without standstill; `AS_IS` is the law as it is.
    """
    rows = [
        {"given": piece}
        | {
            f"{law}, {members.sum()} {kind} rails": _mean((of_piece[piece] / of_piece[AS_IS] - 1.0)[members], "{:+.1f}")
            for law, of_piece in distances.items()
            for kind, members in (("cleaned", cleans), ("other", ~cleans))
        }
        for piece in distances[LAW]
        if piece != AS_IS
    ]
    return ReportTable(rows, left=("given",))


def _with_interval(cases: Array, statistic: Callable[[Array], Array], form: str) -> str:
    """Return a statistic of the cases in percent, with its bootstrap interval if there are enough cases."""
    in_percent = lambda draws: 100 * statistic(draws)  # noqa: E731
    return with_interval(float(in_percent(cases)), bootstrap_interval(cases, in_percent), form, " %")


AS_IS = "nothing"
_OF_THE_RAIL: Sequence[Knowledge] = ("slip of the peak", "adhesion ahead")
_DECISIONS: Sequence[Knowledge] = ("deep slip", "deep slip once compared")
"""The better one of deep slip, in the law of two maxima, and slope seeking is the true decision."""


def distance_of(stop: tuple[Scenario, str]) -> float:
    """Return the distance of a stop whose law is given a piece of the truth, `PIECES` [m]; NaN without standstill."""
    scenario, piece = stop
    for known in (*_OF_THE_RAIL, *_DECISIONS):
        if piece == known:
            return informed_distance(scenario, known)
    if piece == "valves without dead time":
        scenario = without_dead_time(scenario)
    return distance_with((scenario, piece == "true state", piece == "pressure without valves"))


PIECES: Sequence[str] = (AS_IS, *_OF_THE_RAIL, "true state", "valves without dead time", "pressure without valves")
"""Pieces of the truth of one stop; the decision for deep slip follows from two stops."""


def gains_of(work: Work, design: Sequence[AnyCase]) -> ReportTable:
    """Run training cases with the laws and the pieces of truth, and return the table of gains."""
    stops = campaign_of(design, {law: ENTRANTS[law] for law in LAWS}, train_of(None), trains=trains_of(design)).stops
    scenarios = {law: [stop.scenario for stop in stops[i :: len(LAWS)]] for i, law in enumerate(LAWS)}
    runs = [(scenario, piece) for law in LAWS for piece in PIECES for scenario in scenarios[law]]
    runs += [(scenario, piece) for piece in _DECISIONS for scenario in scenarios[LAWS[-1]]]
    found = np.array(work.map(distance_of, runs)).reshape(-1, len(design))
    distances = {law: dict(zip(PIECES, found[i * len(PIECES) :], strict=False)) for i, law in enumerate(LAWS)}
    decided = {
        f"{piece}, or not": np.fmin(distances[LAW][AS_IS], deep)
        for piece, deep in zip(_DECISIONS, found[-len(_DECISIONS) :], strict=True)
    }
    cleans = np.array([stop.variants["cleaning"] in ("strong", BY_THE_CURVE) for stop in stops[:: len(LAWS)]])
    return gains_table(cleans, {law: {**of_piece, **decided} for law, of_piece in distances.items()})


@dataclass(frozen=True)
class Attribution(Study, quick="1 training case in place of all", sizes={"cases": 1, "gain_cases": 1}):
    """Give slope seeking and the law of two maxima the truth piece by piece, in training cases."""

    cases: Annotated[int, Option(min=1, help="Training cases; the loss is that of those with a bound.")] = 32
    gain_cases: Annotated[int, Option(min=1, help="Training cases for the gains by knowledge.")] = 16
    write: Annotated[bool, Option("--write", help=f"Write the tables into {PAGE}.")] = False

    def page(self, work: Work) -> Page:
        """Run the cases, and return the shares of the loss and the gains by knowledge."""
        design = [case for case in training_cases(self.cases, 2) if case.has_bound]
        compared = {name: ENTRANTS[name] for name in (LAW, "ideal_bound")}
        stops = campaign_of(design, compared, train_of(None), trains=trains_of(design)).stops
        laws, bounds = stops[::2], stops[1::2]
        runs = [(law.scenario, truth, ideal_actuation) for law in laws for truth, ideal_actuation in GIVEN]
        runs += [(bound.scenario, False, False) for bound in bounds]
        found = np.array(work.map(distance_with, runs))
        distances = np.column_stack([found[: -len(bounds)].reshape(-1, len(GIVEN)), found[-len(bounds) :]])
        stopped = np.isfinite(distances).all(axis=1)
        table = table_of(distances[stopped])
        of_cases = [(law.variants["case"], *row) for law, row in zip(laws, distances, strict=True)]
        each = ReportTable.of(("case", "as it is", "ideal actuation", "truth", "both", "bound"), of_cases, "{:.1f} m")
        for_gains = training_cases(self.gain_cases, 2)
        gains = gains_of(work, for_gains)
        if self.write:
            version = "training cases of version 2:\n\n"
            write_tables(
                PAGE,
                {
                    "attribution": f"{int(stopped.sum())} of {len(design)} {version}{table}",
                    "gains by knowledge": f"{len(for_gains)} {version}{gains}",
                },
            )
        return Page(
            title="What limits slope seeking and the law of two maxima",
            question="How much of the loss of slope seeking over the ideal bound is one of information, of actuation "
            "and of the law, and what would knowledge of the rail gain?",
            answer="The laws were given the truth in place of estimates, a pressure without valves, and the rail.",
            template="studies/attribution.md.jinja",
            values={"table": table, "each": each, "gains": gains},
            tables={"attribution.csv": table, "cases.csv": each, "gains.csv": gains},
            screen=(table, each, gains),
        )


STUDY = Attribution
