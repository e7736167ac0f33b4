"""The tables of the paper's study and of a user's own runs."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

from railgrip.report.table import Table
from railgrip.studies.axle_box.evaluate import Recipe, Score, average
from railgrip.studies.axle_box.training import PUBLISHED, Results, Rows

READINGS_OF_EQUATION_4: Final = (
    "bias inside", "bias outside", "bias inside, weights kept small", "bias outside, weights kept small",
)  # fmt: skip
TAKES_APART: Final = ("bias inside, weights kept small", "labels exchanged", "first second is zero")
_FORM: Final = "{:.4f}"


def tables_of(results: Results) -> dict[str, Any]:
    """Return what the page of the paper's study names."""
    speeds = list(results.runs)
    return {
        "recipe": results.recipe,
        "table3": _table3(results.split, speeds),
        "decays": _scores({f"decay {name}": row for name, row in results.decays.items()}, speeds),
        "decay_starts": _starts(results.decays),
        "apart": _scores({name: results.split[name] for name in TAKES_APART}, speeds),
        "inputs": _scores(results.inputs, speeds),
        "input_starts": _starts(results.inputs),
        "honest": _scores(results.honest, speeds, beside=True),
        "general": _general(results.general, speeds),
    }


def own_tables(
    recipe: Recipe, split: Mapping[int, Score], left_out: Mapping[int, Score], general: Score
) -> dict[str, Any]:
    """Return what the page on a user's runs names; rows by speed class in mph.

    Args:
        split: Under the paper's split; empty where no speed class has two runs.
        left_out: The same networks, each run left out once.
        general: Of the estimator for all speeds, each run left out once.
    """
    rows = {"last 20 % of runs seen": split, "a run left out": left_out}
    return {
        "recipe": recipe,
        "starts": _starts({"": split}) if split else "",
        "networks": _scores(rows, list(split), beside=True) if split else None,
        "general": Table.of(
            ("MAE", "always the mean", "coverage of the 90 % interval", "width"),
            [(general.mae, general.mae_of_mean, _coverage(general), general.width or 0.0)],
            _FORM,
            left=0,
        ),
    }


def _table3(split: Rows, speeds: Sequence[int]) -> Table:
    rows = [[f"paper, {name}", *(PUBLISHED[s][k] for s in speeds)] for k, name in enumerate(("RMSE", "MAE"))]
    for name in READINGS_OF_EQUATION_4:
        row = split[name]
        rows.append([f"{name}: RMSE", *(row[s].rmse for s in speeds)])
        rows.append([f"{name}: MAE", *(_FORM.format(row[s].mae) + _mark(row[s].mae, s) for s in speeds)])
        rows.append([f"{name}: best, worst MAE", *(f"{row[s].best:.4f}, {row[s].worst:.4f}" for s in speeds)])
    rows.append(["always the mean, MAE", *(split["bias inside"][s].mae_of_mean for s in speeds)])
    return Table.of(["", *_classes(speeds)], rows, _FORM)


def _general(rows: Rows, speeds: Sequence[int]) -> Table:
    body: list[list[str | float | None]] = []
    for name, row in rows.items():
        mean = average(row.values())
        scores = [*(row[s] for s in speeds), mean]
        body.append([name, *map(_beside, scores), mean.mae_of_rule, _coverage(mean), mean.width or 0.0])
    return Table.of(["", *_classes(speeds), "all", "dry or not", "coverage", "width"], body, _FORM)


def _scores(rows: Rows, speeds: Sequence[int], *, beside: bool = False) -> Table:
    scores = [(name, [*(row[s] for s in speeds), average(row.values())]) for name, row in rows.items()]
    body = [(name, *(_beside(one) if beside else one.mae for one in row)) for name, row in scores]
    return Table.of(["", *_classes(speeds), "all"], body, _FORM)


def _classes(speeds: Sequence[int]) -> list[str]:
    return [f"{speed} mph" for speed in speeds]


def _mark(mae: float, speed: int) -> str:
    return " ✓" if mae <= PUBLISHED[speed][1] else ""


def _starts(rows: Rows) -> str:
    count = next(iter(next(iter(rows.values())).values())).starts
    return f"{count} random start{'s' if count > 1 else ''}"


def _coverage(score: Score) -> str:
    return f"{100 * (score.coverage or 0):.0f} %"


def _beside(score: Score) -> str:
    return f"{score.mae:.4f} ({score.mae_of_mean:.4f})"
