"""The report of a study, in Markdown."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from railgrip.studies.learn.evaluate import Recipe, Score
from railgrip.studies.learn.study import PUBLISHED, Rows, Study, over_speeds

READINGS_OF_EQUATION_4: Final = (
    "bias inside", "bias outside", "bias inside, weights kept small", "bias outside, weights kept small",
)  # fmt: skip


def report(made: Study) -> str:
    """Return the report as Markdown."""
    speeds = list(made.runs)
    lines = ["# Friction from axle-box accelerations", ""]
    lines += ["## Table 3 of the paper, and ours on the simulated campaign", ""]
    lines += [
        "Last 20 % of each run, networks 4-6-1 trained on the first 80 % of the same runs; mean over "
        f"{made.recipe.starts} random starts, best and worst of them. Inputs: {made.recipe.inputs}. Equation (4) is "
        "printed with its bias outside of the logistic function; the text, which wants an output between 0 and 1 and "
        "names a logsig layer, and figure 9 put it inside. Both are here, each fitted to the data alone and with the "
        f"weights kept small (weight decay {made.recipe.decay:g}).",
        "",
    ]
    rows = [
        ["paper, RMSE", *(_f(PUBLISHED[s][0]) for s in speeds)],
        ["paper, MAE", *(_f(PUBLISHED[s][1]) for s in speeds)],
    ]
    for name in READINGS_OF_EQUATION_4:
        row = made.split[name]
        rows += [[f"{name}: RMSE", *(_f(row[s].rmse) for s in speeds)]]
        rows += [[f"{name}: MAE", *(f"{_f(row[s].mae)}{_mark(row[s].mae, s)}" for s in speeds)]]
        rows += [[f"{name}: best, worst MAE", *(f"{_f(row[s].best)}, {_f(row[s].worst)}" for s in speeds)]]
    rows += [["always the mean, MAE", *(_f(made.split["bias inside"][s].mae_of_mean) for s in speeds)]]
    lines += [*_table(["", *(f"{s} mph" for s in speeds)], rows), ""]
    lines += ["✓ at or below the paper's MAE.", ""]
    lines += [
        "Fitted to the data alone, a few random starts end in networks of huge weights that are wrong by 0.1 right "
        "after the part they were trained on, and make the mean. The weight decay is chosen without a look at the last "
        "20 %: MAE over the last fifth of the training part of networks trained on what is before it "
        f"({_starts(made.decays)}). From 1e-9 to 1e-7 it makes little difference; taken is the middle.",
        "",
        *_scores({f"decay {name}": row for name, row in made.decays.items()}, speeds),
        "",
    ]
    lines += ["## What the networks of this split have learned", ""]
    lines += [
        "*Labels exchanged*: the same data with the labels of other runs, so that friction is not in them any more. A "
        "network that does as well has learned to recognise runs. *First second is zero*: the high-pass starts at the "
        "mean of the first second instead of the first sample, whose vibration it otherwise keeps as an offset of the "
        "whole run. MAE, as everywhere below with the weights kept small.",
        "",
    ]
    takes_apart = ("bias inside, weights kept small", "labels exchanged", "first second is zero")
    lines += [*_scores({k: made.split[k] for k in takes_apart}, speeds), ""]
    lines += [f"The paper's eight combinations of inputs under the same split ({_starts(made.inputs)}, MAE):", ""]
    lines += [*_scores(made.inputs, speeds), ""]
    lines += ["## The same networks on runs they have not seen", ""]
    lines += ["MAE, and in brackets that of always saying the mean label of the training.", ""]
    lines += [*_scores(made.honest, speeds, beside=True), ""]
    lines += ["## One estimator for all speeds, on runs it has not seen", ""]
    lines += [
        "Trained on 200 m runs of its own (other seeds, tracks ERRI low and FRA 6, friction spread within each "
        "condition): networks estimate the slope of the creep curve from lateral and yaw acceleration, a second stage "
        "says which friction goes with it. MAE, in brackets that of the mean label of its training; dry or not: MAE of "
        "who is told only whether the rail is dry, and says the mean label of its training on such rails; coverage and "
        "width of the 90 % interval; the last three over all speeds.",
        "",
        *_general(made.general, speeds),
        "",
    ]
    return "\n".join(lines)


def _mark(mae: float, speed: int) -> str:
    return " ✓" if mae <= PUBLISHED[speed][1] else ""


def _starts(rows: Rows) -> str:
    count = next(iter(next(iter(rows.values())).values())).starts
    return f"{count} random start{'s' if count > 1 else ''}"


def _general(rows: Rows, speeds: list[int]) -> list[str]:
    body: list[list[str]] = []
    for name, row in rows.items():
        mean = over_speeds(row)
        cells = [_beside(row[s]) for s in speeds] + [_beside(mean)]
        rule = "" if mean.mae_of_rule is None else _f(mean.mae_of_rule)
        body.append([name, *cells, rule, f"{100 * (mean.coverage or 0):.0f} %", _f(mean.width or 0)])
    return _table(["", *(f"{s} mph" for s in speeds), "all", "dry or not", "coverage", "width"], body)


def _scores(rows: Rows, speeds: list[int], *, beside: bool = False) -> list[str]:
    def cell(score: Score) -> str:
        return _beside(score) if beside else _f(score.mae)

    body = [[name, *(cell(row[s]) for s in speeds), cell(over_speeds(row))] for name, row in rows.items()]
    return _table(["", *(f"{s} mph" for s in speeds), "all"], body)


def _beside(score: Score) -> str:
    return f"{_f(score.mae)} ({_f(score.mae_of_mean)})"


def _f(value: float) -> str:
    return f"{value:.4f}"


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> list[str]:
    names = list(head)
    return [
        f"| {' | '.join(names)} |",
        f"|{'---|' * len(names)}",
        *(f"| {' | '.join(row)} |" for row in rows),
    ]


def own_report(
    count: int,
    recipe: Recipe,
    split: Mapping[int, Score],
    left_out: Mapping[int, Score],
    general: Score,
    remarks: Sequence[str],
) -> str:
    """Return the report on a user's runs as Markdown; rows by speed class in mph.

    Args:
        count: Of runs.
        recipe: Of the networks of the paper's kind.
        split: Under the paper's split; empty where no speed class has two runs.
        left_out: The same networks, each run left out once.
        general: Of the estimator for all speeds, each run left out once.
        remarks: What was mended in the recordings.
    """
    lines = [f"# Friction from axle-box accelerations: {count} runs", ""]
    if split:
        speeds = list(split)
        rows = {"last 20 % of runs seen": split, "a run left out": left_out}
        lines += ["## Networks of the paper's kind, one for each speed class", ""]
        lines += [
            f"Inputs: {recipe.inputs}; bias {recipe.bias}; {_starts({'': split})}. MAE, in brackets that of always "
            "saying the mean label.",
            "",
        ]
        lines += [*_scores(rows, speeds, beside=True), ""]
        lines += ["The first row is met by recognising runs; only the second says what a new run can expect.", ""]
    lines += ["## One estimator for all speeds, each run left out once", ""]
    lines += _table(
        ["MAE", "always the mean", "coverage of the 90 % interval", "width"],
        [[_f(general.mae), _f(general.mae_of_mean), f"{100 * (general.coverage or 0):.0f} %", _f(general.width or 0)]],
    )
    lines += ["", "## What was mended in the recordings", ""]
    lines += [f"- {remark}" for remark in remarks] or ["Nothing."]
    return "\n".join([*lines, ""])
