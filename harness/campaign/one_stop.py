"""One scenario, run and kept."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from railgrip.base.errors import ScenarioError
from railgrip.base.outputs import make_folder
from railgrip.campaign.sources import made_by
from railgrip.report.stop import Stop
from railgrip.scenario.schema import Scenario
from railgrip.trace.stop import FILES, require_place, write_stop

RUNS = Path("build/runs")
"""Folder of the folders of runs."""

Progress = Callable[[float], None]
"""Called now and then with the speed of the train [m/s]."""

Notify = Callable[[str], None]
"""Called with a sentence for the user."""


def silently(sentence: str) -> None:
    """Discard the message."""


class Runner(Protocol):
    """Runs a scenario; `railgrip.simulate.run.run_stop` is the one."""

    def __call__(self, scenario: Scenario, progress: Progress | None = None, notify: Notify = silently) -> Stop:
        """Return the stop, whatever its outcome; raise a sentence when the question is wrong."""
        ...


def run_folder(scenario: Scenario) -> Path:
    """Return the folder of a run whose user names none; another scenario of the same name has another one."""
    return RUNS / f"{scenario.name}-{scenario.digest()[:8]}"


def run(
    scenario: Scenario,
    directory: Path,
    runner: Runner,
    progress: Progress | None = None,
    notify: Notify = silently,
    *,
    keep_trace: bool = True,
) -> Stop:
    """Run a scenario and write its result into a folder, whole or not at all.

    The result of an earlier stop in the folder stays until the new one replaces it.

    Raises:
        RecordError: Results cannot be written there, files of the user are in the way, or the folder is that of a
            campaign; nothing was run.
        Unwritten: The result could not be written.
        ScenarioError: The scenario asks for something that its parts cannot do; it names the scenario.
    """
    require_place(directory)
    make_folder(directory, *FILES)
    try:
        stop = runner(scenario, progress, notify)
    except ScenarioError as problem:
        # Parts know the table and the key they were given, not whose scenario it is.
        raise ScenarioError(f"{scenario.name}: {problem}") if str(problem).startswith("[") else problem from None
    stop = with_maker(stop)
    write_stop(stop, directory, keep_trace=keep_trace)
    return stop


def with_maker(stop: Stop) -> Stop:
    """Return a stop whose versions contain those of the program that has made it; see `made_by`."""
    return replace(stop, versions={**stop.versions, **made_by()})
