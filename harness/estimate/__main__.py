"""The commands of this room by themselves: python -m harness.estimate observability | estimate | rig."""

import sys

import typer
from rich.console import Console

from estimators.errors import EstimatorError
from fmus.errors import FmuError as BuildError
from harness.estimate.command import add_to
from harness.fmu import FmuError, PlantFailed
from harness.scenario.error import ScenarioError

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
add_to(app)


def main() -> None:
    """Run the command line; a user's mistake ends in a sentence, never in a traceback."""
    problems = Console(stderr=True)
    try:
        app()
    except (ScenarioError, EstimatorError, FmuError, PlantFailed, BuildError) as problem:
        problems.print(str(problem), style="red", highlight=False, markup=False, soft_wrap=True)
        sys.exit(3 if isinstance(problem, PlantFailed | BuildError) else 2)


if __name__ == "__main__":
    main()
