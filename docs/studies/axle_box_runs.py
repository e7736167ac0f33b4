"""Simulated rides over a treated rail, scores of the estimators trained on them, and their figures.

Every function takes a key of `SIZES`, and shares its simulations and trained estimators with the others.
"""

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from functools import cache, partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from railgrip.base.arrays import generator
from railgrip.base.records import make_folder
from railgrip.campaign.work import call, work
from railgrip.estimation.axle_box.evaluate import (
    Score,
    TrainingRecipe,
    best_of,
    estimates_of,
    exchange_labels,
    judge,
    parts_of,
    within_runs,
    without_each,
)
from railgrip.estimation.axle_box.instrumented_car import (
    CHANNELS,
    MPH,
    RATE,
    SPECTRAL,
    LabelledRun,
    run_of,
    spectral_features,
)
from railgrip.estimation.axle_box.training import (
    FULL,
    QUICK,
    SPEEDS,
    campaign,
    dry_or_not,
    estimators_of,
    export,
    general,
    judgements,
    passes,
)
from railgrip.estimation.judgement import error_figures
from railgrip.estimators.belief import Array, Matrix, Vector
from railgrip.estimators.learned.network import QUANTILE, Ensemble
from railgrip.estimators.learned.preprocessing import BLOCKS, COMBINATIONS
from railgrip.report import palette, style
from railgrip.report.baseline import Finding
from railgrip.report.statistics import bootstrap_interval

SIZES = {"full": FULL, "quick": QUICK}
JUDGED = ("other irregularities", "one surface for all")
"""Sets of runs outside of any training on which families of estimators are judged."""
ONE_SURFACE = ("one surface for all", "design on one surface")
"""Sets of runs with one creep curve, so that friction is independent of its slope."""
QUANTITIES = {"slip_acceleration": "ẍ − ω̇r", "slip_rate": "rate of total creepage"}
"""Field of `LabelledRun` → its name in the table."""
_RESAMPLES = 4000
"""Bootstrap samples of runs of an interval."""


def _map(function: Callable[..., Any], cases: Sequence[Any]) -> list[Any]:
    with work(Path(__file__)) as job:
        return job.map(function, cases)


@cache
def _plan(size: str) -> dict[str, tuple[Any, ...]]:
    plan = passes(SIZES[size])
    return plan | {ONE_SURFACE[1]: tuple(replace(run, condition="wet") for run in plan["design"])}


@cache
def runs_of(size: str, name: str) -> list[LabelledRun]:
    """Simulate the runs of a set."""
    return _map(run_of, _plan(size)[name])


@cache
def _general(size: str) -> tuple[Ensemble, float]:
    return _map(call, [partial(general, runs_of(size, "design"), SIZES[size].members)])[0]


def _by_speed(size: str, name: str) -> dict[int, list[LabelledRun]]:
    return {mph: [run for run in runs_of(size, name) if run.group == mph] for mph in SIZES[size].speeds}


def _few(size: str) -> TrainingRecipe:
    return TrainingRecipe(starts=SIZES[size].honest_starts)


def score_rows(size: str) -> list[dict[str, Any]]:
    """Train and judge; return a row of each table of `judgements`, and of `general`, at each speed."""
    (ensemble, mean), rules = _general(size), dry_or_not(_plan(size))
    sets = {name: _by_speed(size, name) for name in _plan(size) if "design" not in name}
    tasks: dict[tuple[str, str, int], Callable[[], Any]] = {}
    for mph, home in sets["campaign"].items():
        away = {name: runs[mph] for name, runs in sets.items() if name != "campaign"}
        of_speed = judgements(home, away, TrainingRecipe(starts=SIZES[size].starts), _few(size))
        tasks |= {(table, row, mph): task for (table, row), task in of_speed.items()}
    scores: dict[tuple[str, str, int], Score] = {}
    for (table, row, mph), found in zip(tasks, _map(call, list(tasks.values())), strict=True):
        of_rows = {row: found} if isinstance(found, Score) else found
        scores |= {(table, name, mph): score for name, score in of_rows.items()}
    for name, runs_at in sets.items():
        for mph, part in runs_at.items():
            scores["general", name, mph] = judge(ensemble, mean, part, [rules[name][run.name] for run in part])
    return [{"table": table, "row": row, "mph": mph, **asdict(score)} for (table, row, mph), score in scores.items()]


def run_rows(size: str) -> list[dict[str, Any]]:
    """Return friction, slip and amplitude of each run; `level` is the mean of the blocks of the paper's chain."""
    fields = ("speed", "friction", "slope", "slip_rate", "slip_acceleration")
    return [
        {"set": name, "mph": run.group, "track": each.track, **{field: getattr(run, field) for field in fields},
         "blocks": len(run.blocks), "level": float(run.blocks[:, CHANNELS["longitudinal"]].mean())}
        for name, part in _plan(size).items()
        for each, run in zip(part, runs_of(size, name), strict=True)
    ]  # fmt: skip


def family_rows(size: str) -> list[dict[str, Any]]:
    """Return figures of estimators of friction, and their skill over the mean label, on runs outside of training."""
    (ensemble, mean), rules, few = _general(size), dry_or_not(_plan(size)), _few(size)
    home = _by_speed(size, "campaign")
    tasks = [partial(few.fit, few.data(part), f"bench.{mph}") for mph, part in home.items()]
    networks = dict(zip(home, _map(call, tasks), strict=True))
    rows: list[dict[str, Any]] = []
    for name in JUDGED:
        runs = runs_of(size, name)
        friction, lower, upper, labels, _ = estimates_of(ensemble, runs)
        own = np.array([run.friction for run in runs])
        of_papers = [
            network(blocks) - label
            for run in runs
            for blocks, label in few.data([run])
            for network in networks[run.group]
        ]
        errors = {
            # Ends are limited to 0 and 1, so the longer half is the complete one.
            "learned": (friction - labels, np.maximum(upper - friction, friction - lower) / QUANTILE),
            "paper_networks": (np.concatenate(of_papers), None),
            "dry_or_not": (np.array([rules[name][run.name] for run in runs]) - own, None),
            "constant": (mean - own, None),
        }
        rows += [{"runs": name, **row} for row in figures_of(errors)]
    return rows


def figures_of(errors: Mapping[str, tuple[Array, Array | None]]) -> list[dict[str, Any]]:
    """Return RMSE, bias, coverage of the 95 % interval, NEES, and skill over `constant` of each estimator.

    Args:
        errors: Estimator → errors of friction and claimed deviations, None without a claim: their figures are NaN.
    """
    claims = {name: np.full(error.shape, np.nan) if claim is None else claim for name, (error, claim) in errors.items()}
    found = pd.DataFrame({name: error_figures(error, claims[name]) for name, (error, _) in errors.items()}).T
    found["coverage"] = found["coverage"].where(found["NEES"].notna())
    skill = 1 - (found["RMSE"] / found["RMSE"]["constant"]) ** 2
    found["skill over constant"] = skill.where(found.index != "constant")
    return found.reset_index(names="estimator").to_dict("records")


def elasticity(quantity: Vector, friction: Vector, others: Matrix) -> dict[str, float]:
    """Return the exponent β by least squares in log(quantity) = β log(friction) + others·γ + constant.

    An exponent of −0.1 is 7 % more of the quantity at half the friction. `low` and `high` are the ends of a bootstrap
    interval of 95 % over runs, NaN with too few; `explained` is the share of the variance that the other variables
    leave which friction explains.

    Args:
        quantity, friction: Of each run, positive, shape (n,).
        others: Other variables, shape (n, p).
    """
    y, x = np.log(quantity), np.column_stack([np.log(friction), others, np.ones(len(friction))])
    interval = bootstrap_interval(
        np.column_stack([y, x]),
        lambda draws: np.array([_slope(rows[:, 0], rows[:, 1:]) for rows in draws]),
        resamples=_RESAMPLES,
        generator=generator(0, "axle_box.elasticity"),
    )
    with_friction, without = (float(np.sum((y - part @ np.linalg.lstsq(part, y)[0]) ** 2)) for part in (x, x[:, 1:]))
    low, high = interval or (math.nan, math.nan)
    return {"exponent": _slope(y, x), "low": low, "high": high, "explained": 1 - with_friction / without}


def _slope(y: Vector, x: Matrix) -> float:
    return float(np.linalg.lstsq(x, y)[0][0])


def exponent_rows(size: str) -> list[dict[str, Any]]:
    """Return exponents of friction in slip, on films and on one surface, with speed and track held."""
    films = [name for name in ("campaign", "design", *JUDGED) if name not in ONE_SURFACE]
    sets, rows = pd.DataFrame(run_rows(size)).set_index("set"), list[dict[str, Any]]()
    for title, names in (("each film its own creep curve", films), ("one creep curve for all", [*ONE_SURFACE])):
        runs = sets.loc[names]
        speed, slope = np.log(runs["speed"]), np.log(runs["slope"].astype(float))
        held = np.column_stack([speed, speed**2, pd.get_dummies(runs["track"], drop_first=True)])
        for field, quantity in QUANTITIES.items():
            for also, others in (("", held), (", slope of the creep curve", np.column_stack([held, slope]))):
                case = {"runs": f"{title}, {len(runs)} runs", "quantity": quantity, "held": f"speed, track{also}"}
                rows.append(case | elasticity(runs[field].to_numpy(), runs["friction"].to_numpy(), others))
    return rows


_ACCELERATIONS: Mapping[int, int] = dict(zip(SPEEDS, range(5, 9), strict=True))
_ESTIMATES: Mapping[int, int] = dict(zip(SPEEDS, range(10, 14), strict=True))
"""Numbers of the paper's figures by speed."""


def draw(size: str) -> None:
    """Draw figures 5 to 8 and 10 to 13 of the paper into the working directory."""
    home, few = _by_speed(size, "campaign"), _few(size)
    labels = {(mph, name): runs for mph, own in home.items()
              for name, runs in (("own", own), ("exchanged", exchange_labels(own)))}  # fmt: skip
    tasks = [partial(best_of, runs, few) for runs in labels.values()]
    networks = dict(zip(labels, _map(call, tasks), strict=True))
    sheets = {_ACCELERATIONS[mph]: accelerations(mph, runs) for mph, runs in home.items()}
    for number, sheet in (sheets | {10: estimates(labels, networks, few)}).items():
        style.reduce_colours(style.save(sheet, Path(f"axle_box_fig{number}.png")))


def accelerations(mph: int, runs: Sequence[LabelledRun]) -> Figure:
    """Draw the processed longitudinal acceleration of runs of the campaign, linked as in figures 5 to 8."""
    sheet, axes = style.panels(8.0, 2.0)
    ends = np.cumsum([len(run.blocks) for run in runs]) * (BLOCKS[mph] / RATE)
    amplitudes = np.vstack([run.blocks[:, CHANNELS["longitudinal"]] for run in runs])
    seconds = np.arange(len(amplitudes)) * (BLOCKS[mph] / RATE)
    colours = (palette.BLACK, palette.BLUE, palette.VERMILION, palette.ORANGE)
    for wheelset, colour in enumerate(colours):
        axes.plot(seconds, amplitudes[:, wheelset], color=colour, linewidth=0.8, label=f"wheelset {wheelset + 1}")
    for begin, end, run in zip([0.0, *ends[:-1]], ends, runs, strict=True):
        axes.axvline(end, color=palette.GREY, linewidth=0.8, linestyle=":")
        axes.text((begin + end) / 2, 0.99, f"{run.friction:g}", transform=axes.get_xaxis_transform(), fontsize=8,
                  ha="center", va="top", color=palette.GREY)  # fmt: skip
    title = f"Fig. {_ACCELERATIONS[mph]}: {mph} mph; grey: friction, Table 2"
    limits = {"xlim": (0, ends[-1]), "ylim": (0, 1.25 * float(amplitudes.max()))}
    style.dress(axes, x="time of the linked runs [s]", y="|acc.| [m/s²]", title=title, **limits)
    sheet.legend(*axes.get_legend_handles_labels(), fontsize=8, ncols=4, loc="outside upper right")
    return sheet


def estimates(labels: Mapping[tuple[int, str], Sequence[LabelledRun]], networks: Mapping[tuple[int, str], Any],
              recipe: TrainingRecipe) -> Figure:  # fmt: skip
    """Draw the last 20 % of each run, linked as in the paper: own labels, and labels of other runs."""
    speeds = sorted({mph for mph, _ in labels})
    sheet = style.figure(8.0, 1.9 * len(speeds))
    grid = np.atleast_2d(sheet.subplots(len(speeds), 2, sharex="row", sharey=True))
    for axes, ((mph, name), runs) in zip(grid.flat, labels.items(), strict=True):
        _, late = parts_of(runs, recipe)
        x, y = np.vstack([x for x, _ in late]), np.concatenate([y for _, y in late])
        seconds = np.arange(len(y)) * (BLOCKS[mph] / RATE)
        axes.plot(seconds, y, color="black", linewidth=2.5, label="label, Table 2")
        axes.plot(seconds, networks[mph, name](x), color=palette.ORANGE, linewidth=0.9, label="estimate")
        title = f"Fig. {_ESTIMATES[mph]}: {mph} mph" if name == "own" else f"{mph} mph, labels of other runs"
        below = "time of the linked parts [s]" if mph == speeds[-1] else ""
        style.dress(axes, x=below, y="friction" if name == "own" else "", title=title)
    grid[0, 0].legend(fontsize=8, ncols=2, loc="upper right")
    grid[0, 0].set_ylim(0, 0.45)
    return sheet


def structure(inputs: int, hidden: int) -> Figure:
    """Draw the layers of a network of the paper and what each computes (figure 9)."""
    sheet, axes = style.panels(8.0, 3.2, label="Four inputs, six hidden neurons, one output")
    sheet.has_formulas = True
    columns = (
        (0.0, [f"$|\\ddot x_{{w{i}}}|$" for i in range(1, inputs + 1)], palette.BLUE,
         f"{inputs} accelerations,\nscaled to [−1, 1]"),
        (2.0, [f"$g_{j}$" for j in range(1, hidden + 1)], palette.ORANGE,
         f"{hidden} hidden neurons\n$g = \\tanh(W_1 x + b_1)$"),
        (4.0, [r"$\mu_{est}$"], palette.GREEN, "friction\n" r"$\mu_{est} = \frac{1}{1+e^{-w_2 g - b_2}}$"),
    )  # fmt: skip
    heights = [[(len(names) - 1) / 2 - k for k in range(len(names))] for _, names, *_ in columns]
    for (left, right), (x, x_next) in zip(pairwise(heights), ((0.0, 2.0), (2.0, 4.0)), strict=True):
        for y in left:
            for y_next in right:
                axes.plot([x, x_next], [y, y_next], color=palette.GREY, linewidth=0.5, zorder=1)
    for (x, names, colour, note), ys in zip(columns, heights, strict=True):
        for y, name in zip(ys, names, strict=True):
            axes.plot(x, y, "o", color="white", markeredgecolor=colour, markeredgewidth=2, markersize=24, zorder=2)
            axes.text(x, y, name, ha="center", va="center", fontsize=8, zorder=3)
        axes.text(x, -3.3, note, ha="center", va="top", fontsize=9)
    axes.set(xlim=(-1.0, 5.0), ylim=(-4.4, 3.2))
    axes.axis("off")
    return sheet


_TRAINED = 0.5
"""Relative tolerance of errors of networks, because rounding may lead training to another minimum; a changed plant,
filter or split changes them by more."""
_LEVEL = 1e-3
"""Relative tolerance of means over signals, without training."""


def headlines() -> list[Finding]:
    """Return errors of the paper's networks in short runs at 60 mph, and levels and features of their training data."""
    recipe = TrainingRecipe(starts=3)
    runs = _map(run_of, [each for each in campaign(length=200.0) if each.speed == 60 * MPH])
    training = {
        "bias inside": partial(within_runs, runs, recipe),
        "bias outside": partial(within_runs, runs, replace(recipe, bias="outside")),
        "labels exchanged": partial(within_runs, exchange_labels(runs), recipe),
        "a run left out": partial(without_each, runs, replace(recipe, starts=1)),
    }
    scores = dict(zip(training, _map(call, list(training.values())), strict=True))
    findings = [
        Finding(f"learn 60 mph, {name}: MAE", score.mae, "1", _TRAINED * score.mae) for name, score in scores.items()
    ]
    sets = passes(FULL)
    reports = dry_or_not(sets)["campaign"]
    levels = {
        "learn 60 mph, always the mean: MAE": (scores["bias inside"].mae_of_mean, "1"),
        "learn, dry or not: MAE": (float(np.mean([abs(p.friction - reports[p.name]) for p in sets["campaign"]])), "1"),
    }
    for motion in COMBINATIONS["longitudinal, lateral, yaw"]:
        level = float(np.mean([run.blocks[:, CHANNELS[motion]].mean() for run in runs]))
        levels[f"learn 60 mph, {motion}: mean of blocks"] = level, "m/s2"
    findings += [Finding(name, level, unit, _LEVEL * level) for name, (level, unit) in levels.items()]
    features = np.mean([spectral_features(run)[-1] for run in runs], axis=0)
    for name in ("lateral over yaw leading, 2 Hz", "quadrature leading, 4 Hz"):
        value = float(features[SPECTRAL.names.index(name)])
        findings.append(Finding(f"learn 60 mph, {name}", value, "1", _LEVEL))
    return findings


if __name__ == "__main__":  # `make learn`, for `railgrip ride`
    size = "quick" if "--quick" in sys.argv else "full"
    folder = Path("build/axle_box") / ("quick" if size == "quick" else "")
    make_folder(folder)
    tasks = [partial(best_of, runs, _few(size)) for runs in _by_speed(size, "campaign").values()]
    networks = dict(zip(SIZES[size].speeds, _map(call, tasks), strict=True))
    export(estimators_of(_general(size)[0], networks, _few(size)), folder)
