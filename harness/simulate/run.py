"""Run scenarios to their stops."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import xarray

from railgrip.base.errors import ScenarioError
from railgrip.report.stop import Stop
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.simulate.ideal import ANALYSES
from railgrip.simulate.loop.loop import Ending
from railgrip.simulate.parts import NO_CUSTOM_PARTS, CustomParts, assemble
from railgrip.simulate.remarks import remarks_before
from railgrip.trace.measures import distance_travelled, since_brake_demand


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
        return replace(analysis(scenario, progress), remarks=tuple(remarks))
    with assemble(scenario, notify, objects) as parts:
        ending = parts.run(progress)
    stop = parts.stop(ending)
    for sentence in stop.remarks[len(parts.remarks) :]:
        notify(sentence)
    return stop


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
