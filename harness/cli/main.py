"""The command line; a mistake of the user becomes a sentence and an exit code (`railgrip.report.console.answer`).

Exit 0 a result, 2 a wrong question, 3 a run that failed; each with a sentence on standard error.
"""

from railgrip.cli.app import app
from railgrip.report.console import answer


def main(arguments: list[str] | None = None) -> None:
    """Run the command line."""
    answer(lambda: app(arguments, prog_name="railgrip"))
