"""Run one scenario and write its result."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from railgrip.base.errors import ScenarioError
from railgrip.base.records import make_folder
from railgrip.campaign.sources import input_versions
from railgrip.report.stop import FILES, Stop, require_place, write_stop
from railgrip.scenario.schema import Scenario

RUNS = Path("build/runs")
"""Parent folder of the folders of runs."""

Progress = Callable[[float], None]
"""Called at intervals with the speed of the train [m/s]."""

Notify = Callable[[str], None]
"""Called with a sentence for the user."""


def ignore(sentence: str) -> None:
    """Ignore a message for the user."""


class Runner(Protocol):
    """Runs a scenario; implemented by `railgrip.simulate.run.run_stop`."""

    def __call__(self, scenario: Scenario, progress: Progress | None = None, notify: Notify = ignore) -> Stop:
        """Return the stop, whatever its outcome; raise an error for invalid input."""
        ...


def run_folder(scenario: Scenario) -> Path:
    """Return the default folder of a run; different scenarios with the same name have different folders."""
    return RUNS / f"{scenario.name}-{scenario.digest()[:8]}"


def run(
    scenario: Scenario,
    directory: Path,
    runner: Runner,
    progress: Progress | None = None,
    notify: Notify = ignore,
    *,
    keep_trace: bool = True,
) -> Stop:
    """Run a scenario and write its result to a folder, completely or not at all.

    The result of an earlier stop in the folder stays until the new one replaces it.

    Raises:
        RecordError: Results cannot be written to the folder, files of the user would be overwritten, or the folder is
            that of a campaign; nothing was run.
        WriteFailed: The result could not be written.
        ScenarioError: The scenario requires something that its parts cannot do; the message names the scenario.
    """
    require_place(directory)
    make_folder(directory, *FILES)
    try:
        stop = runner(scenario, progress, notify)
    except ScenarioError as problem:
        # Parts know the table and the key, but not the name of the scenario.
        raise ScenarioError(f"{scenario.name}: {problem}") if str(problem).startswith("[") else problem from None
    stop = add_versions(stop)
    write_stop(stop, directory, keep_trace=keep_trace)
    return stop


def add_versions(stop: Stop) -> Stop:
    """Return a stop whose versions include those of the program that ran it; see `input_versions`."""
    return replace(stop, versions={**stop.versions, **input_versions()})
