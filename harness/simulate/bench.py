"""Step a stop by hand: the caller acts as the controller."""

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from railgrip.base.errors import PlantFailed, ScenarioError
from railgrip.controllers.observation import Observation
from railgrip.report.stop import Stop
from railgrip.scenario.schema import Scenario
from railgrip.simulate.custom import problem_with
from railgrip.simulate.loop.loop import Ending, Loop
from railgrip.simulate.parts import CustomParts, StopAssembly, assemble
from railgrip.vehicle.formation import Formation


class ManualController:
    """Controller that is recorded in a stop which was stepped by hand."""

    def start(self, formation: Formation) -> None:
        """Store the formation."""
        self.formation = formation

    def decide(self, observation: Observation) -> ArrayLike:
        """Raise an error: the caller of `Bench.step` decides."""
        raise NotImplementedError


class Bench:
    """A scenario whose stop is stepped from decision to decision; a context manager, which closes the parts.

    with railgrip.open(scenario) as bench:
        observation = bench.reset()
        while not bench.ended:
            observation = bench.step(pressures)
    bench.stop.metrics.distance
    """

    def __init__(self, scenario: Scenario, objects: CustomParts) -> None:
        self._law = ManualController()
        self._scenario, self._objects = scenario, replace(objects, controller=self._law)
        self._stack = ExitStack()
        self._parts: StopAssembly | None = None
        self._loop: Loop | None = None
        self._decisions: Iterator[Observation] = iter(())
        self._observation: Observation | None = None
        self._end: Ending | None = None
        self._stop: Stop | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def ended(self) -> bool:
        """True once the stop has ended."""
        return self._end is not None

    @property
    def formation(self) -> Formation:
        """Formation under control; available after `reset`."""
        return self._law.formation

    @property
    def stop(self) -> Stop:
        """The stop, once it has ended.

        Raises:
            ScenarioError: The stop has not ended.
        """
        if self._end is None or self._parts is None:
            raise ScenarioError("bench: there is no stop before it has ended; go on with step() until `ended`")
        if self._stop is None:
            self._stop = self._parts.stop(self._end)
        return self._stop

    def reset(self) -> Observation:
        """Start or restart the stop, and return the observation at the brake demand.

        Raises:
            ScenarioError: The scenario asks for something that its parts cannot do, or ends before a decision.
            FmuError: An FMU does not fit.
        """
        self.close()
        self._loop = self._observation = self._end = self._stop = None
        self._parts = self._stack.enter_context(assemble(self._scenario, objects=self._objects))
        self._advance()
        if self._observation is None:
            reason = "" if self._end is None else self._end.reason
            raise ScenarioError(f"{self._scenario.name}: the stop ended before the first decision: {reason}")
        return self._observation

    def step(self, pressures: ArrayLike) -> Observation:
        """Apply pressures until the next decision, and return the observation then, or the last one at the end.

        Args:
            pressures: Demanded brake cylinder pressure of each group, shape (groups,) [Pa].

        Raises:
            ScenarioError: The pressures are not finite numbers of that shape, or the stop has not begun or has ended.
        """
        if self._observation is None or self._end is not None:
            raise ScenarioError("bench: reset() comes before step(), and again after the end of a stop")
        groups = self.formation.groups
        problem = problem_with(pressures, (groups,))
        if problem:
            raise ScenarioError(
                f"bench: step() expects the pressures [Pa] of {groups} groups, shape ({groups},); got {problem}"
            )
        assert self._loop is not None
        self._loop.demand(np.asarray(pressures, dtype=np.float64))
        self._advance()
        return self._observation

    def close(self) -> None:
        """Close the plant and the other parts; an unfinished stop is discarded."""
        self._stack.close()

    def _advance(self) -> None:
        assert self._parts is not None
        try:
            if self._loop is None:
                self._loop = Loop(self._parts.parts)
                self._decisions = self._loop.decisions()
            self._observation = next(self._decisions, self._observation)
            self._end = self._loop.ending
        except PlantFailed as problem:
            self._end = self._parts.failed(problem)
