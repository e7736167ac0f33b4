"""The command line.

Exit 0 a result, 2 a wrong question, 3 a run that failed; each with a sentence on standard error.
"""

import sys
from collections.abc import Callable, Sequence
from functools import partial
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from railgrip.bench.command import add_to as add_bench
from railgrip.console import complain, progress, remark, say, show_table
from railgrip.engine import Engine
from railgrip.errors import ScenarioError, for_user
from railgrip.estimation.command import add_to as add_estimate
from railgrip.map_command import add_to as add_map
from railgrip.report.panels import Panels
from railgrip.studies.field.command import add_to as add_field
from railgrip.studies.lateral.command import add_to as add_lateral
from railgrip.studies.learn.command import add_to as add_learn
from railgrip.studies.monitor.command import add_to as add_monitor

if TYPE_CHECKING:
    # Commands load what they need when they need it: a refusal or `--help` must not wait for CasADi.
    from railgrip.campaign import Asked
    from railgrip.controllers.tuning import SlipSource
    from railgrip.one_stop import Runner
    from railgrip.report.baseline import Baseline, Findings
    from railgrip.report.row import Row
    from railgrip.tune_control import Found

WRONG_QUESTION = 2
RUN_FAILED = 3

app = typer.Typer(
    name="railgrip",
    help="The open bench for railway braking at low adhesion.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
DrawnPanels = Annotated[Panels, typer.Option(help="Of which stops the panels are drawn.")]
File = Annotated[Path, typer.Argument(metavar="FILE.toml", help="Scenario or campaign file.")]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="table.key=value", help="Change a value, as in start.speed='100 km/h'; repeatable."),
]
ImportFrom = Annotated[
    list[Path] | None,
    typer.Option(
        "--import-from",
        metavar="DIR",
        help="Folder of modules that a scenario names as module:Class; their code runs. Repeatable.",
    ),
]
Workers = Annotated[int, typer.Option(min=1, max=64, help="Processes.")]
BASELINES = Path("tests/baselines")
REGRESS = Path("build/regress")


@app.command()
def run(
    file: File,
    overrides: Overrides = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the result; build/runs/NAME unless given.")] = None,
    engine: Annotated[Engine, typer.Option(help="What steps the parties; the result is the same.")] = Engine.AUTO,
    import_from: ImportFrom = None,
) -> None:
    """Run one scenario and print its figures."""
    from railgrip.one_stop import run as run_scenario
    from railgrip.scenario.load import load

    scenario = load(file, overrides or [])
    directory = out or Path("build/runs") / scenario.name
    with progress(scenario.name, scenario.start.speed) as shown:
        stop = run_scenario(
            scenario,
            directory,
            _runner(engine, import_from or ()),
            lambda speed: shown.update(done=scenario.start.speed - speed),
            remark,
        )
    metrics = stop.metrics
    # A plant from outside may not show its adhesion; then there is no share of it to tell.
    used = f", {100 * metrics.utilisation:.1f} % of the possible adhesion used" if isfinite(metrics.utilisation) else ""
    if metrics.utilisation > 1.001:  # physics allows it: the possible also ends at what the operator allows
        used += (
            f" ([limits] alpha_max {scenario.limits.alpha_max:g} exceeded for {max(metrics.time_over_alpha_max):.2f} s)"
        )
    say(f"{scenario.name}: {stop.outcome.value}, {metrics.distance:.2f} m in {metrics.duration:.2f} s{used}")
    for sentence in metrics.doubts():
        say(f"{scenario.name}: {sentence}")
    say(f"{directory}/stop.json")
    if stop.outcome.value != "standstill":
        _fail(f"{scenario.name}: no braking distance, the stop ended with {stop.outcome.value}: {stop.reason}")


@app.command()
def export(
    file: File,
    overrides: Overrides = None,
    out: Annotated[Path | None, typer.Option(help="The FMU; build/NAME-CONTROLLER.fmu unless given.")] = None,
) -> None:
    """Make an FMU of a scenario's controller, valve logic included, for another tool on this platform."""
    from railgrip.one_stop import make_folder
    from railgrip.scenario.load import load

    scenario = load(file, overrides or [])
    place = out or Path("build") / f"{scenario.name}-{scenario.controller.kind}.fmu"
    make_folder(place.parent, place.name)
    # CasADi and the compiler come after the questions that need neither.
    from railgrip.export import controller_fmu
    from railgrip.fmus.native.package import pack

    made = pack(controller_fmu(scenario), place)
    say(str(made))


@app.command()
def campaign(
    files: Annotated[list[Path], typer.Argument(metavar="FILE.toml ...", help="Campaign files.")],
    overrides: Overrides = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for results, DIR/NAME for several campaigns; build/NAME unless given."),
    ] = None,
    workers: Workers = 2,
    fresh: Annotated[bool, typer.Option(help="Run also what already has a result.")] = False,
    panels: Annotated[
        Panels | None, typer.Option(help="Of which stops the panels are drawn, whatever the campaigns say.")
    ] = None,
    import_from: ImportFrom = None,
) -> None:
    """Run the stops of campaigns, keep what is done, and write table, figures and report of each."""
    from railgrip.campaign import Asked
    from railgrip.report.distances import rows_of
    from railgrip.report.index import write_report
    from railgrip.report.results import read_results
    from railgrip.scenario.campaign import load_campaign

    planned = [load_campaign(file, overrides or []) for file in files]
    own = out if out is not None and len(files) == 1 else None
    asked = [Asked(one, own or (out or Path("build")) / one.name) for one in planned]
    twice = next((one for one in asked if [a.directory for a in asked].count(one.directory) > 1), None)
    if twice is not None:
        raise ScenarioError(f"two campaigns are named '{twice.campaign.name}' and would share {twice.directory}")

    def draw(number: int, drawing: Callable[[str], None]) -> None:
        one = asked[number]
        write_report(one.directory, panels=panels or Panels(one.campaign.panels), tell=drawing)

    problem = _run_campaigns(asked, workers=workers, fresh=fresh, finished=draw, import_from=import_from or ())
    for one in asked:
        _show_distances(rows_of(read_results(one.directory)))
        say(f"{one.directory}/index.html")
    if problem:
        raise typer.Exit(problem)


@app.command()
def conditioning(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="Campaign that names its file of conditioning.")],
    repeats: Annotated[int, typer.Option(min=2, max=1000, help="Of each stop.")] = 20,
    relative: Annotated[float, typer.Option(min=1e-15, max=1e-2, help="Most that a parameter moves by.")] = 1e-7,
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("build/conditioning"),
    workers: Workers = 2,
    fresh: Annotated[bool, typer.Option(help="Run also what already has a result.")] = False,
) -> None:
    """Repeat the stops of a campaign with the plant's parameters moved a little; write how far distances spread."""
    from railgrip.atomic import write_text
    from railgrip.campaign import Asked
    from railgrip.conditioning import campaign_of, conditioning_of, repeats_of
    from railgrip.report.table import Table, yes_no
    from railgrip.scenario.campaign import load_campaign
    from railgrip.scenario.conditioning import text_of

    whole = load_campaign(file)
    if whole.conditioning is None:
        raise ScenarioError(f"{file.name}: has no key 'conditioning'; it names the file that is to be written")
    repeated = {stop.name: repeats_of(stop, count=repeats, relative=relative) for stop in whole.stops}
    directory = out / whole.name
    problem = _run_campaigns([Asked(campaign_of(whole, repeated), directory)], workers=workers, fresh=fresh)
    # A repeat without standstill is a result, an endless distance; one that failed is none: nothing is written.
    found = conditioning_of(whole, repeated, directory, relative)
    write_text(whole.conditioning, text_of(found))
    rows = [
        {"stop": name, "shortest": stop.lowest, "median": stop.median, "longest": stop.highest, "spreads": stop.spreads}
        for name, stop in found.stops.items()
    ]
    metres = dict.fromkeys(("shortest", "median", "longest"), "{:.2f} m")
    show_table(Table(rows, {**metres, "spreads": yes_no}))
    say(str(whole.conditioning))
    if problem:
        raise typer.Exit(problem)


@app.command()
def report(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a run or of a campaign.")],
    panels: DrawnPanels = Panels.ALL,
) -> None:
    """Make one page of table, figures and definitions from the results in a folder."""
    from railgrip.report.index import write_report

    with progress("report") as shown:
        page = write_report(directory, panels=panels, tell=lambda what: shown.update(doing=f"drawing {what}"))
    say(str(page))


@app.command()
def regress(
    baselines: Annotated[Path, typer.Option(help="Folder of baseline files.")] = BASELINES,
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = REGRESS,
    workers: Workers = 2,
    across_compilers: Annotated[
        bool, typer.Option("--across-compilers", help="Campaigns alone, with FMUs of another compiler: within 0.5 %.")
    ] = False,
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
        code, findings = _found(baseline, path, out / path.stem, workers)
        problem = code or problem
        comparisons = compare(baseline, findings)
        show_table(comparison_table(comparisons, path.name), "nothing changed")
        strayed = [comparison.name for comparison in comparisons if comparison.state != "kept"]
        if strayed:
            problem = RUN_FAILED
            what = "stops" if baseline.campaign is not None else "figures"
            complain(
                f"{path.name}: {len(strayed)} of {len(comparisons)} {what} did not keep to their baseline: "
                f"{', '.join(strayed)}; if that is right, `railgrip accept --reason '…'`"
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
    from railgrip.report.baseline import (
        accepted,
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
        after = accepted(baseline, findings, reason)
        # What kept to its tolerance may have become a range all the same.
        moved = tuple(
            comparison
            for comparison in compare(baseline, findings)
            if after.accepted.get(comparison.name) != baseline.accepted.get(comparison.name)
        )
        write_baseline(after, path)
        show_table(comparison_table(moved, f"{path.name}: accepted"), "nothing changed")


@app.command()
def calibrate() -> None:
    """Fit the levels of the scenarios to the published distances of slip-based control, and write them."""
    from railgrip.calibrate import TARGETS
    from railgrip.calibrate import calibrate as fit_levels

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
    out: Annotated[Path, typer.Option(help="Folder of the files of parameters.")] = Path("controllers"),
    workers: Workers = 2,
) -> None:
    """Search the parameters of the control laws on the training rails, and write a file for each law."""
    from railgrip.atomic import write_text
    from railgrip.one_stop import make_folder
    from railgrip.tune_control import RANGES, search, text_of
    from railgrip.workers import workers as processes

    unknown = sorted(set(law or ()) - RANGES.keys())
    if unknown:
        raise ScenarioError(f"tune-control: --law {unknown[0]} is not searched; there is {', '.join(RANGES)}")
    make_folder(out)

    def note(name: str, number: int, best: float) -> None:
        say(f"{name}, generation {number}: {100 * best:+.2f} % against slip-based control")

    with processes(workers) as pool:
        for each in law or RANGES:
            found: dict[tuple[str, SlipSource], Found] = {}
            for actuation, slip in RANGES[each]:
                name = f"{each}, {actuation} actuation, {slip} slip"
                with progress(name):
                    found[actuation, slip] = search(each, actuation, slip, partial(note, name), pool)
                say(text_of(each, {(actuation, slip): found[actuation, slip]}))
            write_text(out / f"{each}.toml", text_of(each, found))


@app.command()
def readme(
    path: Annotated[Path, typer.Option("--readme", help="The file with the table.")] = Path("README.md"),
    baseline: Annotated[Path, typer.Option(help="The accepted distances.")] = BASELINES / "table1.toml",
) -> None:
    """Write the accepted braking distances into README's table."""
    from railgrip.report.baseline import load_baseline
    from railgrip.report.readme import write_readme
    from railgrip.scenario.campaign import load_campaign

    accepted = load_baseline(baseline)
    if accepted.campaign is None:
        raise ScenarioError(f"{baseline}: is the baseline of a study; the table is that of a campaign")
    write_readme(path, load_campaign(baseline.parent / accepted.campaign), accepted)
    say(str(path))


add_map(app)
add_estimate(app)
add_bench(app)
add_lateral(app)
add_monitor(app)
add_field(app)
add_learn(app)


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; a user's mistake ends in a sentence, never in a traceback."""
    try:
        app(arguments)
    except Exception as problem:
        message = for_user(problem)
        if message is None:
            raise
        complain(str(message))
        sys.exit(message.exit_code)


def _runner(engine: Engine = Engine.AUTO, import_from: Sequence[Path] = ()) -> "Runner":
    # Loaded only when something runs: it brings CasADi and the FMU loader, and `report` needs neither.
    from railgrip.assemble import run_stop

    if not import_from:
        return partial(run_stop, engine=engine)
    from railgrip.assemble import OwnParties

    return partial(run_stop, engine=engine, own=OwnParties(folders=tuple(import_from)))


def _run_campaigns(
    asked: "Sequence[Asked]",
    *,
    workers: int,
    fresh: bool,
    finished: Callable[[int, Callable[[str], None]], None] = lambda number, drawing: None,
    import_from: Sequence[Path] = (),
) -> int:
    """Run campaigns with progress; return the exit code that their stops call for.

    `finished` is called with the number of a campaign that is complete, and with what tells the user of its doing.
    """
    from railgrip.campaign import Report, run_campaigns

    names = ", ".join(one.campaign.name for one in asked)
    with progress(names, sum(len(one.campaign.stops) for one in asked), counted=True) as shown:

        def tell(report: Report) -> None:
            shown.advance()
            if report.state not in {"found", "done"}:
                complain(f"{report.stop.name}: {report.sentence}")

        def complete(number: int) -> None:
            finished(number, lambda what: shown.update(doing=f"drawing {what}"))
            shown.update(doing="")

        reports = run_campaigns(
            asked, _runner(import_from=import_from), workers=workers, fresh=fresh, tell=tell, finished=complete
        )
    states = {report.state for reported in reports for report in reported}
    if "refused" in states:
        return WRONG_QUESTION
    return RUN_FAILED if states & {"failed", "ended_badly"} else 0


def _found(baseline: "Baseline", path: Path, out: Path, workers: int) -> "tuple[int, Findings]":
    """Run what a baseline is of; return the exit code that it calls for, and its numbers."""
    from railgrip.campaign import Asked
    from railgrip.report.baseline import findings_of, write_findings
    from railgrip.report.results import read_results
    from railgrip.scenario.campaign import load_campaign

    if baseline.campaign is not None:
        asked = [Asked(load_campaign(path.parent / baseline.campaign), out)]
        code = _run_campaigns(asked, workers=workers, fresh=False)
        return code, findings_of(read_results(out))
    from railgrip.studies.headlines import headlines

    with progress(path.stem) as shown:
        findings = headlines(str(baseline.study), lambda what: shown.update(doing=what))
    write_findings(findings, out)
    return 0, findings


def _baseline_files(folder: Path) -> list[Path]:
    found = sorted(folder.glob("*.toml"))
    if not found:
        raise ScenarioError(f"{folder}: there is no baseline file (*.toml) in it")
    return found


def _show_distances(rows: "Sequence[Row]") -> None:
    from railgrip.report.distances import tables_of

    drawn, single = tables_of(rows)
    if drawn:
        show_table(drawn)
    if single or not drawn:
        show_table(single.without(_NOT_ON_SCREEN), "no results")


_NOT_ON_SCREEN = frozenset(
    {"estimator", "repeated", "duration", "longest lock", "valve strokes", "air", "NIS", "outside ±2σ"}
)
"""Columns of the table that a screen has no room for."""


def _fail(sentence: str) -> NoReturn:
    complain(sentence)
    raise typer.Exit(RUN_FAILED)
