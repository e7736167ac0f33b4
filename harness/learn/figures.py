"""Figures of a study."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from harness.learn.evaluate import Fitted, Recipe
from harness.learn.gather import Run, spectral_features
from harness.learn.study import PUBLISHED, Study, over_speeds
from harness.verdict.style import BLUE, GREEN, GREY, ORANGE, VERMILION, dress, figure, save

Array = NDArray[np.float64]


def draw(made: Study, folder: Path) -> list[Path]:
    """Draw every figure of a study into a folder."""
    return [
        save(errors(made), folder / "errors.png"),
        save(campaign(made), folder / "campaign.png"),
        save(over_time(made), folder / "within_runs.png"),
    ]


def errors(made: Study) -> Figure:
    """Mean absolute error of each way of judging, beside always saying the mean."""
    published = float(np.mean([PUBLISHED[s][1] for s in made.runs]))
    rows: list[tuple[str, float, float | None, str]] = [("paper, its split", published, None, GREY)]
    for name, row, colour in (
        *((f"4-6-1: {k}", v, BLUE) for k, v in made.split.items()),
        *((f"4-6-1: {k}", v, VERMILION) for k, v in made.honest.items()),
        *((f"all speeds: {k}", v, GREEN) for k, v in made.general.items()),
    ):
        mean = over_speeds(row)
        rows.append((name, mean.mae, mean.mae_of_mean, colour))
    sheet = figure(8.0, 0.33 * len(rows) + 1.0)
    axes = sheet.subplots()
    for k, (_, mae, of_mean, colour) in enumerate(rows):
        axes.barh(-k, mae, color=colour, height=0.65)
        if of_mean is not None:
            axes.plot([of_mean, of_mean], [-k - 0.42, -k + 0.42], color="black", linewidth=1.6)
    axes.set_yticks([-k for k in range(len(rows))], [row[0] for row in rows], fontsize=8)
    dress(axes, x="mean absolute error of friction, mean over speeds; black: always the mean label")
    axes.grid(visible=False, axis="y")
    return sheet


def campaign(made: Study) -> Figure:
    """The estimator for all speeds on each run of the campaign: estimates with interval over the label."""
    sheet = figure(8.0, 3.2)
    for axes, (speed, runs) in zip(
        np.atleast_1d(sheet.subplots(1, len(made.runs), sharey=True)), made.runs.items(), strict=True
    ):
        for k, run in enumerate(sorted(runs, key=lambda r: r.friction)):
            said = made.ensemble(spectral_features(run))
            place = k + np.linspace(-0.3, 0.3, len(said.friction))
            axes.vlines(place, said.lower, said.upper, color=GREEN, alpha=0.3, linewidth=1)
            axes.plot(place, said.friction, ".", color=GREEN, markersize=3)
            axes.plot([k - 0.4, k + 0.4], [run.friction] * 2, color="black", linewidth=1.6)
        axes.set_xticks([])
        dress(axes, x="runs by friction", y="friction" if speed == next(iter(made.runs)) else "", title=f"{speed} mph")
    return sheet


def over_time(made: Study) -> Figure:
    """Last 20 % of each run, linked as in the paper: true labels, and labels that belong to other runs."""
    sheet = figure(8.0, 1.9 * len(made.runs))
    recipe = Recipe(starts=3)
    grid = np.atleast_2d(sheet.subplots(len(made.runs), 2, sharey=True))
    for pair, (speed, runs) in zip(grid, made.runs.items(), strict=True):
        for axes, shift, title in ((pair[0], 0, "true labels"), (pair[1], len(runs) // 2, "labels of other runs")):
            given = [runs[(k + shift) % len(runs)].friction for k in range(len(runs))]
            truth, said = _late(runs, given, recipe)
            axes.plot(said, color=ORANGE, linewidth=1)
            axes.plot(truth, color="black", linewidth=1.2)
            dress(axes, y="friction" if shift == 0 else "", title=f"{speed} mph, {title}")
            axes.set_xticks([])
    return sheet


def _late(runs: Sequence[Run], given: list[float], recipe: Recipe) -> tuple[Array, Array]:
    blocks = [recipe.blocks(run) for run in runs]
    cuts = [int(0.8 * len(b)) for b in blocks]
    early = [(b[:c], np.full(c, y)) for b, c, y in zip(blocks, cuts, given, strict=True)]
    x, y = np.vstack([d[0] for d in early]), np.concatenate([d[1] for d in early])
    tried: list[Fitted] = recipe.fit(early, "figure")
    best = min(tried, key=lambda one: float(np.abs(one(x) - y).mean()))
    truth = np.concatenate([np.full(len(b) - c, y) for b, c, y in zip(blocks, cuts, given, strict=True)])
    return truth, best(np.vstack([b[c:] for b, c in zip(blocks, cuts, strict=True)]))
