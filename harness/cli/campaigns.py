"""Many stops: campaigns, their reports and baselines, and what is searched over them."""

import tomllib
from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatch
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from railgrip.cli.app import RUN_FAILED, Fresh, ImportFrom, Overrides, Workers, app
from railgrip.cli.runs import runner
from railgrip.console import complain, progress, say, show_table
from railgrip.errors import ScenarioError

if TYPE_CHECKING:
    from railgrip.campaign.run import CampaignRun
    from railgrip.campaign.tune_control import Optimum
    from railgrip.controllers.tuned import SlipSource
    from railgrip.report.baseline import Baseline, Findings
    from railgrip.report.row import Row
    from railgrip.scenario.conditioning import Repeated

Panels = Literal["all", "abc", "none"]
"""As `railgrip.scenario.campaign` has them, which takes longer to load than a sentence may."""
BASELINES = Path("tests/baselines")
REGRESS = Path("build/regress")


@app.command()
def campaign(
    files: Annotated[list[Path], typer.Argument(metavar="FILE.toml ...", help="Campaign files.")],
    overrides: Overrides = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for results, DIR/NAME for several campaigns; build/NAME unless given."),
    ] = None,
    workers: Workers = 2,
    fresh: Fresh = False,
    panels: Annotated[
        Panels | None, typer.Option(help="Of which stops the panels are drawn, whatever the campaigns say.")
    ] = None,
    import_from: ImportFrom = None,
) -> None:
    """Run the stops of campaigns, keep what is done, and write table, figures and report of each."""
    from railgrip.campaign.run import CampaignRun
    from railgrip.report.baseline import beyond_accepted
    from railgrip.report.distances import rows_of
    from railgrip.report.results import by_compiler, read_results
    from railgrip.scenario.campaign import load_campaign

    campaigns = [load_campaign(file, overrides or []) for file in files]
    # Accepted distances are of the campaign as its file has it.
    baselines = [None if overrides else BASELINES / file.name for file in files]
    own = out if out is not None and len(files) == 1 else None
    runs = [CampaignRun(one, own or (out or Path("build")) / one.name) for one in campaigns]
    twice = next((one for one in runs if [a.directory for a in runs].count(one.directory) > 1), None)
    if twice is not None:
        raise ScenarioError(f"two campaigns are named '{twice.campaign.name}' and would share {twice.directory}")

    def draw(number: int, drawing: Callable[[str], None]) -> None:
        from railgrip.report.index import write_report  # takes half a second to load, in which stops may run already

        one = runs[number]
        write_report(one.directory, panels=panels or one.campaign.panels, notify=drawing, baseline=baselines[number])

    problem = _run_campaigns(runs, workers=workers, fresh=fresh, on_complete=draw, import_from=import_from or ())
    for one, baseline in zip(runs, baselines, strict=True):
        results = read_results(one.directory)
        _show_distances(rows_of(results))
        for sentence in by_compiler(results.stops):
            say(sentence)
        for sentence in [] if baseline is None else beyond_accepted(results, baseline):
            complain(sentence)
        say(f"{one.directory}/index.html")
    if problem:
        raise typer.Exit(problem)


@app.command()
def conditioning(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="Campaign that names its file of conditioning.")],
    repeats: Annotated[int, typer.Option(min=2, max=1000, help="Of each stop.")] = 20,
    relative: Annotated[float, typer.Option(min=1e-15, max=1e-2, help="Most that a parameter moves by.")] = 1e-7,
    stops: Annotated[
        str, typer.Option(metavar="PATTERN", help="Only stops of such a name, as '*-slope_seeking'; others stay.")
    ] = "*",
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("build/conditioning"),
    workers: Workers = 2,
    fresh: Fresh = False,
    import_from: ImportFrom = None,
) -> None:
    """Repeat the stops of a campaign with the plant's parameters moved a little; write how far distances spread."""
    from railgrip.campaign.conditioning import campaign_of, conditioning_of, repeats_of
    from railgrip.campaign.run import CampaignRun
    from railgrip.files import write_text
    from railgrip.report.table import Table, yes_no
    from railgrip.scenario.campaign import load_campaign
    from railgrip.scenario.conditioning import text_of

    whole = load_campaign(file)
    if whole.conditioning is None:
        raise ScenarioError(f"{file.name}: has no key 'conditioning'; it names the file that is to be written")
    selection = whole.only(lambda stop: fnmatch(stop.name, stops))
    if not selection.stops:
        raise ScenarioError(f"--stops {stops}: {file.name} has no such stop; it has {whole.stops[0].name} and others")
    others = {} if stops == "*" else _repeated_before(whole.conditioning, relative)
    repetitions = {stop.name: repeats_of(stop, count=repeats, relative=relative) for stop in selection.stops}
    directory = out / whole.name
    problem = _run_campaigns(
        [CampaignRun(campaign_of(selection, repetitions), directory)],
        workers=workers,
        fresh=fresh,
        import_from=import_from or (),
    )
    # A repeat without standstill is a result, an endless distance; one that failed is none: nothing is written.
    results = conditioning_of(selection, repetitions, directory, relative)
    write_text(whole.conditioning, text_of(results.model_copy(update={"stops": others | results.stops})))
    rows = [
        {"stop": name, "shortest": stop.lowest, "median": stop.median, "longest": stop.highest, "spreads": stop.spreads}
        for name, stop in results.stops.items()
    ]
    metres = dict.fromkeys(("shortest", "median", "longest"), "{:.2f} m")
    show_table(Table(rows, {**metres, "spreads": yes_no}))
    say(str(whole.conditioning))
    if problem:
        raise typer.Exit(problem)


def _repeated_before(path: Path, relative: float) -> "dict[str, Repeated]":
    from railgrip.scenario.conditioning import read_conditioning

    before = read_conditioning(path)
    if before.relative != relative:
        raise ScenarioError(
            f"--relative {relative:g}: what stays in {path.name} was moved by {before.relative:g}; leave --stops out"
        )
    return before.stops


@app.command()
def report(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a run or of a campaign.")],
    panels: Annotated[Panels, typer.Option(help="Of which stops the panels are drawn.")] = "all",
) -> None:
    """Make one page of table, figures and definitions from the results in a folder."""
    from railgrip.report.index import write_report

    with progress("report") as bar:
        page = write_report(directory, panels=panels, notify=lambda what: bar.update(doing=f"drawing {what}"))
    say(str(page))


@app.command()
def regress(
    baselines: Annotated[Path, typer.Option(help="Folder of baseline files.")] = BASELINES,
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = REGRESS,
    workers: Workers = 2,
    across_compilers: Annotated[
        bool, typer.Option("--across-compilers", help="Campaigns alone, with FMUs of another compiler: within 0.5 %.")
    ] = False,
    import_from: ImportFrom = None,
) -> None:
    """Run the campaigns and studies that have baselines and compare every number with what was accepted."""
    from railgrip.report.baseline import compare, comparison_table, load_baseline

    problem = 0
    for path in _baseline_files(baselines):
        baseline = load_baseline(path)
        if across_compilers:
            if baseline.campaign is None:
                continue
            baseline = baseline.across_compilers()
        code, findings = _numbers_of(baseline, path, out / path.stem, workers, import_from or ())
        problem = code or problem
        comparisons = compare(baseline, findings)
        show_table(comparison_table(comparisons, path.name), "nothing changed")
        deviations = [comparison.name for comparison in comparisons if comparison.state != "kept"]
        if deviations:
            problem = RUN_FAILED
            what = "stops" if baseline.campaign is not None else "figures"
            complain(
                f"{path.name}: {len(deviations)} of {len(comparisons)} {what} did not keep to their baseline: "
                f"{', '.join(deviations)}; if that is right, `railgrip accept --reason '…'`"
            )
    if problem:
        raise typer.Exit(problem)


@app.command()
def accept(
    reason: Annotated[str, typer.Option(help="What changed, and why the new numbers are right.")],
    baselines: Annotated[Path, typer.Option(help="Folder of baseline files.")] = BASELINES,
    out: Annotated[Path, typer.Option(help="Folder of the results of the last regress.")] = REGRESS,
) -> None:
    """Move the baselines to the results of the last regress, for a reason."""
    from railgrip.report.baseline import accept as accept_numbers
    from railgrip.report.baseline import (
        compare,
        comparison_table,
        findings_of,
        load_baseline,
        read_findings,
        write_baseline,
    )
    from railgrip.report.results import read_results

    for path in _baseline_files(baselines):
        baseline, folder = load_baseline(path), out / path.stem
        findings = read_findings(folder) if baseline.campaign is None else findings_of(read_results(folder))
        after = accept_numbers(baseline, findings, reason)
        # What kept to its tolerance may have become a range all the same.
        changes = tuple(
            comparison
            for comparison in compare(baseline, findings)
            if after.accepted.get(comparison.name) != baseline.accepted.get(comparison.name)
        )
        write_baseline(after, path)
        show_table(comparison_table(changes, f"{path.name}: accepted"), "nothing changed")


@app.command()
def calibrate() -> None:
    """Fit the levels of the scenarios to the published distances of slip-based control, and write them."""
    from railgrip.campaign.calibrate import TARGETS
    from railgrip.campaign.calibrate import calibrate as fit_levels

    with progress("levels, some ten stops each"):
        fit_levels(
            lambda one: say(
                f"{one.scenario}, {one.shape}: level {one.level:.5f}, {one.distance:.1f} m "
                f"(wanted {TARGETS[one.scenario]} m)"
            )
        )


@app.command("tune-control")
def tune_control(
    law: Annotated[list[str] | None, typer.Option(help="A law to search; all without it.")] = None,
    out: Annotated[Path, typer.Option(help="Folder of the files of parameters.")] = Path("controllers/laws"),
    budget: Annotated[
        int | None,
        typer.Option(min=5, help="Sets of parameters to try for each law; 24 for each parameter without it."),
    ] = None,
    cases: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=1000,
            help="So many short training cases of the type test in place of the rails, for its own set.",
        ),
    ] = None,
    workers: Workers = 2,
) -> None:
    """Search the parameters of the control laws on the training rails, and write a file for each law.

    What is not searched of a law stays in its file as it is. What --cases finds of a law that the tables of the papers
    hang on goes into a file of its own, `<law>.type_test.toml`.
    """
    from railgrip.campaign.one_stop import make_folder
    from railgrip.campaign.tune_control import EQUIPMENT, RANGES, search, set_of, text_of
    from railgrip.campaign.workers import workers as processes
    from railgrip.controllers.tuned import file_of
    from railgrip.files import write_text

    unknown = sorted(set(law or ()) - RANGES.keys())
    if unknown:
        raise ScenarioError(f"tune-control: --law {unknown[0]} is not searched; there is {', '.join(RANGES)}")
    make_folder(out)

    def note(name: str, number: int, best: float) -> None:
        say(f"{name}, generation {number}: {100 * best:+.2f} % against slip-based control")

    stops, kinds = None, frozenset(EQUIPMENT)
    if cases is not None:
        from railgrip.studies.type_test.entrants import training

        stops, kinds = training(cases), frozenset({"pneumatic"})
    options = {"--cases": cases, "--budget": budget}
    with processes(workers) as pool:
        for each in law or RANGES:
            optima: dict[tuple[str, SlipSource], Optimum] = {}
            for actuation, slip in (kind for kind in RANGES[each] if kind[0] in kinds):
                name = f"{each}, {actuation} actuation, {slip} slip"
                with progress(name):
                    notify = partial(note, name)
                    optima[actuation, slip] = search(
                        each, actuation, slip, notify, pool, rail_stops=stops, budget=budget
                    )
                say(text_of(each, {(actuation, slip): optima[actuation, slip]}))
            command = " ".join(
                (
                    f"railgrip tune-control --law {each}",
                    *(f"{name} {value}" for name, value in options.items() if value),
                )
            )
            path = out / file_of(each, set_of(each, type_test=cases is not None))
            text = text_of(each, optima, command if any(options.values()) else "make tune-control")
            write_text(path, text + _others(path, optima))


def _others(path: Path, optima: "Mapping[tuple[str, SlipSource], Optimum]") -> str:
    """Return the tables of a file of parameters that were not searched."""
    sets = tomllib.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    lines: list[str] = []
    for actuation, slip in ((a, s) for a, of in sets.items() for s in of if (a, s) not in optima):
        values = sets[actuation][slip]
        lines += ["", "# Not searched then.", f"[{actuation}.{slip}]", *(f"{k} = {v!r}" for k, v in values.items())]
    return "".join(f"{line}\n" for line in lines)


@app.command()
def readme(
    page: Annotated[Path, typer.Option(help="The file with the table.")] = Path("docs/validation.md"),
    baseline: Annotated[Path, typer.Option(help="The accepted distances.")] = BASELINES / "table1.toml",
) -> None:
    """Write the accepted braking distances into the table of docs/validation.md."""
    from railgrip.report.baseline import load_baseline
    from railgrip.report.validation import write_table
    from railgrip.scenario.campaign import load_campaign

    accepted = load_baseline(baseline)
    if accepted.campaign is None:
        raise ScenarioError(f"{baseline}: is the baseline of a study; the table is that of a campaign")
    write_table(page, load_campaign(baseline.parent / accepted.campaign), accepted)
    say(str(page))


def _run_campaigns(
    runs: "Sequence[CampaignRun]",
    *,
    workers: int,
    fresh: bool,
    on_complete: Callable[[int, Callable[[str], None]], None] = lambda number, drawing: None,
    import_from: Sequence[Path] = (),
) -> int:
    """Run campaigns with progress; return the exit code that their stops call for.

    `on_complete` is called with the number of a campaign that is complete, and with what tells the user of its doing.
    """
    from railgrip.campaign.work import work

    with work(", ".join(one.campaign.name for one in runs), workers=workers, fresh=fresh) as own:

        def complete(number: int) -> None:
            on_complete(number, lambda what: own.notify(f"drawing {what}"))
            own.notify("")

        return own.stops(runs, runner(import_from=import_from), on_complete=complete)


def _numbers_of(
    baseline: "Baseline", path: Path, out: Path, workers: int, import_from: Sequence[Path]
) -> "tuple[int, Findings]":
    """Run what a baseline is of; return the exit code that it calls for, and its numbers."""
    from railgrip.campaign.run import CampaignRun
    from railgrip.report.baseline import findings_of, write_findings
    from railgrip.report.results import read_results
    from railgrip.scenario.campaign import load_campaign

    if baseline.campaign is not None:
        runs = [CampaignRun(load_campaign(path.parent / baseline.campaign), out)]
        code = _run_campaigns(runs, workers=workers, fresh=False, import_from=import_from)
        return code, findings_of(read_results(out))
    from railgrip.studies.study import headlines

    findings = headlines(str(baseline.study), workers=workers)
    write_findings(findings, out)
    return 0, findings


def _baseline_files(folder: Path) -> list[Path]:
    files = sorted(folder.glob("*.toml"))
    if not files:
        raise ScenarioError(f"{folder}: there is no baseline file (*.toml) in it")
    return files


def _show_distances(rows: "Sequence[Row]") -> None:
    from railgrip.report.distances import tables_of

    draws, single = tables_of(rows)
    if draws:
        show_table(draws)
    if single or not draws:
        show_table(single.without(_NOT_ON_SCREEN), "no results")


_NOT_ON_SCREEN = frozenset(
    {"estimator", "repeated", "duration", "longest lock", "valve strokes", "air", "NIS", "outside ±2σ"}
)
"""Columns of the table that a screen has no room for."""
