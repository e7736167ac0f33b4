"""Commands for developers of railgrip: baselines and searches."""

from typing import ClassVar

import typer

from railgrip.cli.app import Command, Commands


class _Maintain(Commands):
    sections: ClassVar = {
        "Baselines": {
            "regress": Command("baselines:regress", "Run everything that has a baseline and compare every number."),
            "accept": Command("baselines:accept", "Update the baselines to the results of the last regress."),
            "validation": Command("baselines:validation", "Write the accepted distances into the documentation."),
            "conditioning": Command("baselines:conditioning", "Repeat stops with other parameters and sensors."),
            "discretisation": Command("baselines:discretisation", "Repeat stops with smaller communication steps."),
        },
        "FMUs": {"fmus": Command("fmus:survey_command", "Open and step the FMUs of a folder; write a table.")},
        "Searches": {
            "calibrate": Command("searches:calibrate", "Fit the levels of the scenarios to the published distances."),
            "tune-control": Command("searches:tune_control", "Search the parameters of the control laws."),
            "tune": Command("searches:tune", "Search the twelve noises of the field test's filter."),
        },
    }  # fmt: skip


maintain = typer.Typer(
    cls=_Maintain,
    help="Commands for those who change railgrip itself.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
)


@maintain.callback()
def group() -> None:
    """Commands for those who change railgrip itself."""
