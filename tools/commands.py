"""Commands for work on railgrip itself: repeat stops, fit levels, survey FMUs, execute pages, judge tests.

`python tools conditioning FILE.toml`, from the folder of the project; the package contains none of these.
"""

import shutil
from collections.abc import Callable
from dataclasses import asdict
from fnmatch import fnmatch
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from calibration import calibrate
from compilers import compare
from conditioning import Refinement, campaign_of, conditioning_of, merged, repeats_of, with_refinement
from floors import floors
from fmu_survey import survey, survey_table
from installed_sizes import sizes_table
from microcontroller import target
from mutants import mutants
from study_pages import execute
from study_pages import pages as all_pages
from suites import suites
from validation import (
    BASELINE,
    CONVERGENCE,
    CONVERGENCE_CAMPAIGNS,
    FILE,
    TABLES,
    compilers_table,
    distances_figure,
    medians_table,
    steps_table,
    tolerances_table,
    with_distances,
)

from railgrip.base.errors import InputError, ScenarioError
from railgrip.base.files import write_text
from railgrip.base.registry import shelf
from railgrip.campaign.run import CampaignRun
from railgrip.campaign.work import call, work
from railgrip.cli.app import BASELINES, Fresh, ImportFrom, Workers, command_of, program
from railgrip.cli.campaigns import run_campaigns
from railgrip.estimation.field_test.filtering import (
    TUNING,
    cases,
    divergence_time,
    equations,
    filter_of,
    follow,
    run,
    save_noise,
    task_of,
)
from railgrip.estimation.field_test.score import DIVERGED, Generations, Kind, Search
from railgrip.estimation.field_test.score import tune as search_for
from railgrip.fmus.build import Compiler, choose
from railgrip.report.baseline import Baseline, load_baseline, write_baseline
from railgrip.report.console import answer, progress, say, show_table
from railgrip.report.results import read_results
from railgrip.report.style import save
from railgrip.report.table import ReportTable, write_tables, yes_no
from railgrip.scenario.campaign import Campaign, load_campaign
from railgrip.scenario.conditioning import RepeatedDistances, read_conditioning, text_of

FOREIGN = Path("docs/foreign_fmus.md")
INSTALL = Path("docs/how_to/install.md")
COMPILERS = Path("docs/how_to/compilers.md")


def validation(
    baselines: Annotated[Path, typer.Option(help="Folder of baseline files.")] = BASELINES,
    docs: Annotated[Path, typer.Option(help="Folder of the pages.")] = Path("docs"),
    openmodelica: Annotated[
        Path | None,
        typer.Option(help="Folder of the results of `make regress-omc`, whose distances the baselines get before."),
    ] = None,
) -> None:
    """Write the accepted distances into the documentation."""
    compared: dict[str, tuple[Campaign, Baseline]] = {}
    for name in TABLES:
        path = baselines / f"{name}.toml"
        accepted = _baseline_of_campaign(path)
        if openmodelica is not None:
            accepted = with_distances(accepted, read_results(openmodelica / name))
            write_baseline(accepted, path)
        compared[name] = load_campaign(path.parent / str(accepted.campaign)), accepted
    figure, numbers = distances_figure(*compared[BASELINE])
    say(str(save(figure, docs / FILE, numbers)))
    for name, (page, tables_of) in TABLES.items():
        write_tables(docs / page, tables_of(*compared[name]))
        say(str(docs / page))
    campaigns = [load_campaign(shelf("campaigns")[name]) for name in CONVERGENCE_CAMPAIGNS]
    write_tables(docs / CONVERGENCE, {"tolerances": tolerances_table(*campaigns), "medians": medians_table(*campaigns)})
    write_tables(docs / CONVERGENCE, {"compilers": compilers_table(*compared.values())})


def _baseline_of_campaign(path: Path) -> Baseline:
    accepted = load_baseline(path)
    if accepted.campaign is None:
        raise ScenarioError(f"{path}: is the baseline of a study, but the table shows a campaign")
    return accepted


Conditioned = Annotated[Path, typer.Argument(metavar="FILE.toml", help="Campaign that names its file of conditioning.")]
Stops = Annotated[
    str, typer.Option(metavar="PATTERN", help="Only stops of such a name, as '*-slope_seeking'; others stay.")
]


def conditioning(
    file: Conditioned,
    repeats: Annotated[int, typer.Option(min=2, max=1000, help="Of each stop.")] = 20,
    relative: Annotated[float, typer.Option(min=1e-15, max=1e-2, help="Largest change of a parameter.")] = 1e-7,
    lots: Annotated[
        int, typer.Option(min=0, max=1000, help="Number of sensor lots, for stops whose sensors have errors.")
    ] = 20,
    stops: Stops = "*",
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
    file: Conditioned,
    repeats: Annotated[
        int, typer.Option(min=1, max=1000, help="Repeats of each stop whose distance depends on rounding.")
    ] = 5,
    stops: Stops = "*",
    only: Annotated[Refinement | None, typer.Option(help="Only the steps, or only the tolerances.")] = None,
    workers: Workers = 2,
    fresh: Fresh = False,
) -> None:
    """Repeat stops with smaller steps and other tolerances.

    Communication steps are half and a quarter of that of the scenario, tolerances of the plant's solver 1e-4 to 1e-7.
    The distances are added to the file of conditioning, whose repeats have the whole step and the tolerance of the
    plant. `make validation` writes the tables of the documentation from it.
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


def tune(
    kind: Annotated[Kind, typer.Argument(help="Objective.")],
    out: Annotated[Path, typer.Option(help="File for the noises.")],
    campaign: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="Cases of a field test; field_test unless given.")
    ] = None,
    population: Annotated[int, typer.Option(min=8, help="Candidates of the differential evolution.")] = 48,
    generations: Annotated[int, typer.Option(min=1, help="Generations in all.")] = 60,
    stage: Annotated[int, typer.Option(min=1, help="Generations that are kept together.")] = 10,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all random numbers.")] = 1,
    workers: Annotated[int, typer.Option(min=1, max=64, help="Threads, or processes.")] = 2,
    import_from: ImportFrom = None,
) -> None:
    """Search the twelve noises of the field test's filter."""
    search = Search(population=population, generations=generations, stage=stage, seed=seed)
    with work("field_test", workers=workers) as job:
        one_run = partial(run, import_from=tuple(import_from or ()))
        field_runs = job.map(one_run, list(cases(campaign, TUNING).items()), keep=not import_from)
        model = equations()
        tasks = [task_of(field_run.braking, model) for field_run in field_runs]

        def run_stage(stage: Callable[[], Generations]) -> Generations:
            (found,) = job.map(call, [stage])
            job.notify(f"best {found[1]:.6f} m/s")
            return found

        noise, value, history = search_for(kind, tasks, search, job.count, run_stage)
    options = " ".join(f"--{name} {value}" for name, value in asdict(search).items())
    save_noise(
        noise,
        out,
        title=f"Noises of the field test's filter, tuned on {', '.join(TUNING)}; objective '{kind}'.",
        command=f"python tools tune {kind} {options} --out {out}",
        results={"objective": value, "generations": float(len(history))},
    )
    say(f"{kind}: {value:.6f} m/s after {len(history)} generations")
    filter_ = filter_of(model, tasks[0].data.period)
    for case, task in zip(TUNING, tasks, strict=True) if value < DIVERGED else ():
        instant = divergence_time(task, follow(task, filter_, noise))
        if instant is not None:
            say(f"Case {case}: the filter is lost from {instant:.2f} s on, its innovations are far beyond its claims.")
    say(str(out))


def fmus(
    folder: Annotated[Path, typer.Argument(exists=True, file_okay=False, help="Folder of FMUs, searched recursively.")],
    out: Annotated[Path, typer.Option(help="File for one line per FMU.")] = Path("build/fmus.csv"),
    write: Annotated[bool, typer.Option("--write", help=f"Write the table into {FOREIGN}.")] = False,
) -> None:
    """Open and step the FMUs of a folder; write a table.

    Each FMU runs in a separate process. The file gives the reason for each that does not step.
    """
    with progress("survey", "stepping FMUs"):
        rows = survey(folder)
    if rows.empty:
        raise InputError(f"{folder}: contains no file *.fmu, not even in subfolders.")
    out.parent.mkdir(parents=True, exist_ok=True)
    ReportTable.of_frame(rows).write_csv(out)
    _show(survey_table(rows), FOREIGN if write else None, "fmus")


def sizes(write: Annotated[bool, typer.Option("--write", help=f"Write the table into {INSTALL}.")] = False) -> None:
    """Print the sizes of the packages that an installation consists of."""
    _show(sizes_table(), INSTALL if write else None, "sizes")


def _show(table: ReportTable, page: Path | None, name: str) -> None:
    """Show a table, and write it between its marks of a page, if there is one."""
    show_table(table)
    if page is not None:
        write_tables(page, {name: table})


def compilers(
    suites: Annotated[Path, typer.Option(help="Folder of the results of `make suites`.")] = Path("build/suites"),
    write: Annotated[bool, typer.Option("--write", help=f"Write the table into {COMPILERS}.")] = False,
) -> None:
    """Measure what each compiler covers, takes and needs.

    Without omc on the PATH only the built-in compiler is measured. Cells of suites without results are empty.
    """
    compilers: list[Compiler] = ["native", "openmodelica"] if choose("auto") == "openmodelica" else ["native"]
    if write and len(compilers) == 1:
        raise InputError(f"--write: {COMPILERS} has both compilers, but OpenModelica's omc is not on the PATH.")
    with progress("compilers", "building and stepping plants"):
        table = compare(suites, compilers)
    _show(table, COMPILERS if write else None, "compilers")


def pages(
    names: Annotated[list[str] | None, typer.Argument(metavar="NAME", help="Pages; all unless given.")] = None,
    anew: Annotated[bool, typer.Option("--anew", help="Run all cases again, and replace the stored tables.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="A few cases, to check that pages run; into build.")] = False,
) -> None:
    """Execute pages of studies, scripts in docs/studies, and write them as Markdown with their figures next to them."""
    known = all_pages()
    if unknown := [name for name in names or () if name not in known]:
        raise InputError(f"{', '.join(unknown)}: there is no such page of a study; there are {', '.join(known)}.")
    for page in map(known.__getitem__, names or known):
        if not (anew or quick):
            say(str(execute(page, page.parent)))
            continue
        shutil.rmtree(apart := Path("build/studies") / page.stem, ignore_errors=True)
        written = execute(page, apart, quick=quick, anew=True)
        if not quick:  # only now, so that what is stored stays if a case fails
            shutil.copytree(apart, page.parent, dirs_exist_ok=True)
        say(str(written if quick else page.with_suffix(".md")))


tools = typer.Typer(no_args_is_help=True, add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
tools.callback(help="Commands for work on railgrip itself, from the folder of the project.")(program)
for each in (
    conditioning, discretisation, validation, calibrate, tune, target, fmus, sizes, compilers, pages, floors, mutants,
    suites,
):  # fmt: skip
    tools.command()(each)


def main(arguments: list[str] | None = None) -> None:
    """Run a command, with the messages and exit codes of railgrip."""
    command = command_of("tools", tools)
    answer(lambda: command(arguments, prog_name="tools"))
