"""The type test of wheel-slide protection."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from railgrip.cli.app import RUN_FAILED, Fresh, ImportFrom, Workers, app
from railgrip.cli.runs import runner
from railgrip.console import complain, progress, say, show_table
from railgrip.errors import ScenarioError

if TYPE_CHECKING:
    from railgrip.campaign.run import Report


@app.command("type-test")
def type_test(
    controller: Annotated[
        list[str] | None,
        typer.Option(
            help="One of ours, a scenario (.toml), an .fmu or module:Class; all of ours without it. Repeatable."
        ),
    ] = None,
    train: Annotated[
        str | None,
        typer.Option(help="A scenario (.toml) whose train it is, a train, an .fmu or a recipe; ours without it."),
    ] = None,
    task: Annotated[
        Path | None,
        typer.Option(help="A scenario (.toml) whose demand and [adhesion.conditioning] hold in every case."),
    ] = None,
    against: Annotated[
        str | None, typer.Option(help="A controller of the test: distances of the others over its own, case by case.")
    ] = None,
    quick: Annotated[bool, typer.Option(help="A tenth of the cases: shows where a controller stands.")] = False,
    validation: Annotated[bool, typer.Option(help="Other cases, which nobody may look at while tuning.")] = False,
    count: Annotated[int | None, typer.Option("--cases", min=1, max=10000, help="Number of cases.")] = None,
    case: Annotated[list[str] | None, typer.Option(help="Only this one, with trace and panels. Repeatable.")] = None,
    limits: Annotated[Path | None, typer.Option(help="File of limits in place of ours.")] = None,
    out: Annotated[Path, typer.Option(help="Folder for results and report.")] = Path("build/type_test"),
    workers: Workers = 2,
    scheduler: Annotated[
        str | None, typer.Option(metavar="tcp://HOST:PORT", help="Dask cluster in place of processes here.")
    ] = None,
    fresh: Fresh = False,
    import_from: ImportFrom = None,
) -> None:
    """Stop a train in hundreds of cases under each controller, judge every stop, and rank them."""
    from railgrip.campaign.run import CampaignRun, run_campaigns, write_description
    from railgrip.report.index import write_report as write_panels
    from railgrip.report.results import read_results
    from railgrip.studies.type_test.design import CASES, QUICK, SEED, VALIDATION_SEED, case_named, cases
    from railgrip.studies.type_test.entrants import campaign_of, entrants, entrants_named, task_of, train_of
    from railgrip.studies.type_test.judge import limits_of
    from railgrip.studies.type_test.report import compared, leaderboard_of, write_report

    judging, ours = limits_of(limits), entrants()
    candidates = ours if controller is None else entrants_named(controller, ours)
    if against is not None and against not in ours | candidates:
        raise ScenarioError(f"--against {against}: is none of {', '.join(ours | candidates)}")
    # What others are measured with is run, too; what they are compared with comes from earlier runs.
    running = {name for name, one in ours.items() if one.role in {"reference", "bound"}} | candidates.keys()
    if case:
        blind_cases = tuple(case_named(name) for name in case)
    else:
        blind_cases = cases(count or (QUICK if quick else CASES), VALIDATION_SEED if validation else SEED)
    whole = campaign_of(
        blind_cases, ours | candidates, train_of(train), task=task and task_of(task), keep_traces=bool(case)
    )
    stops = whole.only(lambda stop: stop.variants["controller"] in running)
    directory = out.joinpath(*(Path(file).stem for file in (train, task) if file is not None))
    if case:
        directory = directory / "cases"
    with progress(whole.name, len(stops.stops), is_count=True) as bar:

        def tell(report: "Report") -> None:
            bar.advance()
            if report.state in {"refused", "failed"}:
                complain(f"{report.stop.name}: {report.sentence}")

        (reports,) = run_campaigns(
            [CampaignRun(stops, directory)],
            runner(import_from=import_from or ()),
            workers=workers,
            scheduler=scheduler,
            fresh=fresh,
            tell=tell,
        )
        write_description(whole, directory)
        bar.update(doing="report")
        again = "".join(f" --{key} {value}" for key, value in (("train", train), ("task", task)) if value is not None)
        page = write_report(read_results(directory), ours | candidates, judging, directory, again)
    show_table(leaderboard_of(directory))
    if against is not None:
        show_table(compared(directory, against))
    for stop in stops.stops if case else ():
        if stop.variants["controller"] in candidates and (directory / stop.name / "trace.nc").exists():
            say(str(write_panels(directory / stop.name)))
    say(str(page))
    states = {report.state for report in reports}
    if "refused" in states:
        raise typer.Exit(ScenarioError.exit_code)
    if "failed" in states:
        raise typer.Exit(RUN_FAILED)
