"""The program that the commands belong to, and the arguments that several of them take."""

from pathlib import Path
from typing import Annotated, Any, Final, NoReturn

import typer
from typer.core import TyperGroup

from railgrip.console import complain
from railgrip.errors import InputError

RUN_FAILED = 3
"""Exit code of a run that ended badly; errors bring their own."""

MOVED: Final = {
    "field": "field_test",
    "k-factors": "k_factors",
    "lateral": "lateral",
    "learn": "axle_box",
    "monitor-study": "pad_monitor",
    "rig": "roller_rig",
    "trains": "trains",
    "type-test": "type_test",
}
"""What was a command of its own, and which study it is."""


class _Commands(TyperGroup):
    """Commands; one of an earlier release is refused with its new name."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if args[0] in MOVED:
            raise InputError(f"`railgrip {args[0]}` is now `railgrip study {MOVED[args[0]]}`.")
        return super().resolve_command(ctx, args)


app = typer.Typer(
    name="railgrip",
    cls=_Commands,
    help="The open bench for railway braking at low adhesion.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
File = Annotated[Path, typer.Argument(metavar="FILE.toml", help="Scenario or campaign file.")]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="table.key=value", help="Change a value, as in start.speed='100 km/h'; repeatable."),
]
ImportFrom = Annotated[
    list[Path] | None,
    typer.Option(
        "--import-from",
        metavar="DIR",
        exists=True,
        file_okay=False,
        resolve_path=True,  # workers may stand in another folder
        help="Folder of modules that a file names as module:Class; their code runs. Repeatable.",
    ),
]
Workers = Annotated[int, typer.Option(min=1, max=64, help="Processes.")]
Fresh = Annotated[bool, typer.Option(help="Run also what already has a result.")]


def fail(*sentences: str) -> NoReturn:
    """End with the exit code of a run that failed, and with why."""
    for sentence in sentences:
        complain(sentence)
    raise typer.Exit(RUN_FAILED)
