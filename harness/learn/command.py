"""`railgrip learn`: the study of the paper, or a user's own runs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

if TYPE_CHECKING:
    from estimators.learned.ensemble import Ensemble

OUT: Final = Path("build/learn")


def add_to(app: typer.Typer) -> None:
    """Register the command."""
    app.command("learn")(learn)


def learn(
    quick: Annotated[
        bool, typer.Option(help="A small study that shows everything works; its figures mean nothing.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder for report, figures and FMU.")] = OUT,
    runs: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of your own recordings; needs --labels.")
    ] = None,
    labels: Annotated[Path | None, typer.Option(metavar="FILE", help="Table of their friction.")] = None,
    workers: Annotated[int, typer.Option(min=1, max=64, help="Processes.")] = 2,
) -> None:
    """Learn friction from axle-box accelerations: train, judge, report, and export as an FMU."""
    if (runs is None) != (labels is None):
        raise typer.BadParameter("--runs and --labels go together")
    page = own(runs, labels, out, workers) if runs and labels else paper(quick, out, workers)
    Console().print(str(page), highlight=False, soft_wrap=True)


def paper(quick: bool, out: Path, workers: int) -> Path:
    """Run the study of the paper and write its report, figures and the FMU of the estimator for all speeds."""
    from harness.learn.figures import draw
    from harness.learn.study import FULL, QUICK, pieces, study
    from harness.learn.tables import report
    from harness.record.atomic import write_text

    size = QUICK if quick else FULL
    with _progress() as bar:
        task = bar.add_task("learn", total=pieces(size) + 1)

        def tell(name: str) -> None:
            bar.update(task, advance=1, description=name)

        made = study(size, workers=workers, tell=tell)
        bar.update(task, description="figures and FMU")
        drawn = draw(made, out)
        _export(made.ensemble, out)
    pictures = "\n".join(f"![{path.stem}]({path.name})" for path in drawn)
    page = out / "report.md"
    write_text(page, report(made) + "\n" + pictures + "\n")
    return page


def own(runs: Path, labels: Path, out: Path, workers: int) -> Path:
    """Train and judge on a user's runs, write the report and the FMU of the estimator for all speeds."""
    from harness.learn.own import judge_own
    from harness.learn.users import read_runs
    from harness.record.atomic import write_text

    with _progress() as bar:
        task = bar.add_task("reading", total=None)
        read = read_runs(runs, labels)
        bar.update(task, description="training")
        text, ensemble = judge_own(read, workers=workers)
        bar.update(task, description="FMU")
        _export(ensemble, out)
    page = out / "report.md"
    write_text(page, text)
    return page


def _export(ensemble: "Ensemble", out: Path) -> Path:
    from estimators.learned.online import general
    from fmus.native.package import pack
    from harness.learn.export import as_fmu
    from harness.learn.gather import SLOW, SPECTRAL

    return pack(as_fmu(general(SLOW, SPECTRAL, ensemble)), out / "Friction.fmu")


def _progress() -> Progress:
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    return Progress(*columns, console=Console(stderr=True), transient=True)
