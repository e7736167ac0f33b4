"""Trains in files: draw one, check one."""

from pathlib import Path
from typing import Annotated

import typer

from railgrip.base.errors import InputError
from railgrip.cli.app import AsJson, complete, print_json
from railgrip.report.console import remark, say, show_table
from railgrip.report.style import save
from railgrip.rolling_stock.check import findings, stops_by_hand
from railgrip.rolling_stock.drawing import drawing
from railgrip.rolling_stock.schema import load_train
from railgrip.rolling_stock.tables import (
    plain_stop,
    sentence_of_equipment,
    sentence_of_stop,
    table_of_axles,
    table_of_distributors,
)
from railgrip.scenario.file import locate

trains = typer.Typer(
    help="Draw and check trains in files.",
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
