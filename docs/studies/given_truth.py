"""Stops of laws that are given pieces of the truth of the rail and of the train, and the parts of their loss."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from math import log
from typing import Any

import numpy as np
import pandas as pd

import railgrip as rg
from railgrip.base.arrays import Array
from railgrip.controllers.law import Law
from railgrip.scenario.faults import READ_BY
from railgrip.scenario.schema import Scenario
from railgrip.simulate.assembly import StopAssembly, assemble
from railgrip.simulate.ideal import KnownRail
from railgrip.simulate.run import run_stop
from railgrip.simulate.user_parts import NO_CUSTOM_PARTS, CustomParts
from railgrip.studies.type_test.case_set import AnyCase
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of, training_cases, trains_of
from railgrip.studies.type_test.track_case import BY_THE_CURVE
from railgrip.vehicle.parameters import VALVES

LAW = "slope_seeking"
LAWS = (LAW, "two_maxima")
ENTRANTS = entrants(2) | entrants(1)
"""Entrants with the numbers of version 1: those of version 2 are for valves alone."""

NOTHING, TRUE_STATE, NO_VALVES, BOTH = "nothing", "true state", "pressure without valves", "true state, no valves"
DECISIONS = ("deep slip", "deep slip once compared")
"""Slip of the law of two maxima, for the whole stop, or from the first comparison of groups on."""
OF_THE_RAIL = ("slip of the peak", "adhesion ahead")
PIECES = (NOTHING, *OF_THE_RAIL, TRUE_STATE, "valves without dead time", NO_VALVES)
"""Pieces of the truth that each law is given."""

_PERIOD = 0.04  # s, between two looks at the rail: friction of scenarios changes over tenths of a second
_AHEAD = 0.15  # s, until a command takes effect: dead time and part of the filling
_SLOWEST = 0.5  # m/s, below which a law does not seek slip
_READINGS = ("speed", "wheelset_speed", "deflection", "acceleration", "cylinder_pressure")


class InformedLaw:
    """A built-in law that seeks slip and is given a piece of the truth at every decision.

    With deep slip, the law of two maxima is in deep slip from the start, or from the time on at which it first compares
    a group behind with the first one. With the slip of the peak, the set point is its mean over the groups, without
    dither. With the adhesion ahead, the estimate is multiplied by the ratio of the peak that a command will meet to the
    present one. Peaks are those of the rail that no slip has cleaned.
    """

    def __init__(self, stop: StopAssembly, knowledge: str) -> None:
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

    def decide(self, observation: rg.Observation) -> tuple[float, ...]:
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


@dataclass(frozen=True, slots=True)
class TruthSensors:
    """Exact sensors, which leave the true signals for `TruthEstimator`."""

    truth: dict[str, Array] = field(default_factory=dict[str, Array])

    def start(self, formation: rg.Formation, random: np.random.Generator) -> None:
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

    def start(self, first: rg.Observation, formation: rg.Formation) -> None:
        """Start a stop with the loads that the law knows."""
        self._formation = formation
        self._known = np.array([brake.load for brake in formation.brakes])

    def step(self, observation: rg.Observation) -> rg.Estimate:
        """Return the true state."""
        truth = self._truth
        load = self._formation.sum_by_group(truth["wheelset_load"][None, :])[0]
        return rg.Estimate(
            speed=float(truth["speed"]),
            wheelset_speed=truth["wheelset_speed"],
            slip=truth["slip"],
            adhesion=truth["group_adhesion"] * load / self._known,
            pad_friction=truth["pad_friction"],
        )


@cache
def cases_of(count: int) -> Mapping[str, AnyCase]:
    """Return a number of training cases of version 2, with those of its further parts, by name."""
    return {case.name: case for case in training_cases(count, 2)}


def stop_row(training: int, case: str, law: str, given: str) -> dict[str, Any]:
    """Return the distance of a stop [m], NaN without standstill, and whether slip cleans its rail.

    Args:
        training: Number of training cases among which the case is.
        case: Name of the case.
        law: Law or bound.
        given: Piece of the truth that the law is given, of `PIECES`, `DECISIONS` or `BOTH`.
    """
    of_case = cases_of(training)[case]
    stop = campaign_of([of_case], {law: ENTRANTS[law]}, train_of(None), trains=trains_of([of_case])).stops[0]
    is_cleaned = stop.variants["cleaning"] in ("strong", BY_THE_CURVE)
    return {"rails": "cleaned" if is_cleaned else "other", "distance": distance_with(stop.scenario, given)}


def distance_with(scenario: Scenario, given: str) -> float:
    """Return the distance of a stop whose law is given a piece of the truth [m]; NaN without standstill."""
    if given in (*OF_THE_RAIL, *DECISIONS):
        with assemble(scenario) as stop:
            stop = replace(stop, parts=replace(stop.parts, controller=InformedLaw(stop, given)))
            return stop.stop(stop.run()).metrics.distance
    objects = NO_CUSTOM_PARTS
    if given in (TRUE_STATE, BOTH):
        sensors = TruthSensors()
        objects = CustomParts(sensors=sensors, estimator=TruthEstimator(sensors.truth))
    return run_stop(scenario_with(scenario, given), objects=objects).metrics.distance


def scenario_with(scenario: Scenario, given: str) -> Scenario:
    """Return a stop without the dead time, or the faults and valves, of which a piece of the truth relieves the law."""
    if given == "valves without dead time":  # of the law's model, too
        dead = {name: "0 s" for name in VALVES if name.startswith("dead")}
        return scenario.revised({"vehicle": {"parameters": dead}, "controller": {"parameters": dead}})
    no_valves = given in (NO_VALVES, BOTH)
    parts = (*(READ_BY if given in (TRUE_STATE, BOTH) else ()), *(("valve", "supply") if no_valves else ()))
    tables = scenario.tables()
    changes: dict[str, Any] = {"faults": [fault for fault in tables.get("faults", ()) if fault["part"] not in parts]}
    if no_valves:
        changes["actuation"] = {"kind": "ideal"}
        if "train" not in tables["vehicle"]:
            changes["vehicle"] = {"plant": "TwoPartTrain"}
    return scenario.revised(changes)


def losses(distances: pd.DataFrame) -> pd.DataFrame:
    """Return the parts of the loss of each case over the bound, relative to the bound.

    The loss that information causes is the mean of two differences, with and without valves, as is that of the
    actuation (Shapley 1953), so that their sum does not depend on the order. The rest is the loss of the law.

    Args:
        distances: Columns of the law given `NOTHING`, `TRUE_STATE`, `NO_VALVES` and `BOTH`, and of the bound [m].
    """
    nothing, truth, no_valves, both = (distances[given] for given in (NOTHING, TRUE_STATE, NO_VALVES, BOTH))
    parts = {
        "information": 0.5 * ((nothing - truth) + (no_valves - both)),
        "actuation": 0.5 * ((nothing - no_valves) + (truth - both)),
        "law": both - distances["bound"],
        "all": nothing - distances["bound"],
    }
    return pd.DataFrame(parts).div(distances["bound"], axis=0)


def gains(distances: pd.DataFrame) -> pd.DataFrame:
    """Return the change of the distance by each piece of the truth, relative to the law as it is.

    The better one of deep slip, in the law of two maxima, and slope seeking is the true decision for both laws.

    Args:
        distances: A row for each case, columns law and given [m].
    """
    found = distances.drop(columns=list(DECISIONS), level="given")
    for law in LAWS:
        for piece in DECISIONS:
            found[law, f"{piece}, or not"] = np.fmin(distances[LAW, NOTHING], distances[LAWS[-1], piece])
    as_is = found.xs(NOTHING, axis=1, level="given")
    return found.div(as_is, axis=1, level="law").sub(1).drop(columns=NOTHING, level="given")


def loss_rows(training: int) -> list[dict[str, Any]]:
    """Return mean and largest loss of slope seeking over the bound, and its share of the whole, by cause.

    Args:
        training: Number of training cases; those with a bound, in which all stops end, count.
    """
    bounded = [name for name, case in cases_of(training).items() if case.has_bound]
    given = [(LAW, piece) for piece in (NOTHING, TRUE_STATE, NO_VALVES, BOTH)] + [("ideal_bound", NOTHING)]
    stops = _stops(training, bounded, given)
    stops["stop"] = stops["given"].where(stops["law"] == LAW, "bound")
    found = losses(stops.pivot(index="case", columns="stop", values="distance").dropna())
    return [
        {"of": len(bounded), "stopped": len(found), "loss through": name, "mean over the bound": loss.mean(),
         "share of the loss": loss.mean() / found["all"].mean(), "largest": loss.max()}
        for name, loss in found.items()
    ]  # fmt: skip


def gain_rows(training: int) -> list[dict[str, Any]]:
    """Return the mean change of the distance of each law by each piece of the truth, by kind of rail."""
    given = [(law, piece) for law in LAWS for piece in PIECES] + [(LAWS[-1], piece) for piece in DECISIONS]
    stops = _stops(training, list(cases_of(training)), given)
    found = gains(stops.pivot(index=["rails", "case"], columns=["law", "given"], values="distance"))
    return [
        {"law": law, "rails": rails, "cases": len(of_rails), "given": piece, "change": change}
        for rails, of_rails in found.groupby("rails")
        for (law, piece), change in of_rails.mean().items()
    ]


def _stops(training: int, names: Sequence[str], given: Sequence[tuple[str, str]]) -> pd.DataFrame:
    cases = [{"training": training, "case": case, "law": law, "given": piece} for case in names for law, piece in given]
    return rg.evaluate(stop_row, cases)
