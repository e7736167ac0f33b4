"""Run scenarios to their stops, or step a stop by hand: the caller then acts as the controller."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from itertools import accumulate, pairwise
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
import xarray
from numpy.typing import ArrayLike

from railgrip.base.errors import PlantFailed, ScenarioError
from railgrip.controllers.observation import Observation
from railgrip.report.stop import Stop
from railgrip.rolling_stock.schema import load_train
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.scenario.vehicle_table import Source, TrainFile
from railgrip.simulate.assembly import StopAssembly, assemble
from railgrip.simulate.ideal import ANALYSES
from railgrip.simulate.loop.loop import Ending, Loop
from railgrip.simulate.remarks import remarks_before, remarks_on_use
from railgrip.simulate.user_parts import NO_CUSTOM_PARTS, CustomParts, problem_with
from railgrip.trace.measures import distance_travelled, since_brake_demand
from railgrip.vehicle.formation import Formation


def run_stop(
    scenario: Scenario,
    progress: Callable[[float], None] | None = None,
    notify: Callable[[str], None] = lambda sentence: None,
    objects: CustomParts = NO_CUSTOM_PARTS,
) -> Stop:
    """Run a scenario and return its stop.

    Args:
        progress: Called with the train speed [m/s] at intervals.
        notify: Called with sentences for the user, such as that a foreign FMU runs in a separate process.
        objects: Objects that replace parts of the scenario.

    Raises:
        ScenarioError: The scenario requires something that its parts cannot do.
        FmuError: An FMU does not fit; nothing was run.
    """
    analysis = ANALYSES.get(scenario.controller.kind)
    if analysis is not None and objects.controller is None and objects.plant is None:
        remarks = remarks_before(scenario)
        for sentence in remarks:
            notify(sentence)
        with scenario.name_errors():
            stop = analysis(scenario, progress)
        for sentence in (excess := remarks_on_use(scenario, stop.metrics)):
            notify(sentence)
        return replace(stop, remarks=(*remarks, *excess), cars=cars_of(scenario.vehicle.source))
    with assemble(scenario, notify, objects) as parts:
        ending = parts.run(progress)
    stop = parts.stop(ending)
    for sentence in stop.remarks[len(parts.remarks) :]:
        notify(sentence)
    return replace(stop, cars=cars_of(scenario.vehicle.source))


def cars_of(source: Source) -> tuple[tuple[float, float], ...]:
    """Return both ends of each car behind the leading wheelset [m]; none unless the train is from a train file."""
    if not isinstance(source, TrainFile):
        return ()
    train = load_train(source.file.path)
    ends = list(accumulate((car.length for car in train.cars), initial=-train.axles[0].position))
    return tuple(pairwise(ends))


def braking_distance(scenario: Scenario, import_from: Sequence[Path] = ()) -> float | None:
    """Return only the distance [m], None if the train does not come to a stop: for searches over many stops.

    Classes that the scenario names are imported from the folders `import_from`.
    """
    # If a driver demands the brake later, all samples are needed to find the demand; else first and last suffice.
    ending, trace = _run_loop(
        scenario, CustomParts(folders=tuple(import_from)), capacity=2 if scenario.demand is None else None
    )
    return distance_travelled(since_brake_demand(trace)) if ending.outcome is Outcome.STANDSTILL else None


def trace_of(
    scenario: Scenario, import_from: Sequence[Path] = (), *, objects: CustomParts | None = None
) -> xarray.Dataset:
    """Return only the trace, without the ideal bound: for studies of many stops, three times as fast.

    Classes that the scenario names are imported from the folders `import_from`, unless `objects` replace parts.

    Raises:
        ScenarioError: The run ended with a failure.
    """
    ending, trace = _run_loop(scenario, objects or CustomParts(folders=tuple(import_from)))
    if ending.outcome not in (Outcome.STANDSTILL, Outcome.HORIZON):
        raise ScenarioError(f"{scenario.name}: ended with {ending.outcome.value}: {ending.reason}")
    return trace


def _run_loop(scenario: Scenario, objects: CustomParts, capacity: int | None = None) -> tuple[Ending, xarray.Dataset]:
    with assemble(scenario, objects=objects, capacity=capacity) as parts:
        ending = parts.run()
    return ending, parts.recorder.trace(max(ending.samples, 1), scenario.periods.communication)


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
        self._is_closed = False

    def __enter__(self) -> Self:
        self._require_open()
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
        """Formation under control.

        Raises:
            ScenarioError: The stop has never been started.
        """
        if self._parts is None:
            raise ScenarioError("bench: the formation is known after reset()")
        return self._law.formation

    @property
    def stop(self) -> Stop:
        """The stop, once it has ended.

        Raises:
            ScenarioError: The stop has not ended.
        """
        if self._end is None or self._parts is None:
            self._require_open()
            raise ScenarioError("bench: there is no stop before it has ended; go on with step() until `ended`")
        if self._stop is None:
            self._stop = self._parts.stop(self._end)
        return self._stop

    def reset(self) -> Observation:
        """Start or restart the stop, and return the observation at the brake demand.

        Raises:
            ScenarioError: The scenario asks for something that its parts cannot do, or ends before a decision; or the
                bench is closed.
            FmuError: An FMU does not fit.
        """
        self._require_open()
        self._stack.close()
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
            ScenarioError: The pressures are not finite numbers of that shape, the stop has not begun or has ended, or
                the bench is closed.
        """
        self._require_open()
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
        """Close the plant and the other parts for good; an unfinished stop is discarded."""
        self._is_closed = True
        self._stack.close()

    def _require_open(self) -> None:
        # The loop in C would use the memory of parts that has been freed.
        if self._is_closed:
            raise ScenarioError("bench: the bench is closed; open another one and step it within its `with`")

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
