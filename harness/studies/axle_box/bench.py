"""The ride as a family of the comparison of estimators, and slip acceleration against friction, equation (3)."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

import numpy as np
import pandas

from railgrip.base.arrays import generator
from railgrip.campaign.work import Work, call
from railgrip.estimation.judgement import error_figures
from railgrip.estimators.belief import Array, Matrix, Vector
from railgrip.estimators.learned.network import QUANTILE, Ensemble
from railgrip.report.statistics import bootstrap_interval
from railgrip.report.table import ReportTable, with_interval
from railgrip.studies.axle_box.evaluate import ScaledNetwork, TrainingRecipe, estimates_of
from railgrip.studies.axle_box.instrumented_car import LabelledRun, Pass, gather
from railgrip.studies.axle_box.training import Size, dry_or_not, general, passes

JUDGED: Final = ("other irregularities", "one surface for all")
"""Sets of runs outside of any training on which estimators are judged."""

ONE_SURFACE: Final = ("one surface for all", "design on one surface")
"""Sets of runs with one creep curve, so that friction is independent of its slope."""

RESAMPLES: Final = 4000
"""Bootstrap samples of runs of an interval."""

QUANTITIES: Final[Mapping[str, str]] = {"slip_acceleration": "ẍ − ω̇r", "slip_rate": "rate of total creepage"}
"""Field of `LabelledRun` → its name in the table."""


FrictionErrors = tuple[Array, Array]
"""Errors of friction over all estimates in a set of runs, and claimed deviations, NaN without a claim, shape (n,)."""


def bench_tables(size: Size, recipe: TrainingRecipe, work: Work) -> dict[str, ReportTable]:
    """Simulate and train; return the tables `family` and `slip_regression`."""
    sets = {name: part for name, part in passes(size).items() if name in ("campaign", "design", *JUDGED)}
    sets["design on one surface"] = tuple(replace(run, condition="wet") for run in sets["design"])
    found = iter(gather([run for part in sets.values() for run in part], work))
    runs = {name: [next(found) for _ in part] for name, part in sets.items()}
    speeds = sorted({run.group for run in runs["campaign"]})
    few = replace(recipe, starts=size.honest_starts)
    at = {speed: few.data([run for run in runs["campaign"] if run.group == speed]) for speed in speeds}
    tasks = [partial(few.fit, data, f"bench.{speed}") for speed, data in at.items()]
    trained: list[Any] = work.map(call, [partial(general, runs["design"], size.members), *tasks])
    (ensemble, mean), networks = trained[0], dict(zip(speeds, trained[1:], strict=True))
    rows: list[dict[str, Any]] = []
    rules = dry_or_not(sets)
    for name in JUDGED:
        errors = {
            "learned": _of_ensemble(ensemble, runs[name]),
            "paper_networks": _of_networks(recipe, networks, runs[name]),
            "dry_or_not": _of_constants([rules[name][run.name] for run in runs[name]], runs[name]),
            "constant": _of_constants([mean] * len(runs[name]), runs[name]),
        }
        rows += family_rows(f"axle box, {name}", errors)
    return {"family": family_table(rows), "slip_regression": regression_table(sets, runs)}


def _of_ensemble(ensemble: Ensemble, runs: Sequence[LabelledRun]) -> FrictionErrors:
    friction, lower, upper, labels, _ = estimates_of(ensemble, runs)
    # Ends are limited to 0 and 1, so the longer half is the complete one.
    half = np.maximum(upper - friction, friction - lower)
    return friction - labels, half / QUANTILE


def _of_networks(
    recipe: TrainingRecipe, networks: Mapping[int, Sequence[ScaledNetwork]], runs: Sequence[LabelledRun]
) -> FrictionErrors:
    errors = [
        network(blocks) - labels
        for run in runs
        for blocks, labels in recipe.data([run])
        for network in networks[run.group]
    ]
    return _without_claim(np.concatenate(errors))


def _of_constants(estimates: Sequence[float], runs: Sequence[LabelledRun]) -> FrictionErrors:
    return _without_claim(np.array([each - run.friction for each, run in zip(estimates, runs, strict=True)]))


def _without_claim(error: Array) -> FrictionErrors:
    return error, np.full(error.shape, np.nan)


def family_rows(family: str, errors: Mapping[str, FrictionErrors]) -> list[dict[str, Any]]:
    """Return RMSE, bias, coverage of the 95 % interval, NEES and skill over `constant` of each estimator."""
    rows: list[dict[str, Any]] = [
        {"family": family, "estimator": name, **error_figures(*each)} for name, each in errors.items()
    ]
    reference = rows[list(errors).index("constant")]["RMSE"]
    return [
        {name: None if name == "coverage" and np.isnan(row["NEES"]) else value for name, value in row.items()}
        | {"skill over constant": None if row["estimator"] == "constant" else 1 - (row["RMSE"] / reference) ** 2}
        for row in rows
    ]


def family_table(rows: Sequence[dict[str, Any]]) -> ReportTable:
    """Return the rows of all families; cells without a value are empty."""
    forms = dict(zip(("RMSE", "bias", "coverage", "NEES"), ("{:.4f}", "{:+.4f}", "{:.2f}", "{:.2g}"), strict=True))
    frame = pandas.DataFrame(rows)
    return ReportTable.of_frame(frame, forms | {"skill over constant": "{:+.2f}"}, ("family", "estimator"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Elasticity:
    """Exponent of friction in a power law of a quantity, with a bootstrap interval of 95 % over runs.

    Attributes:
        value: The exponent: −0.1 is 7 % more of the quantity at half the friction.
        interval: Its interval; None with too few runs.
        explained: Share of the variance that the other variables leave which friction explains.
    """

    value: float
    interval: tuple[float, float] | None
    explained: float


def elasticity(quantity: Vector, friction: Vector, others: Matrix) -> Elasticity:
    """Return the exponent β by least squares in log(quantity) = β log(friction) + others·γ + constant.

    Args:
        quantity, friction: Of each run, positive, shape (n,).
        others: Other variables, shape (n, p).
    """
    y, x = np.log(quantity), np.column_stack([np.log(friction), others, np.ones(len(friction))])
    interval = bootstrap_interval(
        np.column_stack([y, x]),
        lambda draws: np.array([_slope(rows[:, 0], rows[:, 1:]) for rows in draws]),
        resamples=RESAMPLES,
        generator=generator(0, "axle_box.elasticity"),
    )
    with_friction, without = (float(np.sum((y - part @ np.linalg.lstsq(part, y)[0]) ** 2)) for part in (x, x[:, 1:]))
    return Elasticity(value=_slope(y, x), interval=interval, explained=1 - with_friction / without)


def _slope(y: Vector, x: Matrix) -> float:
    return float(np.linalg.lstsq(x, y)[0][0])


def regression_table(sets: Mapping[str, Sequence[Pass]], runs: Mapping[str, Sequence[LabelledRun]]) -> ReportTable:
    """Return the exponent of friction in both quantities, on films and on one surface, with speed and track held."""
    films = [name for name in sets if name not in ONE_SURFACE]
    groups = {"each film its own creep curve": films, "one creep curve for all": ONE_SURFACE}
    rows: list[dict[str, Any]] = []
    for title, names in groups.items():
        part = [run for name in names for run in runs[name]]
        tracks = [each.track for name in names for each in sets[name]]
        speed = np.log([run.speed for run in part])
        held = [speed, speed**2, *(np.array([track == one for track in tracks]) for one in sorted(set(tracks))[1:])]
        slopes = np.log([math.nan if run.slope is None else run.slope for run in part])
        for field, quantity in QUANTITIES.items():
            values = np.array([getattr(run, field) for run in part])
            friction = np.array([run.friction for run in part])
            for also, others in (("", held), (", slope of the creep curve", [*held, slopes])):
                found = elasticity(values, friction, np.column_stack(others))
                words = with_interval(found.value, found.interval, "{:+.2f}")
                rows.append(
                    {
                        "runs": f"{title}, {len(part)} runs",
                        "quantity": quantity,
                        "held": f"speed, track{also}",
                        "exponent of friction": words,
                        "variance explained": f"{100 * found.explained:.0f} %",
                    }
                )
    return ReportTable(rows, left=("runs", "quantity", "held"))
