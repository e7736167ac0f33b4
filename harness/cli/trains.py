"""Trains in files: draw, check and calculate one."""

from hashlib import sha256
from pathlib import Path
from typing import Annotated

import typer
from pydantic import TypeAdapter, ValidationError

from railgrip.base.errors import InputError
from railgrip.cli.app import AsJson, complete, print_json
from railgrip.report.console import remark, say, show_all, show_table
from railgrip.report.style import save
from railgrip.rolling_stock.check import checked_train, findings, friction_findings, stops_by_hand, usual_speeds
from railgrip.rolling_stock.drawing import drawing
from railgrip.rolling_stock.schema import TravelSpeed, load_train
from railgrip.rolling_stock.tables import (
    plain_stop,
    sentence_of_equipment,
    sentence_of_stop,
    table_of_axles,
    table_of_distributors,
)
from railgrip.scenario.file import locate

trains = typer.Typer(
    help="Draw, check and calculate trains in files.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
)

TrainFile = Annotated[
    Path,
    typer.Argument(
        metavar="TRAIN",
        autocompletion=complete("trains"),
        help="A train: a file (*.toml), or a name from railgrip list, such as emu387.",
    ),
]


@trains.command()
def show(
    file: TrainFile,
    out: Annotated[Path | None, typer.Option(help="Figure, .png or .svg; build/trains/NAME.png unless given.")] = None,
) -> None:
    """Draw a train to scale and print its axles."""
    train = load_train(file)
    path = out or Path("build/trains") / f"{train.name}.png"
    if path.suffix not in (".png", ".svg"):
        raise InputError(f"--out {path}: a figure ends in .png or .svg")
    show_table(table_of_axles(train))
    if equipment := table_of_distributors(train):
        show_table(equipment)
    say(str(save(drawing(train), path)))


@trains.command()
def check(file: TrainFile, as_json: AsJson = False) -> None:
    """List contradictions in a train, and compute its stop by hand calculation.

    The exit code is 2 if the train contradicts itself.
    """
    train = load_train(file)
    results = findings(train)
    if as_json:
        is_wrong = any(result.wrong for result in results)
        stops = {} if is_wrong else stops_by_hand(train)
        print_json(
            {
                "train": train.name,
                "mass": train.mass,
                "findings": [{"key": r.key, "sentence": r.sentence, "wrong": r.wrong} for r in results],
                "stops": [plain_stop(speed, stop) for speed, stop in stops.items()],
            }
        )
        if is_wrong:
            raise typer.Exit(InputError.exit_code)
        return
    name = locate(file, "trains").name
    for result in results:
        if not result.wrong:
            remark(f"{name}: {result}")
    wrong = [f"{name}: {result}" for result in results if result.wrong]
    if wrong:
        raise InputError("\n".join(wrong))
    if equipment := sentence_of_equipment(train):
        say(equipment)
    for speed, stop in stops_by_hand(train).items():
        say(sentence_of_stop(train, speed, stop))


@trains.command()
def calculate(
    file: TrainFile,
    speed: Annotated[
        list[str] | None,
        typer.Option(help="Initial speed, as '120 km/h'; may be repeated. Those of [[reference]] unless given."),
    ] = None,
    step: Annotated[str, typer.Option(help="Width of the speed steps of the deceleration.")] = "20 km/h",
    draws: Annotated[
        int, typer.Option(help="Stops whose brakes are drawn from [[dispersion]], for the scatter.", min=0, max=100_000)
    ] = 0,
    seed: Annotated[int, typer.Option(help="Seed of the draws.", min=0)] = 1,
    out: Annotated[Path | None, typer.Option(help="Folder of the page; build/trains/NAME unless given.")] = None,
    as_json: AsJson = False,
) -> None:
    """Calculate the brakes of a train by EN 14531-1, and write a page and a PDF to sign."""
    from railgrip.rolling_stock.calculation import mean_stop
    from railgrip.rolling_stock.calculation_page import calculation_page, plain_calculation
    from railgrip.rolling_stock.scatter import scatter
    from railgrip.supervision.trains import data_of

    path = locate(file, "trains")
    train = checked_train(file)
    speeds = sorted({_speed("--speed", text) for text in speed or ()}) or usual_speeds(train)
    for each in speeds:
        if wrong := friction_findings(train, each):
            raise InputError("\n".join(f"{path.name}: {finding}" for finding in wrong))
    width = _speed("--step", step)
    if draws == 1:
        raise InputError("--draws 1: one stop has no scatter; give at least 2, or leave it out")
    drawn = [scatter(train, each, data_of(train).dispersion, draws=draws, seed=seed) for each in speeds if draws]
    stops = [mean_stop(train, each, width) for each in speeds]
    if as_json:
        print_json(plain_calculation(train, stops, drawn))
        return
    folder = out or Path("build/trains") / train.name
    digest = sha256(path.read_bytes()).hexdigest()[:16]
    page = calculation_page(train, stops, drawn, origin=path.name, digest=digest)
    written = page.write(folder)
    show_all(page.screen)
    say(str(written))


def _speed(option: str, text: str) -> float:
    """Return a speed of the command line [m/s].

    Raises:
        InputError: The text is not a speed in the limits of train files.
    """
    try:
        return TypeAdapter(TravelSpeed).validate_python(text)
    except ValidationError as refusal:
        message = refusal.errors()[0]["msg"]
        raise InputError(f"{option} {text}: {message}; write a number with its unit, as '120 km/h'") from None
