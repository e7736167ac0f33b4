"""A user's runs judged as the paper's: its split and, beside it, each run left out."""

from collections.abc import Sequence

from estimators.learned.ensemble import Ensemble
from harness.learn.evaluate import Recipe, Score, judge, within_runs, without_each
from harness.learn.gather import Run
from harness.learn.study import general, over_speeds
from harness.learn.tables import own_report
from harness.learn.users import DataError
from harness.learn.workers import workers as processes

MEMBERS = 10
FEWEST = 4
"""Runs without which no interval can be found: some must be outside of every draw."""


def judge_own(runs: Sequence[Run], *, workers: int = 2) -> tuple[str, Ensemble]:
    """Return the report on a user's runs and the estimator trained on all of them.

    Args:
        workers: Processes.

    Raises:
        DataError: There are too few runs.
    """
    if len(runs) < FEWEST:
        raise DataError(f"there are {len(runs)} labelled runs; training and judging need {FEWEST} or more.")
    groups = {g: [run for run in runs if run.group == g] for g in sorted({run.group for run in runs})}
    several = {g: own for g, own in groups.items() if len(own) > 1}
    recipe = Recipe(starts=5)
    with processes(workers) as pool:
        whole = pool.submit(general, runs, MEMBERS)
        split = {g: pool.submit(within_runs, own, recipe) for g, own in several.items()}
        left_out = {g: pool.submit(without_each, own, recipe) for g, own in several.items()}
        each = [pool.submit(_without, runs, k) for k in range(len(runs))]
        ensemble, _ = whole.result()
        text = own_report(
            len(runs),
            {g: one.result() for g, one in split.items()},
            {g: one.result() for g, one in left_out.items()},
            over_speeds(dict(enumerate(one.result() for one in each))),
        )
    return text, ensemble


def _without(runs: Sequence[Run], left: int) -> Score:
    """Judge the estimator for all speeds on one run that it has not seen."""
    made, mean = general([run for k, run in enumerate(runs) if k != left], MEMBERS)
    return judge(made, mean, [runs[left]])
