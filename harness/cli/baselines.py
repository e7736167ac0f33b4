"""Commands for accepted numbers: compare them, accept new ones, write them to the documentation, repeat stops."""

import shlex
from collections.abc import Sequence
from fnmatch import fnmatch
from pathlib import Path
from typing import Annotated

import typer

from railgrip.base.errors import ScenarioError
from railgrip.base.files import write_text
from railgrip.base.registry import shelf
from railgrip.campaign.conditioning import (
    Refinement,
    campaign_of,
    conditioning_of,
    merged,
    repeats_of,
    with_refinement,
)
from railgrip.campaign.run import CampaignRun
from railgrip.campaign.work import work
from railgrip.campaign.workers import shared_pool
from railgrip.cli.app import BASELINES, RUN_FAILED, AsJson, Fresh, ImportFrom, Workers, print_json
from railgrip.cli.campaigns import run_campaigns
from railgrip.fmus.build import choose
from railgrip.report.baseline import (
    Baseline,
    BaselineComparison,
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
from railgrip.report.console import complain, say, show_table
from railgrip.report.junit import junit_xml
from railgrip.report.results import read_results
from railgrip.report.table import ReportTable, write_tables, yes_no
from railgrip.report.validation import (
    CONVERGENCE,
    CONVERGENCE_CAMPAIGNS,
    TABLES,
    compilers_table,
    steps_table,
    tolerances_table,
)
from railgrip.scenario.campaign import Campaign, load_campaign
from railgrip.scenario.conditioning import RepeatedDistances, read_conditioning, text_of
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
    found: dict[Path, Sequence[BaselineComparison]] = {}
    code = 0
    with shared_pool(workers):
        for path, baseline in files.items():
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


def validation(
    baselines: Annotated[Path, typer.Option(help="Folder of baseline files.")] = BASELINES,
    docs: Annotated[Path, typer.Option(help="Folder of the pages.")] = Path("docs"),
) -> None:
    """Write the accepted distances into the documentation."""
    # Imported here, because only this command draws and needs matplotlib.
    from railgrip.report.style import save
    from railgrip.report.validation import BASELINE, FILE, distances_figure

    path = baselines / f"{BASELINE}.toml"
    accepted = _baseline_of_campaign(path)
    figure, numbers = distances_figure(load_campaign(path.parent / str(accepted.campaign)), accepted)
    say(str(save(figure, docs / FILE, numbers)))
    compared: list[tuple[Campaign, Baseline]] = []
    for name, (page, tables_of) in TABLES.items():
        path = baselines / f"{name}.toml"
        accepted = _baseline_of_campaign(path)
        compared.append((load_campaign(path.parent / str(accepted.campaign)), accepted))
        write_tables(docs / page, tables_of(*compared[-1]))
        say(str(docs / page))
    page = docs / CONVERGENCE
    campaigns = [load_campaign(shelf("campaigns")[name]) for name in CONVERGENCE_CAMPAIGNS]
    write_tables(page, {"tolerances": tolerances_table(*campaigns), "compilers": compilers_table(*compared)})


def _baseline_of_campaign(path: Path) -> Baseline:
    accepted = load_baseline(path)
    if accepted.campaign is None:
        raise ScenarioError(f"{path}: is the baseline of a study, but the table shows a campaign")
    return accepted


def conditioning(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="Campaign that names its file of conditioning.")],
    repeats: Annotated[int, typer.Option(min=2, max=1000, help="Of each stop.")] = 20,
    relative: Annotated[float, typer.Option(min=1e-15, max=1e-2, help="Largest change of a parameter.")] = 1e-7,
    lots: Annotated[
        int, typer.Option(min=0, max=1000, help="Number of sensor lots, for stops whose sensors have errors.")
    ] = 20,
    stops: Annotated[
        str, typer.Option(metavar="PATTERN", help="Only stops of such a name, as '*-slope_seeking'; others stay.")
    ] = "*",
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("build/conditioning"),
    workers: Workers = 2,
    fresh: Fresh = False,
    import_from: ImportFrom = None,
) -> None:
    """Repeat stops with other parameters and sensors."""
    loaded, selection, place = _conditioned(file, stops, "the file to write")
    if not selection.stops:
        raise ScenarioError(f"--stops {stops}: {file.name} has no such stop; it has {loaded.stops[0].name} and others")
    before = read_conditioning(place).stops if place.exists() else {}
    others = _previous_repeats(place, relative) if before and (stops != "*" or choose("auto") != "native") else {}
    compiler = choose("auto")
    # One repeat by another compiler suffices for a stop whose distance hardly depends on the parameters; sensors do not
    # depend on the compiler.
    once = {name for name, stop in before.items() if compiler != "native" and stop.is_smooth}
    repetitions = {
        stop.name: repeats_of(
            stop,
            count=1 if stop.name in once else repeats,
            lots=lots if compiler == "native" else 0,
            relative=relative,
        )
        for stop in selection.stops
    }
    directory = out / loaded.name
    problem = run_campaigns(
        [CampaignRun(campaign_of(selection, repetitions), directory)],
        workers=workers,
        fresh=fresh,
        import_from=import_from or (),
    )
    # A repeat without standstill counts as an infinite distance; a repeat that failed has no result, and nothing is
    # written.
    results = conditioning_of(selection, repetitions, directory, relative)
    kept = merged(results.stops, before, compiler)
    write_text(place, text_of(results.model_copy(update={"stops": others | kept})))
    rows = [
        {"stop": name, "shortest": stop.lowest, "median": stop.median, "longest": stop.highest, "spreads": stop.spreads}
        | ({"lots": stop.lots_text} if lots else {})
        for name, stop in results.stops.items()
    ]
    metres = dict.fromkeys(("shortest", "median", "longest"), "{:.2f} m")
    show_table(ReportTable(rows, {**metres, "spreads": yes_no}))
    say(str(place))
    if problem:
        raise typer.Exit(problem)


def discretisation(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="Campaign that names its file of conditioning.")],
    repeats: Annotated[
        int, typer.Option(min=1, max=1000, help="Repeats of each stop whose distance depends on rounding.")
    ] = 5,
    stops: Annotated[
        str, typer.Option(metavar="PATTERN", help="Only stops of such a name, as '*-slope_seeking'; others stay.")
    ] = "*",
    only: Annotated[Refinement | None, typer.Option(help="Only the steps, or only the tolerances.")] = None,
    workers: Workers = 2,
    fresh: Fresh = False,
) -> None:
    """Repeat stops with smaller steps and other tolerances.

    Communication steps are half and a quarter of that of the scenario, tolerances of the plant's solver 1e-4 to 1e-7.
    The distances are added to the file of conditioning, whose repeats have the whole step and the tolerance of the
    plant. `railgrip maintain validation` writes the tables of the documentation from it.
    """
    _, selection, place = _conditioned(file, stops, "the file of the repeats")
    before = read_conditioning(place)
    without: dict[str, str] = {}
    kinds: tuple[Refinement, ...] = ("steps", "tolerances")
    for of in kinds if only is None else (only,):
        with work("discretisation", workers=workers, fresh=fresh) as tasks:
            refined, reasons = with_refinement(selection, before, tasks, of=of, count=repeats)
        before = before.model_copy(update={"stops": before.stops | refined})
        without |= reasons
        write_text(place, text_of(before))
    for name, reason in without.items():
        say(f"{name}: {reason}")
    show_table(steps_table(selection))
    show_table(tolerances_table(selection))
    say(str(place))


def _conditioned(file: Path, stops: str, what: str) -> tuple[Campaign, Campaign, Path]:
    """Return a campaign, those of its stops whose names match a pattern, and its file of conditioning.

    Raises:
        ScenarioError: The campaign names no such file; `what` describes it.
    """
    loaded = load_campaign(file)
    if loaded.conditioning is None:
        raise ScenarioError(f"{file.name}: has no key 'conditioning'; it must name {what}")
    return loaded, loaded.only(lambda stop: fnmatch(stop.name, stops)), loaded.conditioning


def _previous_repeats(path: Path, relative: float) -> dict[str, RepeatedDistances]:
    before = read_conditioning(path)
    if before.relative != relative:
        raise ScenarioError(
            f"--relative {relative:g}: what stays in {path.name} was moved by {before.relative:g}; leave --stops out"
        )
    return before.stops


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


def _baseline_files(folder: Path) -> list[Path]:
    files = sorted(folder.glob("*.toml"))
    if not files:
        raise ScenarioError(
            f"{folder}: there is no baseline file (*.toml) in it; run in the folder of the project, give --baselines, "
            "or begin with `railgrip new regression stops.toml`"
        )
    return files
