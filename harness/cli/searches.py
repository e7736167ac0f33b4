"""Commands that search parameters: levels of scenarios, control laws, and noises of the field test's filter."""

import tomllib
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from railgrip.base.errors import EstimationError, ScenarioError
from railgrip.base.files import write_text
from railgrip.base.names import did_you_mean
from railgrip.base.records import make_folder
from railgrip.campaign import searches as laws
from railgrip.campaign.searches import EQUIPMENT, RANGES, TARGETS, Optimum, set_of, text_of
from railgrip.campaign.searches import calibrate as fit_levels
from railgrip.campaign.work import work
from railgrip.campaign.workers import workers as processes
from railgrip.cli.app import ImportFrom, Workers
from railgrip.controllers.parameters import SlipSource, file_of
from railgrip.report.console import progress, say
from railgrip.studies.field_test.filtering import (
    TUNING,
    divergence_time,
    equations,
    filter_of,
    follow,
    runs,
    save_noise,
    task_of,
)
from railgrip.studies.field_test.filtering import cases as field_cases
from railgrip.studies.field_test.score import DIVERGED, Search
from railgrip.studies.field_test.score import tune as search_for
from railgrip.studies.type_test.entrants import training


def calibrate(
    scenario: Annotated[
        Literal["trapezoid", "sine_sweep", "random"] | None,
        typer.Option(help="The only scenario to fit; all unless given."),
    ] = None,
    out: Annotated[
        Path, typer.Option(help="Folder of the scenario files.", show_default="the library of the project")
    ] = Path("harness/scenario/library"),
) -> None:
    """Fit the levels of the scenarios to the published distances."""
    make_folder(out)
    with progress("levels", "some ten stops each"):
        fit_levels(
            tuple(TARGETS) if scenario is None else (scenario,),
            out,
            lambda fit: say(
                f"{fit.scenario}, {fit.shape}: level {fit.level:.5f}, {fit.distance:.1f} m "
                f"(target {TARGETS[fit.scenario]} m)"
            ),
        )


def tune_control(
    law: Annotated[list[str] | None, typer.Option(help="A law to search; all unless given.")] = None,
    out: Annotated[Path, typer.Option(help="Folder of the files of parameters.")] = Path("controllers/laws"),
    budget: Annotated[
        int | None,
        typer.Option(min=5, help="Sets of parameters to try for each law; 24 for each parameter unless given."),
    ] = None,
    cases: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=1000,
            help="Search on this number of short training cases of the type test instead of the rails.",
        ),
    ] = None,
    version: Annotated[int, typer.Option(min=1, max=2, help="Version of the type test, with --cases.")] = 1,
    workers: Workers = 2,
) -> None:
    """Search the parameters of the control laws.

    Parameters that are not searched stay as they are in the file of the law. For a law of the published tables, --cases
    writes `<law>.type_test.toml` or `<law>.type_test_2.toml`, so that the accepted distances do not change.
    """
    unknown = sorted(set(law or ()) - RANGES.keys())
    if unknown:
        raise ScenarioError(
            f"tune-control: --law {unknown[0]} is not searched; there is {', '.join(RANGES)}"
            + did_you_mean(unknown[0], RANGES, before="; ")
        )
    make_folder(out)

    def note(name: str, number: int, best: float) -> None:
        say(f"{name}, generation {number}: {100 * best:+.2f} % against slip-based control")

    stops, kinds = None, frozenset(EQUIPMENT)
    if cases is not None:
        stops, kinds = training(cases, version), frozenset({"pneumatic"})
    options = {"--cases": cases, "--budget": budget, "--version": version if cases and version > 1 else None}
    with processes(workers) as pool:
        for each in law or RANGES:
            optima: dict[tuple[str, SlipSource], Optimum] = {}
            for actuation, slip in (kind for kind in RANGES[each] if kind[0] in kinds):
                name = f"{each}, {actuation} actuation, {slip} slip"
                with progress(name, "searching parameters"):
                    notify = partial(note, name)
                    optima[actuation, slip] = laws.search(
                        each,
                        actuation,
                        slip,
                        notify,
                        pool,
                        rail_stops=stops,
                        version=version if cases else None,
                        budget=budget,
                    )
                say(text_of(each, {(actuation, slip): optima[actuation, slip]}))
            command = " ".join(
                (
                    f"railgrip maintain tune-control --law {each}",
                    *(f"{name} {value}" for name, value in options.items() if value),
                )
            )
            path = out / file_of(each, set_of(each, version if cases else None))
            text = text_of(each, optima, command if any(options.values()) else "make tune-control")
            write_text(path, text + _others(path, optima))


def _others(path: Path, optima: Mapping[tuple[str, SlipSource], Optimum]) -> str:
    sets = tomllib.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    lines: list[str] = []
    for actuation, slip in ((a, s) for a, of in sets.items() for s in of if (a, s) not in optima):
        values = sets[actuation][slip]
        lines += ["", "# Not searched then.", f"[{actuation}.{slip}]", *(f"{k} = {v!r}" for k, v in values.items())]
    return "".join(f"{line}\n" for line in lines)


def tune(
    kind: Annotated[str, typer.Argument(metavar="paper|consistent", help="Objective.")],
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
    if kind != "paper" and kind != "consistent":
        raise EstimationError(f"tune: there is no objective '{kind}'; there is paper, consistent.")
    search = Search(population=population, generations=generations, stage=stage, seed=seed)
    with work("field_test", workers=workers) as job:
        field_runs = runs(field_cases(campaign), TUNING, job, import_from or ())
        model = equations()
        tasks = [task_of(run.braking, model) for run in field_runs.values()]
        noise, value, history = search_for(kind, tasks, search, job)
    command = (
        f"railgrip maintain tune {kind} --population {population} --generations {generations} --stage {stage} "
        f"--seed {seed} --out {out}"
    )
    save_noise(
        noise,
        out,
        title=f"Noises of the field test's filter, tuned on {', '.join(TUNING)}; objective '{kind}'.",
        command=command,
        results={"objective": value, "generations": float(len(history))},
    )
    say(f"{kind}: {value:.6f} m/s after {len(history)} generations")
    filter_ = filter_of(model, tasks[0].data.period)
    for case, task in zip(field_runs, tasks, strict=True) if value < DIVERGED else ():
        instant = divergence_time(task, follow(task, filter_, noise))
        if instant is not None:
            say(f"Case {case}: the filter is lost from {instant:.2f} s on, its innovations are far beyond its claims.")
    say(str(out))
