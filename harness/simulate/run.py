"""Stops of scenarios."""

from collections.abc import Callable, Sequence
from pathlib import Path

import xarray

from railgrip.base.errors import ScenarioError
from railgrip.report.stop import Stop
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.simulate.ideal import ANALYSES
from railgrip.simulate.loop.loop import Ending
from railgrip.simulate.parts import NO_CUSTOM_PARTS, CustomParts, assembled
from railgrip.trace.measures import distance_travelled, since_brake_demand


def run_stop(
    scenario: Scenario,
    progress: Callable[[float], None] | None = None,
    notify: Callable[[str], None] = lambda sentence: None,
    objects: CustomParts = NO_CUSTOM_PARTS,
) -> Stop:
    """Run a scenario and return its stop.

    Args:
        progress: Called with the train speed [m/s] now and then.
        notify: Gets sentences for the user, such as that a foreign FMU runs in a process of its own.
        objects: Objects in place of what the scenario names.

    Raises:
        ScenarioError: The scenario asks for something that its parts cannot do.
        FmuError: An FMU does not fit; nothing was run.
    """
    analysis = ANALYSES.get(scenario.controller.kind)
    if analysis is not None and objects.controller is None and objects.plant is None:
        return analysis(scenario, progress)
    with assembled(scenario, notify, objects) as parts:
        ending = parts.run(progress)
    return parts.stop(ending)


def braking_distance(scenario: Scenario, import_from: Sequence[Path] = ()) -> float | None:
    """Return only the distance [m], None where the train does not come to stand: for searches over many stops.

    Classes that the scenario names are imported from the folders `import_from`.
    """
    # Where a driver demands the brake in the course of it, that sample is looked for; else first and last will do.
    ending, trace = _unjudged(scenario, import_from, capacity=2 if scenario.demand is None else None)
    return distance_travelled(since_brake_demand(trace)) if ending.outcome is Outcome.STANDSTILL else None


def trace_of(scenario: Scenario, import_from: Sequence[Path] = ()) -> xarray.Dataset:
    """Return only what happened, without the ideal bound: for studies of many stops, three times as fast.

    Classes that the scenario names are imported from the folders `import_from`.

    Raises:
        ScenarioError: The run ended with a failure.
    """
    ending, trace = _unjudged(scenario, import_from)
    if ending.outcome not in (Outcome.STANDSTILL, Outcome.HORIZON):
        raise ScenarioError(f"{scenario.name}: ended with {ending.outcome.value}: {ending.reason}")
    return trace


def _unjudged(
    scenario: Scenario, import_from: Sequence[Path], capacity: int | None = None
) -> tuple[Ending, xarray.Dataset]:
    with assembled(scenario, objects=CustomParts(folders=tuple(import_from)), capacity=capacity) as parts:
        ending = parts.run()
    return ending, parts.recorder.trace(max(ending.samples, 1), scenario.periods.communication)
