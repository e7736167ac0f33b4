"""A user's runs judged as the paper's: its split and, beside it, each run left out."""

from collections.abc import Sequence

from estimators.learned.ensemble import Ensemble
from harness.learn.evaluate import Recipe, Score, judge, within_runs, without_each
from harness.learn.gather import Run
from harness.learn.study import general, over_speeds
from harness.learn.tables import own_report
from harness.learn.users import DataError

MEMBERS = 10
FEWEST = 4
"""Runs without which no interval can be found: some must be outside of every draw."""


def judge_own(runs: Sequence[Run]) -> tuple[str, Ensemble]:
    """Return the report on a user's runs and the estimator trained on all of them.

    Raises:
        DataError: There are too few runs.
    """
    if len(runs) < FEWEST:
        raise DataError(f"there are {len(runs)} labelled runs; training and judging need {FEWEST} or more.")
    groups = {g: [run for run in runs if run.group == g] for g in sorted({run.group for run in runs})}
    several = {g: own for g, own in groups.items() if len(own) > 1}
    recipe = Recipe(starts=5)
    split = {g: within_runs(own, recipe) for g, own in several.items()}
    left_out = {g: without_each(own, recipe) for g, own in several.items()}
    ensemble, _ = general(runs, MEMBERS)
    return own_report(len(runs), split, left_out, _without_each_general(runs)), ensemble


def _without_each_general(runs: Sequence[Run]) -> Score:
    """Leave each run out of the estimator for all speeds once."""
    scores: list[Score] = []
    for left in runs:
        made, mean = general([run for run in runs if run is not left], MEMBERS)
        scores.append(judge(made, mean, [left]))
    return over_speeds(dict(enumerate(scores)))
