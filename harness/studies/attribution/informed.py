"""A law that is given the truth of the rail piece by piece: what perfect knowledge of it would gain."""

from dataclasses import replace
from math import log
from typing import Literal

import numpy as np

from railgrip.controllers.law import Law
from railgrip.controllers.observation import Observation
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.simulate.assembly import StopAssembly, assemble
from railgrip.simulate.ideal import KnownRail
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
        result = stop.stop(stop.run())
    return result.metrics.distance if result.outcome is Outcome.STANDSTILL else np.nan


def without_dead_time(scenario: Scenario) -> Scenario:
    """Return a stop whose valves, and the law's model of them, have no dead time."""
    dead = {name: "0 s" for name in VALVES if name.startswith("dead")}
    return scenario.revised({"vehicle": {"parameters": dead}, "controller": {"parameters": dead}})
