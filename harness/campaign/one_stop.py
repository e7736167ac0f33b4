"""Run one scenario and write its result, with the versions of all inputs besides the scenario.

Results of another version of the program are not reused.
"""

import hashlib
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Protocol

from railgrip.base.errors import CompilerMissing, ScenarioError
from railgrip.base.programs import versions
from railgrip.base.records import make_folder
from railgrip.fmus import openmodelica
from railgrip.fmus.build import choose
from railgrip.fmus.native.toolchain import compiler
from railgrip.fmus.recipe import MODELICA
from railgrip.report.stop import FILES, Stop, require_place, write_stop
from railgrip.scenario.schema import Scenario

SOURCES = "sources"
"""Key of the digest of this program's source in the versions of a result."""

_PACKAGES = ("railgrip", "railgrip.controllers", "railgrip.estimators", "railgrip.fmus")
_KINDS = {".py", ".c", ".h", ".mo", ".toml", ".txt", ".jinja"}
_UNCONCERNED = ("railgrip/cli/", "railgrip/report/", "railgrip/studies/", "railgrip.fmus/lock.toml")
"""Files that read results or produce other ones, or that follow from the rest."""
_QUESTIONS = ("railgrip/scenario/library/", "railgrip/scenario/campaigns/", "railgrip/scenario/equipment/")
"""Files that define stops; the digest of the scenario covers them."""


@cache
def sources_digest(study: str | None = None) -> str:
    """Return a SHA-256 of every source that a stop depends on: the package's code and the Modelica library.

    With the name of a study, also of its module or folder and of all scenario files, on which the study's results
    depend.
    """
    roots = {name: Path(import_module(name).__path__[0]) for name in _PACKAGES} | {"modelica": MODELICA}
    digest = hashlib.sha256()
    for name, root in roots.items():
        for path in sorted(file for file in root.rglob("*") if file.suffix in _KINDS):
            # In an installation, the other packages are inside the package's folder.
            if any(
                path.is_relative_to(other) for other in roots.values() if other != root and other.is_relative_to(root)
            ):
                continue
            place = f"{name}/{path.relative_to(root).as_posix()}"
            is_of_study = study is not None and place.startswith(
                (f"railgrip/studies/{study}/", f"railgrip/studies/{study}.")
            )
            if is_of_study or not place.startswith(_UNCONCERNED if study else (*_UNCONCERNED, *_QUESTIONS)):
                digest.update(place.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def input_versions(study: str | None = None) -> dict[str, str]:
    """Return name → version of all inputs of a result besides its scenario.

    These are the sources, by their digest as `SOURCES`, Python, packages, machine, and the compilers of C and FMUs.

    Args:
        study: As for `sources_digest`.
    """
    return {SOURCES: sources_digest(study), **versions(), **_compilers()}


@cache
def _compilers() -> dict[str, str]:
    try:
        c_compiler = compiler().version
    except CompilerMissing:
        c_compiler = "none"
    fmu_compiler = openmodelica.version_line() if choose("auto") == "openmodelica" else "built-in"
    return {"C compiler": c_compiler, "FMU compiler": fmu_compiler}


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
