"""The command line; a user's mistake ends in a message and an exit code (`railgrip.report.console.answer`).

Exit codes are 0 for a result, 2 for invalid input, 3 for a run that failed, the last two with a message.
"""

from railgrip.cli.app import app
from railgrip.report.console import answer


def main(arguments: list[str] | None = None) -> None:
    """Run the command line."""
    answer(lambda: app(arguments, prog_name="railgrip"))
