"""Studies, each a command of `railgrip study`."""

import inspect
from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Annotated, Any, Final, get_type_hints

import typer
from typer.core import TyperGroup

from railgrip.cli.app import Formats, Fresh, ImportFrom, Overrides, Scheduler, Workers, command_of
from railgrip.report.console import say, show_all
from railgrip.report.page import formats_of
from railgrip.studies import names, summary
from railgrip.studies.study import conduct, study_named


class _Studies(TyperGroup):
    """Commands by the names of studies; a study is imported when it is called, and its fields are its options."""

    def list_commands(self, ctx: Any) -> list[str]:
        return names()

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        return _command(cmd_name)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        with formatter.section("Studies"):
            formatter.write_dl([(name, summary(name)) for name in names()])


studies = typer.Typer(cls=_Studies, invoke_without_command=True, add_completion=False, rich_markup_mode=None)


@studies.callback()
def study(context: typer.Context) -> None:
    """Run a study and write its page; without a name, list them."""
    if context.invoked_subcommand is None:
        say(context.get_help())


def _conduct(
    *,
    out: Annotated[Path | None, typer.Option(help="Folder for page and results; build/NAME unless given.")] = None,
    workers: Workers = 2,
    scheduler: Scheduler = None,
    fresh: Fresh = False,
    figure_formats: Formats = "png",
    **options: Any,
) -> None:
    name = options.pop("study")
    study = study_named(name)(**options)
    formats, folder = formats_of(figure_formats), out or Path("build") / name
    page, path = conduct(study, folder, workers=workers, scheduler=scheduler, fresh=fresh, formats=formats)
    show_all(page.screen)
    say(str(path))
    if page.exit_code:
        raise typer.Exit(page.exit_code)


def _command(name: str) -> Any:
    study = study_named(name)

    def command(**options: Any) -> None:
        _conduct(study=name, **options)

    hints = get_type_hints(study, include_extras=True)
    help_ = f"Check within a minute that the study runs: {study.quick_form}."
    hints |= {**_COMMON, "quick": Annotated[bool, typer.Option("--quick", help=help_)]}
    parameters = [
        inspect.Parameter(
            field.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=inspect.Parameter.empty if field.default is MISSING else field.default,
            annotation=hints[field.name],
        )
        for field in fields(study)  # pyright: ignore[reportArgumentType] - every study is a dataclass
    ]
    parameters += [
        parameter
        for parameter in inspect.signature(_conduct).parameters.values()
        if parameter.kind is parameter.KEYWORD_ONLY
    ]
    command.__signature__ = inspect.Signature(parameters)  # pyright: ignore[reportFunctionMemberAccess]
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    command.__doc__ = study.__doc__
    return command_of(name, command)


_COMMON: Final[Mapping[str, Any]] = {"overrides": Overrides, "import_from": ImportFrom}
"""Options shared by several studies, by the name of the field."""
