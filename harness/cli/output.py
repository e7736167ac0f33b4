"""Machine-readable results of commands."""

import json
from typing import Annotated, Any

import typer

from railgrip.base.files import finite
from railgrip.report.console import say

AsJson = Annotated[
    bool,
    typer.Option("--json", help="Print the result as JSON, in SI units, and nothing else on standard output."),
]


def print_json(value: Any) -> None:
    """Print a value of lists, dictionaries, strings and numbers as JSON; numbers that are not finite are null.

    Errors are not results: their messages go to standard error, and standard output stays empty.
    """
    say(json.dumps(finite(value), indent=1, ensure_ascii=False, allow_nan=False))
