"""All commands, and the one place where what goes wrong becomes a sentence and an exit code.

Exit 0 a result, 2 a wrong question, 3 a run that failed; each with a sentence on standard error.
"""

import sys
from typing import Final

import railgrip.cli.runs  # first: help lists commands in the order of these imports
from railgrip.cli import bench, campaigns, estimation, studies, trains, type_test
from railgrip.cli.app import app
from railgrip.console import complain
from railgrip.errors import for_user

FAMILIES: Final = (railgrip.cli.runs, trains, campaigns, type_test, estimation, bench, studies)
"""Modules whose import has put their commands on `app`."""


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; a user's mistake ends in a sentence, never in a traceback."""
    try:
        app(arguments)
    except Exception as problem:
        message = for_user(problem)
        if message is None:
            raise
        complain(str(message))
        sys.exit(message.exit_code)
