"""Commands for accepted numbers: compare them, and accept new ones."""

import shlex
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

from railgrip.base.errors import ScenarioError
from railgrip.base.files import write_text
from railgrip.campaign.run import CampaignRun
from railgrip.campaign.workers import shared_pool
from railgrip.cli.app import BASELINES, RUN_FAILED, AsJson, ImportFrom, Workers, print_json
from railgrip.cli.campaigns import run_campaigns
from railgrip.report.baseline import (
    Baseline,
    BaselineComparison,
    Finding,
    Findings,
    compare,
    comparison_table,
    findings_of,
    load_baseline,
    read_findings,
    write_baseline,
    write_findings,
)
from railgrip.report.baseline import accept as accept_numbers
from railgrip.report.console import complain, show_table
from railgrip.report.junit import junit_xml
from railgrip.report.results import read_results
from railgrip.scenario.campaign import load_campaign
from railgrip.simulate.user_parts import call_user_code
from railgrip.studies.study import headlines

REGRESS = Path("build/regress")


def regress(
    baselines: Annotated[Path, typer.Option(help="Folder of baseline files.")] = BASELINES,
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = REGRESS,
    junit: Annotated[
        Path | None, typer.Option(metavar="FILE", help="JUnit XML for CI servers: each stop or figure is a test case.")
    ] = None,
    as_json: AsJson = False,
    workers: Workers = 2,
    across_compilers: Annotated[
        bool,
        typer.Option("--across-compilers", help="Compare campaigns only, with FMUs of another compiler, within 0.5 %."),
    ] = False,
    import_from: ImportFrom = None,
) -> None:
    """Run everything that has a baseline and compare every number.

    The exit code is 0 if all are kept, 2 for wrong input and 3 for a number that is new, has moved or does not exist.
    """
    if junit is not None:  # the report of an earlier run must not stay if this one fails
        write_text(junit, junit_xml({"regress": {"regress": "did not run to its end; see the output of the command"}}))
    files = {path: load_baseline(path) for path in _baseline_files(baselines)}
    if across_compilers:
        files = {path: each.across_compilers() for path, each in files.items() if each.campaign is not None}
        if not files:
            raise ScenarioError(f"{baselines}: no baseline in it is that of a campaign, as --across-compilers expects")
    # Worker processes that start from here on find these modules, too.
    modules = {
        path: _headlines_of(path, path.parent / each.module, import_from or ())
        for path, each in files.items()
        if each.module is not None
    }
    found: dict[Path, Sequence[BaselineComparison]] = {}
    code = 0
    with shared_pool(workers):
        for path, baseline in files.items():
            if path in modules:
                problem, findings = 0, Findings(values=tuple(modules[path]()))
                write_findings(findings, out / path.stem)
            else:
                problem, findings = _numbers_of(baseline, path, out / path.stem, workers, import_from or ())
            found[path] = compare(baseline, findings)
            code = problem or code
            if not found[path]:
                raise ScenarioError(f"{path}: stops = {list(baseline.stops)}: {baseline.campaign} has no such stop")
            if not as_json:
                show_table(comparison_table(found[path], path.name), "nothing changed")
    if junit is not None:
        write_text(junit, junit_xml({path.stem: {one.name: one.sentence for one in found[path]} for path in found}))
    command = None if code or across_compilers else _accept_command(baselines, out)
    if as_json:
        numbers = {path.as_posix(): [one.to_plain() for one in each] for path, each in found.items()}
        print_json({"baselines": numbers, "accept": command})
    for path, comparisons in found.items():
        sentences = [one.sentence for one in comparisons if one.state != "kept"]
        if sentences:
            what = "stops" if files[path].campaign is not None else "figures"
            complain(f"{path.name}: {len(sentences)} of {len(comparisons)} {what} deviate from their baseline:")
            complain("\n".join(f"  {sentence}" for sentence in sentences))
            code = RUN_FAILED
    if code and command is not None:
        complain(f"If that is right: {command}")
    if code:
        raise typer.Exit(code)


def _accept_command(baselines: Path, out: Path) -> str:
    words = ["railgrip", "maintain", "accept", "--reason", "why the new numbers are right"]
    for option, path, default in (("--baselines", baselines, BASELINES), ("--out", out, REGRESS)):
        words += [option, str(path)] if path != default else []
    return shlex.join(words)


def accept(
    reason: Annotated[str, typer.Option(help="What changed, and why the new numbers are right.")],
    baselines: Annotated[Path, typer.Option(help="Folder of baseline files.")] = BASELINES,
    out: Annotated[Path, typer.Option(help="Folder of the results of the last regress.")] = REGRESS,
) -> None:
    """Update the baselines to the results of the last regress."""
    accepted: dict[Path, tuple[Baseline, Findings, Baseline]] = {}
    for path in _baseline_files(baselines):
        baseline, folder = load_baseline(path), out / path.stem
        if not folder.is_dir():
            raise ScenarioError(
                f"{folder}: there are no results of {path.name}; run `railgrip maintain regress` with the same "
                "--baselines and --out first"
            )
        findings = read_findings(folder) if baseline.campaign is None else findings_of(read_results(folder))
        accepted[path] = baseline, findings, accept_numbers(baseline, findings, reason)
    for path, (baseline, findings, after) in accepted.items():
        # A number within its tolerance may have been replaced by a range.
        changes = tuple(
            comparison
            for comparison in compare(baseline, findings)
            if after.accepted.get(comparison.name) != baseline.accepted.get(comparison.name)
        )
        write_baseline(after, path)
        show_table(comparison_table(changes, f"{path.name}: accepted"), "nothing changed")


def _numbers_of(
    baseline: Baseline, path: Path, out: Path, workers: int, import_from: Sequence[Path]
) -> tuple[int, Findings]:
    if baseline.campaign is not None:
        runs = [CampaignRun(baseline.selection(load_campaign(path.parent / baseline.campaign)), out)]
        code = run_campaigns(runs, workers=workers, fresh=False, import_from=import_from)
        return code, findings_of(read_results(out))

    findings = headlines(str(baseline.study), workers=workers)
    write_findings(findings, out)
    return 0, findings


def _headlines_of(baseline: Path, file: Path, import_from: Sequence[Path]) -> Callable[[], list[Finding]]:
    folder = file.parent.resolve()
    if folder not in [each.resolve() for each in import_from]:
        raise ScenarioError(
            f"{baseline}: module {file.name} is Python code in {folder}, which the command does not name; add "
            f"--import-from {shlex.quote(str(file.parent))} if it may run"
        )
    sys.path.append(str(folder))

    def failed(problem: str) -> ScenarioError:
        return ScenarioError(f"{file}: {problem}; the module of a baseline must have headlines(), a list of Finding")

    headlines_of_file = call_user_code(lambda: import_module(file.stem).headlines, failed)
    return lambda: call_user_code(headlines_of_file, failed)


def _baseline_files(folder: Path) -> list[Path]:
    files = sorted(folder.glob("*.toml"))
    if not files:
        raise ScenarioError(
            f"{folder}: there is no baseline file (*.toml) in it; run in the folder of the project, give --baselines, "
            "or begin with `railgrip new regression stops.toml`"
        )
    return files
