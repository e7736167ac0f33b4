"""Run stops, one here or many in processes; results have the versions of all inputs, and are stored at once.

Stops with a result are not run again. Results of another version of the program are not reused.
"""

import ast
import hashlib
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Literal

from railgrip.base.errors import CompilerMissing, InputError, RailgripError, RecordError
from railgrip.base.files import PARTIAL, scratch, write_bytes, write_json
from railgrip.base.programs import versions
from railgrip.base.records import RECORD, claim, discard, make_folder, require_free
from railgrip.campaign import workers as processes
from railgrip.fmus import openmodelica
from railgrip.fmus.build import choose
from railgrip.fmus.native.toolchain import compiler
from railgrip.fmus.recipe import MODELICA, read_recipes
from railgrip.report.console import remark
from railgrip.report.results import OURS, fmu_tools, require_campaign
from railgrip.report.stop import (
    CAMPAIGN_FILE,
    FILES,
    PAGE_FILES,
    STOP_FILE,
    Stop,
    discard_stop,
    read_stop,
    require_place,
    write_stop,
)
from railgrip.scenario.campaign import Campaign, PlannedStop
from railgrip.scenario.conditioning import read_conditioning
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.simulate.user_files import are_current, dependencies_of, record_files, user_kinds

SOURCES = "sources"
"""Key of the digest of this program's source in the versions of a result."""

_PACKAGES = ("railgrip", "railgrip.controllers", "railgrip.estimators", "railgrip.fmus")
_KINDS = {".py", ".c", ".h", ".mo", ".toml", ".txt", ".jinja"}
_UNCONCERNED = ("railgrip/cli/", "railgrip/report/", "railgrip/studies/", "railgrip.fmus/lock.toml")
"""Files that read results or produce other ones, or that follow from the rest."""
_QUESTIONS = ("railgrip/scenario/library/", "railgrip/scenario/campaigns/", "railgrip/scenario/equipment/")
"""Files that define stops; the digest of the scenario covers them."""


@cache
def sources_digest(study: str | Path | None = None) -> str:
    """Return a SHA-256 of every source that a stop depends on: the package's code and the Modelica library.

    With the name of a study, also of its module or folder, of those of the studies that it imports, and of all scenario
    files, on which the study's results depend. The path of a module outside of the package is that of a study, too.
    """
    roots = {name: Path(import_module(name).__path__[0]) for name in _PACKAGES} | {"modelica": MODELICA}
    used = studies_used(study, roots["railgrip"] / "studies") if study else ()
    of_studies = tuple(f"railgrip/studies/{name}{end}" for name in used for end in "/.")
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in _modules(study)))
    for name, root in roots.items():
        for path in sorted(file for file in root.rglob("*") if file.suffix in _KINDS):
            # In an installation, the other packages are inside the package's folder.
            if any(
                path.is_relative_to(other) for other in roots.values() if other != root and other.is_relative_to(root)
            ):
                continue
            place = f"{name}/{path.relative_to(root).as_posix()}"
            if place.startswith(of_studies) or not place.startswith(
                _UNCONCERNED if study else (*_UNCONCERNED, *_QUESTIONS)
            ):
                digest.update(place.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def studies_used(study: str | Path, folder: Path) -> set[str]:
    """Return the names of a study in a folder and of all studies that it imports, directly or through others.

    A study that is a module outside of the folder is not among them.
    """
    used, waiting = set[str](), {study} if isinstance(study, str) else set[str]()
    for path in _modules(study):
        waiting |= _imported_studies(path)
    while waiting:
        name = waiting.pop()
        used.add(name)
        for path in (*folder.glob(f"{name}.py"), *(folder / name).rglob("*.py")):
            waiting |= _imported_studies(path) - used
    return used


def _modules(study: str | Path | None) -> list[Path]:
    """Return the modules of a study outside of the package: its file, and those next to it that it imports."""
    found = [study] if isinstance(study, Path) else []
    for path in found:
        near = {path.with_name(f"{name.partition('.')[0]}.py") for name in _imports(path)}
        found += sorted(other for other in near - set(found) if other.is_file())
    return found


def _imported_studies(path: Path) -> set[str]:
    of_studies = {name.split(".")[2] for name in _imports(path) if name.startswith("railgrip.studies.")}
    return of_studies - {"study"}  # the interface, which computes nothing


def _imports(path: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_bytes(), str(path))):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    return names


def input_versions(study: str | Path | None = None) -> dict[str, str]:
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


Runner = Callable[[Scenario, Progress | None, Notify], Stop]
"""Runs a scenario and returns the stop, whatever its outcome; raises an error for invalid input.

Implemented by `railgrip.simulate.run.run_stop`.
"""


def run_folder(scenario: Scenario) -> Path:
    """Return the default folder of a run; different scenarios with the same name have different folders."""
    return RUNS / f"{scenario.name}-{scenario.digest()[:8]}"


def run(
    scenario: Scenario,
    directory: Path,
    runner: Runner,
    progress: Progress | None = None,
    notify: Notify = lambda sentence: None,
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
    if kinds := user_kinds(scenario):
        record_files()
    stop = runner(scenario, progress, notify)
    stop = replace(add_versions(stop), dependencies=dependencies_of(kinds) if kinds else {})
    write_stop(stop, directory, keep_trace=keep_trace)
    return stop


def add_versions(stop: Stop) -> Stop:
    """Return a stop whose versions include those of the program that ran it; see `input_versions`."""
    return replace(stop, versions={**stop.versions, **input_versions()})


State = Literal["found", "done", "unexpected", "refused", "failed"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """Report on one stop.

    Attributes:
        stop: Which.
        state: `found` from an earlier run, or `done`, with the outcome that the campaign expects; `unexpected` with
            another outcome, found or done; `refused` for invalid input; `failed` without a result.
        sentence: Outcome or reason, for readers.
    """

    stop: PlannedStop
    state: State
    sentence: str


@dataclass(frozen=True, slots=True)
class CampaignRun:
    """A campaign and the folder for its results."""

    campaign: Campaign
    directory: Path


def run_campaigns(
    campaigns: Sequence[CampaignRun],
    runner: Runner,
    *,
    workers: int = 2,
    scheduler: str | None = None,
    fresh: bool = False,
    import_from: Sequence[Path] = (),
    notify: Callable[[Report], None],
) -> list[list[Report]]:
    """Run the stops of campaigns into folders with their names; return the reports in the order of the campaigns.

    A stop with a result from the same scenario and the same sources is not run again, unless `fresh` is set or one of
    its files has changed since, which a message reports. Results are always complete; an exception ends the running
    stops and keeps the finished ones.

    Args:
        campaigns: Campaigns and their folders; each folder gets campaign.json, which lists the stops, and a folder for
            each stop.
        runner: Function that runs a stop; it must be picklable, because it runs in other processes.
        scheduler: Address of a Dask cluster that runs the stops instead of local processes; a shared disk is not
            required.
        fresh: Whether to run stops that have a result.
        import_from: Folders from which `runner` imports classes of the user.
        notify: Called with the report of each stop at once.

    Raises:
        RecordError: Results cannot be written to a folder, or it has other results; nothing was run.
    """
    for planned in campaigns:
        name = planned.campaign.name
        require_free(planned.directory, CAMPAIGN_FILE, f"{name}.json", f"{name}.md", "index.html")
        require_campaign(planned.directory, name)
        for stop in planned.campaign.stops:
            require_place(planned.directory / stop.name)
        make_folder(planned.directory, CAMPAIGN_FILE, f"{name}.json", f"{name}.md", "index.html")
        write_description(planned.campaign, planned.directory)
    reports: list[dict[str, Report]] = [{} for _ in campaigns]
    waiting: list[_StopOrder] = []
    for number, planned in enumerate(campaigns):
        for stop in planned.campaign.stops:
            folder = planned.directory / stop.name
            if not fresh and (found := find_result(stop, folder, import_from)) is not None:
                reports[number][stop.name] = report = _report(stop, "found", found.outcome, found.reason)
                notify(report)
            else:
                waiting.append(_StopOrder(number, stop, folder))
    with _running(waiting, runner, workers, scheduler) as running:
        for order, report in running:
            if report.state in ("refused", "failed"):
                discard_stop(order.folder)  # an earlier result would be mistaken for the present one
            reports[order.campaign][order.stop.name] = report
            notify(report)
    return [
        [reports_of[stop.name] for stop in planned.campaign.stops]
        for planned, reports_of in zip(campaigns, reports, strict=True)
    ]


@dataclass(frozen=True, slots=True)
class _StopOrder:
    """A stop to run, the number of its campaign, and the folder for its result."""

    campaign: int
    stop: PlannedStop
    folder: Path


@contextmanager
def _running(
    orders: Sequence[_StopOrder], runner: Runner, workers: int, scheduler: str | None
) -> Generator[Iterator[tuple[_StopOrder, Report]]]:
    """Start to run stops in their order; yield an iterator over their reports, in the order in which they end."""
    if not orders:
        yield iter(())
        return
    try:
        with processes.pool(min(workers, len(orders)), scheduler) as (pool, check):
            perform = _perform if scheduler is None else _perform_far
            running = {pool.submit(perform, order, runner): order for order in orders}
            yield (
                (order, _failure(order, result) if isinstance(result, RailgripError) else _stored(order, *result))
                for order, result in processes.collect(running, check)
            )
    finally:
        # Partial files of a process that was ended or crashed.
        for half in (path for order in orders for path in order.folder.glob(PARTIAL)):
            half.unlink(missing_ok=True)


def _perform(order: _StopOrder, runner: Runner) -> tuple[Report, Mapping[str, bytes]]:
    """Run one stop in this process; return its report, and no files, which are already in their folder."""
    planned = order.stop
    stop = processes.answer(lambda: run(planned.scenario, order.folder, runner, keep_trace=planned.keep_trace))
    if isinstance(stop, RailgripError):
        return _failure(order, stop), {}
    return _report(planned, "done", stop.outcome, stop.reason), {}


def _report(stop: PlannedStop, state: Literal["found", "done"], outcome: Outcome, reason: str) -> Report:
    """Return the report of a stop with a result; a result found and one just computed differ only in `state`."""
    if outcome is stop.expected:
        return Report(stop=stop, state=state, sentence=reason)
    sentence = f"the outcome is {outcome.value}, expected was {stop.expected.value}: {reason}"
    return Report(stop=stop, state="unexpected", sentence=sentence)


def _perform_far(order: _StopOrder, runner: Runner) -> tuple[Report, Mapping[str, bytes]]:
    with scratch("far") as folder:
        report, _ = _perform(replace(order, folder=folder / order.stop.name), runner)
        files = {path.name: path.read_bytes() for path in (folder / order.stop.name).glob("*")}
    return report, files


def _stored(order: _StopOrder, report: Report, files: Mapping[str, bytes]) -> Report:
    """Write the files of a stop that was run elsewhere, stop.json last, which marks a complete result.

    Return the report.
    """
    if files:
        names = sorted(files.keys() - {RECORD}, key=lambda name: name == STOP_FILE)
        claim(order.folder, *names)
        for name in names:
            write_bytes(order.folder / name, files[name])
        discard(order.folder, {*FILES, *PAGE_FILES} - files.keys())
    return report


def _failure(order: _StopOrder, problem: RailgripError) -> Report:
    state = "refused" if isinstance(problem, InputError) else "failed"
    return Report(stop=order.stop, state=state, sentence=str(problem))


def find_result(stop: PlannedStop, directory: Path, import_from: Sequence[Path] = ()) -> Stop | None:
    """Return the result of this stop in a folder, if the present program, packages and compilers would reproduce it.

    Classes of the user, imported from `import_from`, must depend on the same files and packages.

    A message names a file of such a result that has changed since.
    """
    if not (directory / STOP_FILE).exists():
        return None
    scenario = stop.scenario
    try:
        found = read_stop(directory)
        if found.digest != scenario.digest() or not input_versions().items() <= found.versions.items():
            return None
        if (kinds := user_kinds(scenario)) and not are_current(kinds, found.dependencies, import_from):
            return None
        if stop.keep_trace:
            if found.trace_digest is None:  # the samples could not be stored, or were not requested
                return None
            found.require_unchanged_trace()
    except RecordError as problem:
        remark(f"{stop.name}: is run again, for {problem}")
        return None
    compilers = [tool for name, tool in fmu_tools(found.versions).items() if Path(name).stem in read_recipes().recipes]
    return found if all(tool.startswith(OURS) == (choose("auto") == "native") for tool in compilers) else None


def write_description(campaign: Campaign, directory: Path) -> None:
    """Write campaign.json, which describes the campaign of the results in its folder.

    Raises:
        ScenarioError: The campaign's file of conditioning cannot be read.
    """
    conditioning = read_conditioning(campaign.conditioning).stops if campaign.conditioning else {}
    content = {
        "name": campaign.name,
        "description": campaign.description,
        "permitted_distance_m": campaign.permitted_distance,
        "published": list(dict.fromkeys(reference.source for reference in campaign.references)),
        "stops": [
            {
                "name": stop.name,
                "variants": dict(stop.variants),
                "scenario_digest": stop.scenario.digest(),
                "paper_distance_m": reference.distance if (reference := campaign.reference_for(stop)) else None,
                "conditioning": conditioning[stop.name].model_dump(mode="json") if stop.name in conditioning else None,
            }
            for stop in campaign.stops
        ],
    }
    claim(directory, CAMPAIGN_FILE)
    write_json(directory / CAMPAIGN_FILE, content)
