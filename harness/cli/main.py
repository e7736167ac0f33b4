"""All commands; what goes wrong becomes a sentence and an exit code (`railgrip.console.answer`).

Exit 0 a result, 2 a wrong question, 3 a run that failed; each with a sentence on standard error.
"""

from typing import Final

import railgrip.cli.runs  # first: help lists commands in the order of these imports
from railgrip.cli import bench, campaigns, estimation, fmus, studies, trains
from railgrip.cli.app import app
from railgrip.console import answer

FAMILIES: Final = (railgrip.cli.runs, fmus, trains, campaigns, estimation, bench, studies)
"""Modules whose import has put their commands on `app`."""


def main(arguments: list[str] | None = None) -> None:
    """Run the command line."""
    answer(lambda: app(arguments))
