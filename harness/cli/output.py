"""Results as JSON, for other programs."""

import json
from typing import Annotated, Any

import typer

from railgrip.report.console import say

Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON on standard output, and nothing else.")]


def print_json(value: Any) -> None:
    """Print a value as JSON on standard output; numbers that are not finite become null."""
    say(json.dumps(_finite(value), indent=2, ensure_ascii=False, allow_nan=False))


def _finite(value: Any) -> Any:
    match value:
        case dict():
            return {str(key): _finite(each) for key, each in value.items()}
        case list() | tuple():
            return [_finite(each) for each in value]
        case float() if value != value or value in (float("inf"), float("-inf")):
            return None
        case _:
            return value
