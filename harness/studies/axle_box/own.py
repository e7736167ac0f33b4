"""A user's runs, from their file to the judgement as of the paper's: its split and, beside it, each run left out."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, StrictInt

from railgrip.campaign.work import Work, call
from railgrip.errors import EstimationError
from railgrip.estimators.learned.channels import COMBINATIONS
from railgrip.estimators.learned.ensemble import Ensemble
from railgrip.estimators.learned.trained import GeneralEstimator, PaperEstimator
from railgrip.scenario.load import read_toml, validated
from railgrip.scenario.table import Name, Table, one_of
from railgrip.studies.axle_box.evaluate import Recipe, Score, average, best_of, judge, within_runs, without_each
from railgrip.studies.axle_box.reduction import SLOW, SPECTRAL, Run
from railgrip.studies.axle_box.tables import own_tables
from railgrip.studies.axle_box.training import general, paper_estimator
from railgrip.trace.table import DataTable


class RunsTable(Table):
    """[runs]: where recordings and labels are, from the folder of the file."""

    folder: str
    labels: str


class NetworkTable(Table):
    """[network]: the networks of the paper's kind."""

    inputs: Annotated[str, one_of(COMBINATIONS, "; ")] = "longitudinal"
    bias: Literal["inside", "outside"] = "inside"
    starts: Annotated[StrictInt, Field(ge=1, le=100)] = 5

    def recipe(self) -> Recipe:
        """Return how they are trained."""
        return Recipe(inputs=self.inputs, bias=self.bias, starts=self.starts)


class OwnFile(Table):
    """Everything that decides what is learned from a user's runs."""

    name: Name
    runs: RunsTable
    network: NetworkTable = NetworkTable()
    data: DataTable | None = None


def read_own(file: Path) -> OwnFile:
    """Return what a TOML file asks for.

    Raises:
        ScenarioError: The file is missing or says something else; each problem in one sentence.
    """
    return validated(OwnFile, read_toml(file), directory=file.parent, origin=file.name)


MEMBERS = 20
FEWEST = 4
"""Runs without which no interval can be found: some must be outside of every draw."""


def judge_own(
    runs: Sequence[Run], recipe: Recipe, work: Work, *, members: int = MEMBERS
) -> tuple[dict[str, Any], dict[str, PaperEstimator | GeneralEstimator]]:
    """Return the tables on a user's runs and the estimators trained on them, by the name of their files.

    Args:
        recipe: Of the networks of the paper's kind, one for each speed class.

    Raises:
        EstimationError: There are too few runs.
    """
    if len(runs) < FEWEST:
        raise EstimationError(f"there are {len(runs)} labelled runs; training and judging need {FEWEST} or more.")
    several = _classes(runs)
    tasks: dict[tuple[str, int], Callable[[], Any]] = {("whole", 0): partial(general, runs, members)}
    for group, own in several.items():
        tasks["within", group] = partial(within_runs, own, recipe)
        tasks["without one", group] = partial(without_each, own, recipe)
        tasks["network", group] = partial(best_of, own, recipe)
    tasks |= {("each", k): partial(_without, runs, k, members) for k in range(len(runs))}
    work.notify("training and judging")
    results: dict[tuple[str, int], Any] = dict(zip(tasks, work.map(call, tasks.values()), strict=True))
    ensemble: Ensemble = results["whole", 0][0]
    tables = own_tables(
        recipe,
        {group: results["within", group] for group in several},
        {group: results["without one", group] for group in several},
        average(results["each", k] for k in range(len(runs))),
    )
    trained: dict[str, PaperEstimator | GeneralEstimator] = {
        "friction": GeneralEstimator(slow=SLOW, spectral=SPECTRAL, ensemble=ensemble)
    }
    trained |= {f"friction_{group}mph": paper_estimator(results["network", group], group, recipe) for group in several}
    return tables, trained


def _classes(runs: Sequence[Run]) -> dict[int, list[Run]]:
    """Return the runs of each speed class that has several."""
    groups = {g: [run for run in runs if run.group == g] for g in sorted({run.group for run in runs})}
    return {g: own for g, own in groups.items() if len(own) > 1}


def _without(runs: Sequence[Run], place: int, members: int) -> Score:
    """Judge the estimator for all speeds on one run that it has not seen."""
    estimator, mean = general([run for k, run in enumerate(runs) if k != place], members)
    return judge(estimator, mean, [runs[place]])
