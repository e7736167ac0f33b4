"""`railgrip learn`: the study of the paper, or a user's own runs; `railgrip ride`: a trained estimator in the loop."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from railgrip.console import progress, say
from railgrip.errors import ScenarioError

if TYPE_CHECKING:
    from railgrip.estimators.learned.trained import GeneralEstimator, PaperEstimator

OUT: Final = Path("build/learn")


def add_to(app: typer.Typer) -> None:
    """Register the commands."""
    app.command("learn")(learn)
    app.command("ride")(ride)


def learn(
    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE.toml]", help="Your own runs, see harness/studies/learn/own_file.py.")
    ] = None,
    inputs: Annotated[
        str | None,
        typer.Option(help="What the paper's networks listen to, as 'left, right'; longitudinal unless given."),
    ] = None,
    quick: Annotated[
        bool, typer.Option(help="A small study that shows everything works; its figures mean nothing.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="Folder for report, figures, estimators and FMUs; build/learn or …/learn_NAME.")
    ] = None,
    workers: Annotated[int, typer.Option(min=1, max=64, help="Processes.")] = 2,
) -> None:
    """Learn friction from axle-box accelerations: train, judge, report, and export as FMUs."""
    from railgrip.estimators.learned.channels import COMBINATIONS

    if inputs is not None and inputs not in COMBINATIONS:
        raise ScenarioError(f"--inputs is '{inputs}'; there is {'; '.join(COMBINATIONS)}.")
    if file is not None and quick:
        raise ScenarioError("--quick is of the paper's study; your own runs are taken as they are.")
    page = _paper(inputs, quick, out or OUT, workers) if file is None else _own(file, inputs, out, workers)
    say(str(page))


def ride(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="A ride, see harness/studies/learn/ride.py.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder for trace and figure; build/rides/NAME unless given.")
    ] = None,
) -> None:
    """Run the instrumented car with a trained estimator beside it, sample by sample."""
    from railgrip.atomic import write_bytes
    from railgrip.report.style import save
    from railgrip.studies.learn.ride import read_ride, ride_beside, ride_figure

    asked = read_ride(file)
    folder = out or Path("build/rides") / asked.name
    with progress(asked.name, 1.0) as shown:
        ridden = ride_beside(asked, file.parent, lambda share: shown.update(done=share))
    write_bytes(folder / "ride.nc", bytes(ridden.trace.to_netcdf(engine="h5netcdf")))
    save(ride_figure(ridden.trace), folder / "ride.png")
    last = ridden.trace.isel(time=-1)
    sentence = f"{asked.name}: after {float(last['time']):.1f} s friction {float(last['friction']):.3f}"
    if float(last["friction_sd"]) > 0:
        sentence += f" ± {float(last['friction_sd']):.3f}"
    sentence += f", true {asked.car.friction:.3f} in the mean"
    if ridden.apart is not None:
        sentence += f"; sample by sample within {ridden.apart:.1e} of the same readings at once"
    say(sentence)
    say(f"{folder}/ride.nc")


def _paper(inputs: str | None, quick: bool, out: Path, workers: int) -> Path:
    """Run the study of the paper and write its report, figures, estimators and their FMUs."""
    from railgrip.atomic import write_text
    from railgrip.studies.learn.figures import draw
    from railgrip.studies.learn.study import FULL, QUICK, estimators_of, pieces, study
    from railgrip.studies.learn.tables import report

    size = QUICK if quick else FULL
    with progress("learn", pieces(size), counted=True) as shown:
        made = study(size, inputs=inputs or "longitudinal", workers=workers, tell=shown.advance)
        shown.update(doing="figures and FMUs")
        drawn = draw(made, out)
        _export(estimators_of(made), out)
    page = out / "report.md"
    write_text(page, report(made, [path.stem for path in drawn]))
    return page


def _own(file: Path, inputs: str | None, out: Path | None, workers: int) -> Path:
    """Train and judge on a user's runs, write the report, the estimators and their FMUs."""
    from railgrip.atomic import write_text
    from railgrip.studies.learn.own import judge_own, own_pieces
    from railgrip.studies.learn.own_file import read_own
    from railgrip.studies.learn.users import read_folder, read_labels

    asked = read_own(file)
    network = asked.network if inputs is None else asked.network.model_copy(update={"inputs": inputs})
    folder = out or OUT.with_name(f"learn_{asked.name}")
    labels = file.parent / asked.runs.labels
    with progress("learn", len(read_labels(labels)), counted=True) as shown:
        read = read_folder(file.parent / asked.runs.folder, labels, asked.data, shown.advance)
        shown.update(doing="training and judging", total=len(read.runs) + own_pieces(read.runs))
        text, trained = judge_own(
            read.runs, network.recipe(), workers=workers, remarks=read.remarks, tell=shown.advance
        )
        shown.update(doing="FMUs")
        _export(trained, folder)
    page = folder / "report.md"
    write_text(page, text)
    return page


def _export(trained: "Mapping[str, PaperEstimator | GeneralEstimator]", out: Path) -> None:
    """Write every estimator as a file of numbers and as an FMU."""
    from railgrip.atomic import replacing
    from railgrip.estimators.learned.trained import save
    from railgrip.fmus.native.package import pack
    from railgrip.studies.learn.export import as_fmu

    for name, one in trained.items():
        with replacing(out / f"{name}.json") as partial:
            save(one, partial)
        pack(as_fmu(one.online()), out / f"{name}.fmu")
