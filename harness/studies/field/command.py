"""`railgrip field` and `railgrip tune`: the field test reported, and its filter tuned."""

from pathlib import Path
from typing import Annotated

import typer

from railgrip.console import progress, say

Scenario = Annotated[
    Path | None, typer.Option("--scenario", metavar="FILE.toml", help="Field test; the library's unless given.")
]


def add_to(app: typer.Typer) -> None:
    """Add the two commands to the command line."""
    app.command()(field)
    app.command()(tune)


def field(
    out: Annotated[Path, typer.Option(help="Folder for figures and page.")] = Path("build/estimate/field"),
    scenario: Scenario = None,
) -> None:
    """Recover the track, estimate friction in case 6 with each set of noises, and draw figures 2 to 5 of the paper."""
    from railgrip.studies.field.report import write_report
    from railgrip.twins.field_scenario import field_scenario

    with progress("field test") as shown:
        page = write_report(field_scenario(scenario), out, tell=lambda what: shown.update(doing=what))
    say(page.read_text(encoding="utf-8"))
    say(str(page))


def tune(
    kind: Annotated[str, typer.Argument(metavar="paper|consistent", help="Objective.")],
    out: Annotated[Path, typer.Option(help="File for the noises.")],
    scenario: Scenario = None,
    population: Annotated[int, typer.Option(min=8, help="Candidates of the differential evolution.")] = 48,
    generations: Annotated[int, typer.Option(min=1, help="Generations in all.")] = 60,
    stage: Annotated[int, typer.Option(min=1, help="Generations between two checkpoints.")] = 10,
    seed: Annotated[int, typer.Option(min=0, help="Of everything that is drawn.")] = 1,
    workers: Annotated[int, typer.Option(min=1, max=64, help="Threads.")] = 2,
) -> None:
    """Find the twelve noises of the field test's filter on cases 1 to 5; taken up where it was interrupted."""
    from railgrip.errors import EstimationError
    from railgrip.studies.field.filtering import filter_of, follow, lost, prediction, task_of
    from railgrip.studies.field.noise import save_noise
    from railgrip.studies.field.objective import DIVERGED
    from railgrip.studies.field.runs import TUNING, brakings
    from railgrip.studies.field.tune import Search
    from railgrip.studies.field.tune import tune as search_for
    from railgrip.twins.field_scenario import field_scenario

    if kind != "paper" and kind != "consistent":
        raise EstimationError(f"tune: there is no objective '{kind}'; there is paper, consistent.")
    chosen = field_scenario(scenario)
    model = prediction()
    with progress("twin") as shown:
        made = brakings(chosen, TUNING, lambda case: shown.update(doing=case))
    tasks = [task_of(braking, model) for _, braking in made.values()]
    search = Search(population=population, generations=generations, stage=stage, seed=seed, workers=workers)
    checkpoint = Path("build/tune") / f"{chosen.name}-{kind}.npz"
    with progress("generations", generations, counted=True) as shown:
        found = search_for(
            kind,
            tasks,
            model,
            search,
            checkpoint,
            lambda generation, best: shown.update(done=generation, doing=f"best {best:.6f} m/s"),
        )
    command = (
        f"railgrip tune {kind} --population {population} --generations {generations} --stage {stage} --seed {seed} "
        f"--out {out}"
    )
    save_noise(
        found.noise,
        out,
        title=f"Noises of the field test's filter, tuned on {', '.join(TUNING)}; objective '{kind}'.",
        command=command,
        results={"objective": found.value, "generations": float(len(found.history))},
    )
    say(f"{kind}: {found.value:.6f} m/s after {len(found.history)} generations")
    filter_ = filter_of(model, chosen.period)
    for case, task in zip(made, tasks, strict=True) if found.value < DIVERGED else ():
        instant = lost(task, follow(task, filter_, found.noise))
        if instant is not None:
            say(f"Case {case}: the filter is lost from {instant:.2f} s on, its innovations are far beyond its claims.")
    say(str(out))
