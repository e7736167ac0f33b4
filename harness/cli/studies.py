"""Studies, each a command of `railgrip study`; the field test's noises, a ride with an estimator, the monitor."""

import inspect
from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Annotated, Any, Final, get_type_hints

import typer
from typer.core import TyperGroup

from railgrip.cli.app import Fresh, ImportFrom, Overrides, Workers, app
from railgrip.console import progress, remark, say, show_table


class _Studies(TyperGroup):
    """Commands by the names of studies; a study is imported when it is asked for, and its fields are its options."""

    def list_commands(self, ctx: Any) -> list[str]:
        from railgrip.studies import names

        return names()

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        return _command(cmd_name)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        from railgrip.studies import names, summary

        with formatter.section("Studies"):
            formatter.write_dl([(name, summary(name)) for name in names()])


studies = typer.Typer(cls=_Studies, invoke_without_command=True)
app.add_typer(studies, name="study", help="Run a study and write its page; without a name, list them.")


@studies.callback()
def study(context: typer.Context) -> None:
    """Run a study and write its page; without a name, list them."""
    if context.invoked_subcommand is None:
        say(context.get_help())


def _conduct(
    *,
    out: Annotated[Path | None, typer.Option(help="Folder for page and results; build/NAME unless given.")] = None,
    workers: Workers = 2,
    scheduler: Annotated[
        str | None, typer.Option(metavar="tcp://HOST:PORT", help="Dask cluster in place of processes here.")
    ] = None,
    fresh: Fresh = False,
    **options: Any,
) -> None:
    from railgrip.studies.study import conduct, study_named

    name = options.pop("study")
    own = study_named(name)(**options)
    page, path = conduct(own, out or Path("build") / name, workers=workers, scheduler=scheduler, fresh=fresh)
    for part in page.screen:
        if isinstance(part, str):
            say(part)
        else:
            show_table(part)
    say(str(path))
    if page.exit_code:
        raise typer.Exit(page.exit_code)


def _command(name: str) -> Any:
    """Return the command of a study: its own options before those of all."""
    from railgrip.studies.study import study_named

    own = study_named(name)

    def command(**options: Any) -> None:
        _conduct(study=name, **options)

    hints = get_type_hints(own, include_extras=True)
    parameters = [
        inspect.Parameter(
            one.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=inspect.Parameter.empty if one.default is MISSING else one.default,
            annotation=_COMMON.get(one.name, hints[one.name]),
        )
        for one in fields(own)  # pyright: ignore[reportArgumentType] - every study is a dataclass
    ]
    parameters += [one for one in inspect.signature(_conduct).parameters.values() if one.kind is one.KEYWORD_ONLY]
    command.__signature__ = inspect.Signature(parameters)  # pyright: ignore[reportFunctionMemberAccess]
    command.__annotations__ = {one.name: one.annotation for one in parameters}
    command.__doc__ = own.__doc__
    alone = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    alone.command(name)(command)
    return typer.main.get_command(alone)


_COMMON: Final[Mapping[str, Any]] = {
    "overrides": Overrides,
    "import_from": ImportFrom,
    "quick": Annotated[bool, typer.Option(help="A small form of it: shows that everything works, not what is true.")],
}
"""Options of many commands, by the name of the field."""


@app.command()
def ride(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="A ride, see harness/studies/axle_box/ride.py.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder for trace and figure; build/rides/NAME unless given.")
    ] = None,
) -> None:
    """Run the instrumented car with a trained estimator beside it, sample by sample."""
    from railgrip.files import remove, write_bytes
    from railgrip.report.style import save
    from railgrip.studies.axle_box.ride import read_ride, ride_beside, ride_figure

    specification = read_ride(file)
    folder = out or Path("build/rides") / specification.name
    remove(folder, "ride.nc", "ride.png")
    with progress(specification.name, 1.0) as bar:
        trace, apart = ride_beside(specification, file.parent, lambda share: bar.update(amount=share), remark)
    write_bytes(folder / "ride.nc", bytes(trace.to_netcdf(engine="h5netcdf")))
    save(ride_figure(trace), folder / "ride.png")
    last = trace.isel(time=-1)
    sentence = f"{specification.name}: after {float(last['time']):.1f} s friction {float(last['friction']):.3f}"
    if float(last["friction_sd"]) > 0:
        sentence += f" ± {float(last['friction_sd']):.3f}"
    sentence += f", true {specification.car.friction:.3f} in the mean"
    if apart is not None:
        sentence += f"; sample by sample within {apart:.1e} of the same readings at once"
    say(sentence)
    say(f"{folder}/ride.nc")


@app.command()
def tune(
    kind: Annotated[str, typer.Argument(metavar="paper|consistent", help="Objective.")],
    out: Annotated[Path, typer.Option(help="File for the noises.")],
    campaign: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="Cases of a field test; field_test unless given.")
    ] = None,
    population: Annotated[int, typer.Option(min=8, help="Candidates of the differential evolution.")] = 48,
    generations: Annotated[int, typer.Option(min=1, help="Generations in all.")] = 60,
    stage: Annotated[int, typer.Option(min=1, help="Generations that are kept together.")] = 10,
    seed: Annotated[int, typer.Option(min=0, help="Of everything that is drawn.")] = 1,
    workers: Annotated[int, typer.Option(min=1, max=64, help="Threads, or processes.")] = 2,
    import_from: ImportFrom = None,
) -> None:
    """Find the twelve noises of the field test's filter on cases 1 to 5; taken up where it was interrupted."""
    from railgrip.campaign.work import work
    from railgrip.errors import EstimationError
    from railgrip.studies.field_test.filtering import equations, filter_of, follow, lost, task_of
    from railgrip.studies.field_test.noise import save_noise
    from railgrip.studies.field_test.objective import DIVERGED
    from railgrip.studies.field_test.runs import TUNING, cases, runs
    from railgrip.studies.field_test.tune import Search
    from railgrip.studies.field_test.tune import tune as search_for

    if kind != "paper" and kind != "consistent":
        raise EstimationError(f"tune: there is no objective '{kind}'; there is paper, consistent.")
    search = Search(population=population, generations=generations, stage=stage, seed=seed)
    with work("field_test", workers=workers) as own:
        field_runs = runs(cases(campaign), TUNING, own, import_from or ())
        model = equations()
        tasks = [task_of(run.braking, model) for run in field_runs.values()]
        noise, value, history = search_for(kind, tasks, search, own)
    command = (
        f"railgrip tune {kind} --population {population} --generations {generations} --stage {stage} --seed {seed} "
        f"--out {out}"
    )
    save_noise(
        noise,
        out,
        title=f"Noises of the field test's filter, tuned on {', '.join(TUNING)}; objective '{kind}'.",
        command=command,
        results={"objective": value, "generations": float(len(history))},
    )
    say(f"{kind}: {value:.6f} m/s after {len(history)} generations")
    filter_ = filter_of(model, tasks[0].period)
    for case, task in zip(field_runs, tasks, strict=True) if value < DIVERGED else ():
        instant = lost(task, follow(task, filter_, noise))
        if instant is not None:
            say(f"Case {case}: the filter is lost from {instant:.2f} s on, its innovations are far beyond its claims.")
    say(str(out))


@app.command()
def monitor(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of stops, in the order of their names.")],
    column_map: Annotated[
        Path | None, typer.Option("--map", metavar="FILE.toml", help="Estimation whose [data] maps recorded files.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Figure; DIR/monitor.png unless given.")] = None,
) -> None:
    """Follow the friction of each brake group from stop to stop, print and plot its health, trend and alarms."""
    from railgrip.estimation.spec import load_specification
    from railgrip.report.style import save
    from railgrip.studies.pad_monitor.folder import stops_in
    from railgrip.studies.pad_monitor.page import draw, health_table, summary_of
    from railgrip.studies.pad_monitor.watch import Design, watch

    with progress("reading") as bar:
        evidence, sentences = stops_in(
            folder,
            None if column_map is None else load_specification(column_map),
            lambda number, of: bar.update(doing=f"stop {number} of {of}"),
        )
    for sentence in sentences:
        say(sentence)
    if not evidence:
        from railgrip.errors import EstimationError

        raise EstimationError(f"{folder}: none of its stops can be used.")
    design = Design()
    history = watch(list(evidence.values()), design)
    show_table(health_table(history, list(evidence)))
    say(summary_of(history, design))
    say(str(save(draw(history, design), out or folder / "monitor.png")))
