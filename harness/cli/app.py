"""The program, its commands, and their common arguments.

A user's mistake ends in a message and an exit code (`railgrip.report.console.answer`). Exit codes are 0 for a result, 2
for invalid input, 3 for a run that failed, the last two with a message.

The module of a command is imported when the command is called: `--help` and shell completion import none of them.
"""

import json
import logging
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, ClassVar, NoReturn

import typer
from typer.core import TyperGroup

from railgrip import __version__
from railgrip.base import registry
from railgrip.base.errors import InputError
from railgrip.base.files import finite
from railgrip.base.names import did_you_mean, nearest
from railgrip.base.registry import Shelf, shelf
from railgrip.report.console import answer, complain, say, show_messages

RUN_FAILED = 3
"""Exit code of a run that failed; errors define their own."""

BASELINES = Path("tests/baselines")
"""Folder of baseline files, unless given."""


@dataclass(frozen=True, slots=True)
class Command:
    """A command that is imported when it is called.

    Attributes:
        place: module:object relative to `railgrip.cli`, a function or a group.
        summary: First line of its help.
    """

    place: str
    summary: str

    def load(self, name: str) -> Any:
        """Import the command."""
        module, _, attribute = self.place.partition(":")
        return command_of(name, getattr(import_module(f"railgrip.cli.{module}"), attribute))


def command_of(name: str, target: Any) -> Any:
    """Return the command of a function or of a group; it accepts the global options after its name, too.

    An option of the command replaces a global one of the same name.
    """
    if isinstance(target, typer.Typer):
        command = typer.main.get_command(target)
    else:
        program = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
        program.command(name)(target)
        command = typer.main.get_command(program)
    for each in (command, *getattr(command, "commands", {}).values()):
        names = {name for option in each.params for name in option.opts}
        each.params += [option for option in _global_options() if not names.intersection(option.opts)]
    return command


def _global_options() -> list[Any]:
    options = typer.Typer(add_completion=False)
    options.command()(program)
    parameters: list[Any] = typer.main.get_command(options).params
    for each in parameters:
        each.hidden = each.name == "version"
    return parameters


def _flag(*names: str, act: Callable[[], None], summary: str) -> Any:
    def call(given: bool) -> None:
        if given:
            act()

    return typer.Option(*names, callback=call, is_eager=True, expose_value=False, help=summary)


def _show_version() -> None:
    say(f"railgrip {__version__}")
    raise typer.Exit


_be_quiet, _be_verbose = partial(show_messages, logging.WARNING), partial(show_messages, logging.DEBUG)


def program(
    version: Annotated[bool, _flag("--version", act=_show_version, summary="Print the version and exit.")] = False,
    quiet: Annotated[
        bool, _flag("--quiet", "-q", act=_be_quiet, summary="Print results and errors only, no progress.")
    ] = False,
    verbose: Annotated[
        bool, _flag("--verbose", "-v", act=_be_verbose, summary="Also print debugging messages.")
    ] = False,
) -> None:
    """The open bench for railway braking at low adhesion."""


@dataclass(frozen=True, slots=True)
class Completion:
    """A completion offered by a shell; it replaces click's class, which some releases of typer copy."""

    value: str
    help: str
    type: str = "plain"


class Commands(TyperGroup):
    """Commands in sections.

    Attributes:
        sections: Heading → name → command, in the order of the help.
    """

    sections: ClassVar[Mapping[str, Mapping[str, Command]]] = {}

    def elsewhere(self) -> dict[str, str]:
        """Return the full command lines of commands in other groups that users may search for here, by name."""
        return {}

    def _table(self) -> dict[str, Command]:
        return {name: command for section in self.sections.values() for name, command in section.items()}

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all commands."""
        return list(self._table())

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Import a command; return None for an unknown name."""
        command = self._table().get(cmd_name)
        return None if command is None else command.load(cmd_name)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the names with their summaries, by section."""
        for heading, section in self.sections.items():
            with formatter.section(heading):
                formatter.write_dl([(name, command.summary) for name, command in section.items()])

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find the command at the start of the arguments; for an unknown name suggest the nearest one."""
        if args[0] not in self._table() and not args[0].startswith("-"):
            commands = {name: f"{ctx.command_path} {name}" for name in self._table()} | self.elsewhere()
            near = nearest(args[0], commands)
            hint = f"did you mean `{commands[near[0]]}`?" if near else f"`{ctx.command_path} --help` lists all."
            raise InputError(f"there is no command `{ctx.command_path} {args[0]}`; {hint}")
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run a command; for a value that is not one of the choices suggest the nearest one."""
        try:
            return super().invoke(ctx)
        except typer.BadParameter as problem:
            if choice := re.search(r"'([^']*)' is not one of (.*)", problem.message):
                names = re.findall(r"'([^']*)'", choice[2])
                problem.message = problem.message.rstrip(".") + did_you_mean(choice[1], names, before="; ")
            raise

    def shell_complete(self, ctx: Any, incomplete: str) -> list[Any]:
        """Complete the name of a command without importing commands."""
        if incomplete.startswith("-"):
            return super().shell_complete(ctx, incomplete)
        return [
            Completion(name, help=command.summary)
            for name, command in self._table().items()
            if name.startswith(incomplete)
        ]


class _Main(Commands):
    sections: ClassVar = {
        "Stops and campaigns": {
            "run": Command("runs:run", "Run one scenario and print its figures."),
            "campaign": Command("campaigns:campaign", "Run the stops of campaigns and write tables and a report."),
            "report": Command("campaigns:report", "Make the page of the results in a folder."),
            "compare": Command("campaigns:compare", "Show how results differ, and where along the track."),
            "table": Command("campaigns:table", "Print or write the results in a folder as a table."),
            "study": Command("studies:studies", "Run a study and write its page; without a name, list them."),
        },
        "Files and parts": {
            "list": Command("library:list_", "List the names of scenarios, controllers, trains and more."),
            "new": Command("library:new", "Write a commented file to start from, which runs as it is."),
            "schema": Command("library:schema", "Print the JSON schema of a file, for editors and validators."),
            "train": Command("trains:trains", "Draw, check and calculate trains in files."),
            "build": Command("fmus:build_command", "Update FMUs, or build a plant from your own class."),
            "map": Command("fmus:map_", "Print the tables of a scenario for the FMU of another tool."),
            "export": Command("fmus:export", "Make FMUs of a scenario for another tool, or a page that runs its stop."),
        },
        "Estimation and monitoring": {
            "inspect": Command("estimation:inspect", "Show what a recording holds, and propose its [data]."),
            "estimate": Command("estimation:estimate", "Run the filter of an estimation over its recording."),
            "observability": Command("estimation:observability", "Show which states a recording determines."),
            "ride": Command("estimation:ride", "Run the instrumented car with a trained friction estimator."),
            "monitor": Command("estimation:monitor", "Follow the pad friction of each brake group from stop to stop."),
        },
        "This installation": {
            "doctor": Command("doctor:doctor", "Check versions, compilers, folders and parts of other packages."),
        },
        "Development": {
            "maintain": Command("app:maintain", "Guard distances by baselines, and develop railgrip."),
        },
    }  # fmt: skip

    def elsewhere(self) -> dict[str, str]:
        """Return the studies, by name."""
        return {name: f"railgrip study {name}" for name in registry.names("studies")}


app = typer.Typer(
    name="railgrip",
    cls=_Main,
    help="The open bench for railway braking at low adhesion.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


app.callback()(program)


def complete(*kinds: Shelf) -> Any:
    """Return the completion of an argument: names from the library, else the shell's own files."""

    def candidates(incomplete: str) -> list[str]:
        names = [name for kind in kinds for name in shelf(kind) if name.startswith(incomplete)]
        return names or [str(path) for path in sorted(Path().glob(f"{incomplete}*"))]

    return candidates


def print_json(value: Any) -> None:
    """Print a value of lists, dictionaries, strings and numbers as JSON; numbers that are not finite are null.

    Errors are not results: their messages go to standard error, and standard output stays empty.
    """
    say(json.dumps(finite(value), indent=1, ensure_ascii=False, allow_nan=False))


AsJson = Annotated[
    bool,
    typer.Option("--json", help="Print the result as JSON, in SI units, and nothing else on standard output."),
]
File = Annotated[
    Path,
    typer.Argument(
        metavar="SCENARIO",
        autocompletion=complete("scenarios"),
        help="A scenario: a file (*.toml), or a name from railgrip list, such as trapezoid.",
    ),
]
Campaigns = Annotated[
    list[Path],
    typer.Argument(
        metavar="CAMPAIGN ...",
        autocompletion=complete("campaigns"),
        help="Campaigns: files (*.toml), or names from railgrip list, such as table1.",
    ),
]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="table.key=value", help="Change a value, as in start.speed='100 km/h'; repeatable."),
]
With = Annotated[
    list[str] | None,
    typer.Option(
        "--with",
        metavar="EQUIPMENT",
        autocompletion=complete("equipment"),
        help="Tables merged into the scenario: a file, or a name from railgrip list, such as service; repeatable.",
    ),
]
ImportFrom = Annotated[
    list[Path] | None,
    typer.Option(
        "--import-from",
        metavar="DIR",
        exists=True,
        file_okay=False,
        resolve_path=True,  # workers may run in another folder
        help="Folder of modules that a file names as module:Class; their code runs. Repeatable.",
    ),
]
Scheduler = Annotated[
    str | None, typer.Option(metavar="tcp://HOST:PORT", help="Dask cluster to use instead of local processes.")
]
Workers = Annotated[int, typer.Option(min=1, max=64, help="Number of processes.")]
Formats = Annotated[
    str, typer.Option("--format", metavar="png,svg,pdf", help="Formats of the figures, separated by commas.")
]
Fresh = Annotated[bool, typer.Option(help="Run again what already has a result.")]


def fail(*sentences: str) -> NoReturn:
    """Print why a run failed, and exit with the code for failures."""
    for sentence in sentences:
        complain(sentence)
    raise typer.Exit(RUN_FAILED)


class _Maintain(Commands):
    sections: ClassVar = {
        "Baselines": {
            "regress": Command("baselines:regress", "Run everything that has a baseline and compare every number."),
            "accept": Command("baselines:accept", "Update the baselines to the results of the last regress."),
        },
        "Searches": {"tune-control": Command("searches:tune_control", "Search the parameters of the control laws.")},
    }  # fmt: skip


maintain = typer.Typer(
    cls=_Maintain,
    help="Guard distances by baselines, and develop railgrip. Begin with `railgrip new regression`.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
)


@maintain.callback()
def group() -> None:
    """Guard distances by baselines, and develop railgrip. Begin with `railgrip new regression`."""


def main(arguments: list[str] | None = None) -> None:
    """Run the command line."""
    # Without a writable home it reports where it keeps its list of fonts.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    answer(lambda: app(arguments, prog_name="railgrip"))
