"""Tables and figures of the study, and tables of a user's own runs."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import spearmanr

from railgrip.estimators.learned.network import Network
from railgrip.estimators.learned.preprocessing import BLOCKS
from railgrip.report import palette, style
from railgrip.report.table import ReportTable
from railgrip.studies.axle_box.evaluate import Score, TrainingRecipe, average, exchange_labels, parts_of
from railgrip.studies.axle_box.instrumented_car import CHANNELS, RATE, LabelledRun, spectral_features
from railgrip.studies.axle_box.training import PUBLISHED, PUBLISHED_BEST, SPEEDS, AxleBoxResults, Rows
from railgrip.studies.papers.pages import PaperRow, comparison

READINGS_OF_EQUATION_4: Final = (
    "bias inside", "bias outside", "bias inside, weights kept small", "bias outside, weights kept small",
)  # fmt: skip
EXPLAINING: Final = ("bias inside, weights kept small", "labels exchanged", "first second is zero")
_FORM: Final = "{:.4f}"
_ACCELERATIONS: Final[Mapping[int, int]] = dict(zip(SPEEDS, range(5, 9), strict=True))
_ESTIMATES: Final[Mapping[int, int]] = dict(zip(SPEEDS, range(10, 14), strict=True))
"""Numbers of the paper's figures by speed."""


def tables_of(results: AxleBoxResults) -> dict[str, Any]:
    """Return the values of the page of the study."""
    speeds = list(results.runs)
    return {
        "recipe": results.recipe,
        "table3": _table3(results.scores["split"], speeds),
        "decays": _scores({f"decay {name}": row for name, row in results.scores["decays"].items()}, speeds),
        "decay_starts": _starts(results.scores["decays"]),
        "apart": _scores({name: results.scores["split"][name] for name in EXPLAINING}, speeds),
        "inputs": _scores(results.scores["inputs"], speeds),
        "input_starts": _starts(results.scores["inputs"]),
        "neurons": _scores({f"{name} hidden neurons": row for name, row in results.scores["neurons"].items()}, speeds),
        "statements": _scores(results.scores["statements"], speeds),
        "slip_rate": _slip_rates(results.slip_rates, speeds),
        "honest": _scores(results.scores["honest"], speeds, with_mean=True),
        "general": _general(results.scores["general"], speeds),
    }


def compare_with_paper(results: AxleBoxResults) -> ReportTable:
    """Return the quantities of figures 5 to 13, published and reproduced; see `comparison`."""
    levels = {s: np.vstack([run.blocks[:, CHANNELS["longitudinal"]] for run in runs]).mean()
              for s, runs in results.runs.items()}  # fmt: skip
    hidden, inputs = next(iter(results.networks.values())).network.hidden_weights.shape
    rows = [
        PaperRow("Fig. 5 to 8", f"mean amplitude at {', '.join(map(str, levels))} mph [m/s²]", "rises with speed",
                 " / ".join(f"{level:.4f}" for level in levels.values())),
        PaperRow("Fig. 9", "inputs", 4, inputs, "{:d}", is_chosen=True),
        PaperRow("Fig. 9", "hidden neurons", 6, hidden, "{:d}", is_chosen=True),
    ]  # fmt: skip
    for s, network in results.networks.items():
        late = parts_of(results.runs[s], results.recipe)[1]
        error = float(np.abs(np.concatenate([network(x) - y for x, y in late])).mean())
        quantity = f"MAE at {s} mph, one of the best networks"
        rows.append(PaperRow(f"Fig. {_ESTIMATES[s]}", quantity, PUBLISHED_BEST[s], error, _FORM))
    slow, fast = min(levels), max(levels)
    rows += [
        PaperRow("Table 3", f"MAE at {fast} over MAE at {slow} mph, {name}", PUBLISHED[fast][1] / PUBLISHED[slow][1],
                 results.scores["split"][name][fast].mae / results.scores["split"][name][slow].mae, "{:.2f}")
        for name in ("bias inside, weights kept small", "first second is zero") if fast > slow
    ]  # fmt: skip
    early = {s: sum(len(labels) for _, labels in parts_of(runs, results.recipe)[0]) for s, runs in results.runs.items()}
    for quantity, published, values in (
        ("duration of training data [s]", "longer at lower speeds", [n * BLOCKS[s] / RATE for s, n in early.items()]),
        ("number of training samples", "not stated", early.values()),
    ):
        rows.append(
            PaperRow("Table 3", f"{quantity}, {', '.join(map(str, early))} mph", published,
                     " / ".join(f"{value:.0f}" for value in values))
        )  # fmt: skip
    return comparison(rows)


def tables_of_recordings(
    recipe: TrainingRecipe, split: Mapping[int, Score], left_out: Mapping[int, Score], general: Score
) -> dict[str, Any]:
    """Return the values of the page on a user's runs; rows by speed class in mph.

    Args:
        split: Under the paper's split; empty where no speed class has two runs.
        left_out: The same networks, each run left out once.
        general: Of the general estimator, each run left out once.
    """
    rows = {"last 20 % of runs seen": split, "a run left out": left_out}
    return {
        "recipe": recipe,
        "starts": _starts({"": split}) if split else "",
        "networks": _scores(rows, list(split), with_mean=True) if split else None,
        "general": ReportTable.of(
            ("MAE", "always the mean", "coverage of the 90 % interval", "width"),
            [(general.mae, general.mae_of_mean, _coverage(general), general.width or 0.0)],
            _FORM,
            left=0,
        ),
    }


def _table3(split: Rows, speeds: Sequence[int]) -> ReportTable:
    rows = [[f"paper, {name}", *(PUBLISHED[s][k] for s in speeds)] for k, name in enumerate(("RMSE", "MAE"))]
    for name in READINGS_OF_EQUATION_4:
        row = split[name]
        rows.append([f"{name}: RMSE", *(row[s].rmse for s in speeds)])
        rows.append([f"{name}: MAE", *(_FORM.format(row[s].mae) + _mark(row[s].mae, s) for s in speeds)])
        rows.append([f"{name}: best, worst MAE", *(f"{row[s].best:.4f}, {row[s].worst:.4f}" for s in speeds)])
    rows.append(["always the mean, MAE", *(split["bias inside"][s].mae_of_mean for s in speeds)])
    return ReportTable.of(["", *_classes(speeds)], rows, _FORM)


def _general(rows: Rows, speeds: Sequence[int]) -> ReportTable:
    body: list[list[str | float | None]] = []
    for name, row in rows.items():
        mean = average(row.values())
        scores = [*(row[s] for s in speeds), mean]
        body.append([name, *map(_with_error_of_mean, scores), mean.mae_of_rule, _coverage(mean), mean.width or 0.0])
    return ReportTable.of(["", *_classes(speeds), "all", "dry or not", "coverage", "width"], body, _FORM)


def _scores(rows: Rows, speeds: Sequence[int], *, with_mean: bool = False) -> ReportTable:
    scores = [(name, [*(row[s] for s in speeds), average(row.values())]) for name, row in rows.items()]
    body = [(name, *(_with_error_of_mean(cell) if with_mean else cell.mae for cell in row)) for name, row in scores]
    return ReportTable.of(["", *_classes(speeds), "all"], body, _FORM)


def _slip_rates(rates: Mapping[str, Mapping[int, Sequence[tuple[float, float]]]], speeds: Sequence[int]) -> ReportTable:
    rows: list[list[str | float | None]] = []
    for name, of_set in rates.items():
        columns = [sorted(of_set[s]) for s in speeds]
        rows.append([f"{name}: rank correlation", *(f"{_rank_correlation(runs):+.2f}".replace("-", "−")
                                                    for runs in columns)])  # fmt: skip
        rows.append([f"{name}: rate at lowest, highest friction [1/s]",
                     *(f"{runs[0][1]:.4f}, {runs[-1][1]:.4f}" for runs in columns)])  # fmt: skip
    return ReportTable.of(["", *_classes(speeds)], rows)


def _rank_correlation(pairs: Sequence[tuple[float, float]]) -> float:
    friction, rates = np.transpose(pairs)
    correlation: Any = spearmanr(friction, rates)
    return float(correlation.statistic)


def _classes(speeds: Sequence[int]) -> list[str]:
    return [f"{speed} mph" for speed in speeds]


def _mark(mae: float, speed: int) -> str:
    return " ✓" if mae <= PUBLISHED[speed][1] else ""


def _starts(rows: Rows) -> str:
    count = next(iter(next(iter(rows.values())).values())).starts
    return f"{count} random start{'s' if count > 1 else ''}"


def _coverage(score: Score) -> str:
    return f"{100 * (score.coverage or 0):.0f} %"


def _with_error_of_mean(score: Score) -> str:
    return f"{score.mae:.4f} ({score.mae_of_mean:.4f})"


def draw(results: AxleBoxResults) -> dict[str, Figure]:
    """Draw every figure, by the name of its file."""
    return {
        "errors.png": errors(results),
        "processed.png": acceleration_figure(results.runs),
        "network.svg": structure(next(iter(results.networks.values())).network),
        "campaign.png": campaign(results),
        "within_runs.png": over_time(results),
    }


def errors(results: AxleBoxResults) -> Figure:
    """Mean absolute error of each judgement and of the mean label."""
    published = float(np.mean([PUBLISHED[s][1] for s in results.runs]))
    rows: list[tuple[str, float, float | None, str]] = [("paper, its split", published, None, palette.GREY)]
    for name, row, colour in (
        *((f"4-6-1: {k}", v, palette.BLUE) for k, v in results.scores["split"].items()),
        *((f"4-6-1: {k}", v, palette.VERMILION) for k, v in results.scores["honest"].items()),
        *((f"all speeds: {k}", v, palette.GREEN) for k, v in results.scores["general"].items()),
    ):
        mean = average(row.values())
        rows.append((name, mean.mae, mean.mae_of_mean, colour))
    sheet, axes = style.panels(8.0, 0.33 * len(rows) + 1.0)
    for k, (_, mae, of_mean, colour) in enumerate(rows):
        axes.barh(-k, mae, color=colour, height=0.65)
        if of_mean is not None:
            axes.plot([of_mean, of_mean], [-k - 0.42, -k + 0.42], color="black", linewidth=1.6)
    axes.set_yticks([-k for k in range(len(rows))], [row[0] for row in rows], fontsize=8)
    style.dress(axes, x="mean absolute error of friction, mean over speeds; black: always the mean label")
    axes.grid(visible=False, axis="y")
    return sheet


def campaign(results: AxleBoxResults) -> Figure:
    """The general estimator on each run of the campaign: estimates every 20 m with interval, and the label."""
    sheet = style.figure(8.0, 3.2)
    for axes, (speed, runs) in zip(
        np.atleast_1d(sheet.subplots(1, len(results.runs), sharey=True)), results.runs.items(), strict=True
    ):
        for k, run in enumerate(sorted(runs, key=lambda r: r.friction)):
            estimate = results.ensemble(spectral_features(run))
            place = k + np.linspace(-0.3, 0.3, len(estimate.friction))
            axes.vlines(
                place,
                estimate.lower,
                estimate.upper,
                color=palette.GREEN,
                alpha=0.3,
                linewidth=1,
                label="90 % interval",
            )
            axes.plot(place, estimate.friction, ".", color=palette.GREEN, markersize=3, label="estimate")
            axes.plot([k - 0.4, k + 0.4], [run.friction] * 2, color="black", linewidth=1.6, label="label")
        if speed == next(iter(results.runs)):
            axes.legend(*(part[:3] for part in axes.get_legend_handles_labels()), fontsize=8, loc="upper left")
        axes.set_xticks([])
        axes.set_ylim(0, 0.55)
        style.dress(
            axes, x="runs by friction", y="friction" if speed == next(iter(results.runs)) else "", title=f"{speed} mph"
        )
    return sheet


def acceleration_figure(runs_at: Mapping[int, Sequence[LabelledRun]]) -> Figure:
    """Processed longitudinal acceleration of the paper's networks, runs linked as in its figures 5 to 8.

    Args:
        runs_at: Speed in mph → runs of the campaign.
    """
    sheet = style.figure(8.0, 1.7 * len(runs_at) + 0.3)
    rows = np.atleast_1d(sheet.subplots(len(runs_at), 1))
    colours = (palette.BLACK, palette.BLUE, palette.VERMILION, palette.ORANGE)
    for axes, (speed, runs) in zip(rows, runs_at.items(), strict=True):
        ends = np.cumsum([len(run.blocks) for run in runs]) * (BLOCKS[speed] / RATE)
        amplitudes = np.vstack([run.blocks[:, CHANNELS["longitudinal"]] for run in runs])
        seconds = np.arange(len(amplitudes)) * (BLOCKS[speed] / RATE)
        for wheelset, colour in enumerate(colours):
            axes.plot(seconds, amplitudes[:, wheelset], color=colour, linewidth=0.8, label=f"wheelset {wheelset + 1}")
        for begin, end, run in zip([0.0, *ends[:-1]], ends, runs, strict=True):
            axes.axvline(end, color=palette.GREY, linewidth=0.8, linestyle=":")
            axes.text((begin + end) / 2, 0.99, f"{run.friction:g}", transform=axes.get_xaxis_transform(), fontsize=8,
                      ha="center", va="top", color=palette.GREY)  # fmt: skip
        axes.set_xlim(0, ends[-1])
        axes.set_ylim(0, 1.25 * float(amplitudes.max()))
        last = speed == list(runs_at)[-1]
        style.dress(
            axes,
            x="time of the linked runs [s]" if last else "",
            y="|acc.| [m/s²]",
            title=f"Fig. {_ACCELERATIONS[speed]}: {speed} mph; grey: friction, Table 2",
        )
    sheet.legend(*rows[0].get_legend_handles_labels(), fontsize=8, ncols=4, loc="outside upper right")
    return sheet


def over_time(results: AxleBoxResults) -> Figure:
    """Last 20 % of each run, linked as in the paper: true labels, and labels that belong to other runs."""
    sheet = style.figure(8.0, 1.9 * len(results.runs))
    grid = np.atleast_2d(sheet.subplots(len(results.runs), 2, sharex="row", sharey=True))
    for pair, (speed, runs) in zip(grid, results.runs.items(), strict=True):
        for axes, fitted, labelled, title in (
            (pair[0], results.networks[speed], runs, f"Fig. {_ESTIMATES[speed]}: {speed} mph"),
            (pair[1], results.exchanged[speed], exchange_labels(runs), f"{speed} mph, labels of other runs"),
        ):
            _, late = parts_of(labelled, results.recipe)
            x, y = np.vstack([x for x, _ in late]), np.concatenate([y for _, y in late])
            seconds = np.arange(len(y)) * (BLOCKS[speed] / RATE)
            axes.plot(seconds, y, color="black", linewidth=2.5, label="label, Table 2")
            axes.plot(seconds, fitted(x), color=palette.ORANGE, linewidth=0.9, label="estimate")
            last = speed == list(results.runs)[-1]
            style.dress(
                axes, x="time of the linked parts [s]" if last else "", y="friction" if labelled is runs else "",
                title=title,
            )  # fmt: skip
    grid[0, 0].legend(fontsize=8, ncols=2, loc="upper right")
    grid[0, 0].set_ylim(0, 0.45)
    return sheet


def structure(network: Network) -> Figure:
    """Return the layers of a network of the paper and what each computes (figure 9)."""
    hidden, inputs = network.hidden_weights.shape
    sheet, axes = style.panels(8.0, 3.2)
    sheet.has_formulas = True
    columns = (
        (0.0, [f"$|\\ddot x_{{w{i}}}|$" for i in range(1, inputs + 1)], palette.BLUE),
        (2.0, [f"$g_{j}$" for j in range(1, hidden + 1)], palette.ORANGE),
        (4.0, [r"$\mu_{est}$"], palette.GREEN),
    )
    for (x, names, _), (x_next, names_next, _) in pairwise(columns):
        for y in _heights(names):
            for y_next in _heights(names_next):
                axes.plot([x, x_next], [y, y_next], color=palette.GREY, linewidth=0.5, zorder=1)
    for x, names, colour in columns:
        for y, name in zip(_heights(names), names, strict=True):
            axes.plot(x, y, "o", color="white", markeredgecolor=colour, markeredgewidth=2, markersize=24, zorder=2)
            axes.text(x, y, name, ha="center", va="center", fontsize=8, zorder=3)
    last = r"\frac{1}{1+e^{-w_2 g%s}}%s$" % ((" - b_2", "") if network.bias == "inside" else ("", " + b_2"))
    _note(axes, 0.0, f"{inputs} accelerations,\nscaled to [−1, 1]")
    _note(axes, 2.0, f"{hidden} hidden neurons\n$g = \\tanh(W_1 x + b_1)$")
    _note(axes, 4.0, f"friction\n$\\mu_{{est}} = {last}")
    axes.set_xlim(-1.0, 5.0)
    axes.set_ylim(-4.4, 3.2)
    axes.axis("off")
    return sheet


def _heights(names: Sequence[str]) -> list[float]:
    return [(len(names) - 1) / 2 - k for k in range(len(names))]


def _note(axes: Axes, x: float, words: str) -> None:
    axes.text(x, -3.3, words, ha="center", va="top", fontsize=9)
