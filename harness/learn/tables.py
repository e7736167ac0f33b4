"""The report of a study, in Markdown."""

from collections.abc import Iterable, Mapping

from harness.learn.evaluate import Score
from harness.learn.study import PUBLISHED, Rows, Study, over_speeds


def report(made: Study) -> str:
    """Return the report as Markdown."""
    speeds = list(made.runs)
    lines = ["# Friction from axle-box accelerations", ""]
    lines += ["## Table 3 of the paper, and ours on the simulated campaign", ""]
    lines += [
        "Last 20 % of each run, networks trained on the first 80 % of the same runs; mean of all random starts.",
        "",
    ]
    rows = [
        ["paper, RMSE", *(_f(PUBLISHED[s][0]) for s in speeds)],
        ["paper, MAE", *(_f(PUBLISHED[s][1]) for s in speeds)],
    ]
    for name in ("bias inside", "bias outside"):
        rows += [[f"ours, {name}, RMSE", *(_f(made.split[name][s].rmse) for s in speeds)]]
        rows += [[f"ours, {name}, MAE", *(_f(made.split[name][s].mae) for s in speeds)]]
        rows += [[f"ours, {name}, best MAE", *(_f(made.split[name][s].best) for s in speeds)]]
    rows += [["always the mean, MAE", *(_f(made.split["bias inside"][s].mae_of_mean) for s in speeds)]]
    lines += [*_table(["", *(f"{s} mph" for s in speeds)], rows), ""]
    lines += ["## What the networks of this split have learned", ""]
    lines += [
        "*Labels exchanged*: the same data with the labels of other runs, so that friction is not in them any more. A "
        "network that does as well has learned to recognise runs. *First second is zero*: the high-pass starts at the "
        "mean of the first second instead of the first sample, whose vibration it otherwise keeps as an offset of the "
        "whole run.",
        "",
    ]
    lines += [*_scores({k: v for k, v in made.split.items() if k not in ("bias outside",)}, speeds), ""]
    lines += ["Other inputs under the same split (MAE):", "", *_scores(made.inputs, speeds), ""]
    lines += ["## The same networks on runs they have not seen", ""]
    lines += ["MAE, and in brackets that of always saying the mean label of the training.", ""]
    lines += [*_scores(made.honest, speeds, beside=True), ""]
    lines += ["## One estimator for all speeds, on runs it has not seen", ""]
    lines += [
        "Trained on 200 m runs of its own (other seeds, tracks ERRI low and FRA 6, friction spread within each "
        "condition): networks estimate the slope of the creep curve from lateral and yaw acceleration, a second stage "
        "says which friction goes with it. MAE, in brackets that of the mean label of its training; coverage and width "
        "of the 90 % interval over all speeds.",
        "",
        *_general(made.general, speeds),
        "",
    ]
    return "\n".join(lines)


def _general(rows: Rows, speeds: list[int]) -> list[str]:
    body: list[list[str]] = []
    for name, row in rows.items():
        mean = over_speeds(row)
        cells = [_beside(row[s]) for s in speeds] + [_beside(mean)]
        body.append([name, *cells, f"{100 * (mean.coverage or 0):.0f} %", _f(mean.width or 0)])
    return _table(["", *(f"{s} mph" for s in speeds), "all", "coverage", "width"], body)


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


def own_report(count: int, split: Mapping[int, Score], left_out: Mapping[int, Score], general: Score) -> str:
    """Return the report on a user's runs as Markdown; rows by speed class in mph."""
    lines = [f"# Friction from axle-box accelerations: {count} runs", ""]
    if split:
        speeds = list(split)
        rows = {"last 20 % of runs seen": split, "a run left out": left_out}
        lines += ["## Networks 4-6-1, one for each speed class", "", "MAE (of always saying the mean label).", ""]
        lines += [*_scores(rows, speeds, beside=True), ""]
        lines += ["The first row is met by recognising runs; only the second says what a new run can expect.", ""]
    lines += ["## One estimator for all speeds, each run left out once", ""]
    lines += _table(
        ["MAE", "always the mean", "coverage of the 90 % interval", "width"],
        [[_f(general.mae), _f(general.mae_of_mean), f"{100 * (general.coverage or 0):.0f} %", _f(general.width or 0)]],
    )
    return "\n".join([*lines, ""])
