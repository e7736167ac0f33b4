"""`railgrip lateral`: the study of a wheelset with lateral and yaw dynamics."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn


def add_to(app: typer.Typer) -> None:
    """Register the command."""
    app.command()(lateral)


def lateral(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for results and report.")] = Path("build/lateral"),
    quick: Annotated[bool, typer.Option(help="A few short runs: shows that it works, not what is true.")] = False,
    workers: Annotated[int, typer.Option(min=1, max=64, help="Processes.")] = 2,
) -> None:
    """Estimate creep, force and friction of a wandering wheelset with three filters, and judge them."""
    from harness.lateral.report import write_report
    from harness.lateral.study import FULL, QUICK, conduct

    plan = QUICK if quick else FULL
    folder = out / "quick" if quick else out
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("lateral", total=len(plan.cases))
        results = conduct(plan, folder, workers=workers, tell=lambda case, found: bar.advance(task))
        bar.update(task, description="report")
        page = write_report(plan, results, folder, tell=lambda what: bar.update(task, description=what))
    Console().print(str(page), highlight=False, soft_wrap=True)
