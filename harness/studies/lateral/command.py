"""`railgrip lateral`: the study of a wheelset with lateral and yaw dynamics."""

from pathlib import Path
from typing import Annotated

import typer

from railgrip.console import progress, say


def add_to(app: typer.Typer) -> None:
    """Register the command."""
    app.command()(lateral)


def lateral(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for results and report.")] = Path("build/lateral"),
    quick: Annotated[bool, typer.Option(help="A few short runs: shows that it works, not what is true.")] = False,
    workers: Annotated[int, typer.Option(min=1, max=64, help="Processes.")] = 2,
) -> None:
    """Estimate creep, force and friction of a wandering wheelset with three filters, and judge them."""
    from railgrip.studies.lateral.report import write_report
    from railgrip.studies.lateral.study import FULL, QUICK, conduct

    plan = QUICK if quick else FULL
    folder = out / "quick" if quick else out
    with progress("lateral", len(plan.cases), counted=True) as shown:
        results = conduct(plan, folder, workers=workers, tell=lambda case, found: shown.advance())
        shown.update(doing="report")
        page = write_report(plan, results, folder, tell=lambda what: shown.update(doing=what))
    say(str(page))
