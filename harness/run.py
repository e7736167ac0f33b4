"""One scenario, run and kept."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from harness.record.error import RecordError
from harness.record.stop import Stop, write_stop
from harness.scenario.error import ScenarioError
from harness.scenario.schema import Scenario
from harness.sources import sources_digest

SOURCES = "sources"
"""Name of the digest of this program's text among the versions of a result."""

Progress = Callable[[float], None]
"""Called now and then with the speed of the train [m/s]."""

Tell = Callable[[str], None]
"""Called with a sentence for the user."""


def silently(sentence: str) -> None:
    """Tell nobody."""


class Runner(Protocol):
    """Runs a scenario; `harness.assemble.run_stop` is the one."""

    def __call__(self, scenario: Scenario, progress: Progress | None = None, tell: Tell = silently) -> Stop:
        """Return the stop, whatever its outcome; raise a sentence when the question is wrong."""
        ...


def make_folder(directory: Path) -> None:
    """Make the folder for results, before anybody waits for one.

    Raises:
        RecordError: It cannot be made.
    """
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise RecordError(
            f"{directory}: results cannot be written there: {problem.strerror}; name another folder by --out"
        ) from problem


def run(
    scenario: Scenario,
    directory: Path,
    runner: Runner,
    progress: Progress | None = None,
    tell: Tell = silently,
    *,
    keep_trace: bool = True,
) -> Stop:
    """Run a scenario and write its result into a folder, whole or not at all.

    Raises:
        RecordError: Results cannot be written there; nothing was run.
        ScenarioError: The scenario asks for something that its parties cannot do; it names the scenario.
    """
    make_folder(directory)
    try:
        stop = runner(scenario, progress, tell)
    except ScenarioError as problem:
        # Parties know the table and the key they were given, not whose scenario it is.
        raise ScenarioError(f"{scenario.name}: {problem}") if str(problem).startswith("[") else problem from None
    stop = replace(stop, versions={**stop.versions, SOURCES: sources_digest()})
    write_stop(stop, directory, keep_trace=keep_trace)
    return stop
