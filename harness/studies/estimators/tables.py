"""Tables of the errors of estimators: leaderboard, claims, families, and other targets."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final, Literal

import numpy as np

from railgrip.estimators.belief import Matrix
from railgrip.report.statistics import median_interval
from railgrip.report.table import ReportTable, share
from railgrip.studies.estimators.judge import CONSTANT, FORCE_BALANCE, CaseErrors
from railgrip.studies.estimators.recordings import FAMILIES, RecordingCase, family_of

Measure = Literal["rmse", "coverage"]

RESAMPLES: Final = 2000
RESAMPLING_SEED: Final = 8

Results = Mapping[str, Sequence[CaseErrors]]
"""Estimator → errors by case, in the same order of cases."""


def leaderboard(results: Results) -> ReportTable:
    """Return the errors of adhesion of every estimator, the smallest median first.

    Skill is 1 minus the mean squared error over that of the reference, over all cases.
    """
    rows: list[dict[str, Any]] = []
    for name, cases in results.items():
        values = [one.rmse["adhesion"] for one in cases if not one.diverged]
        interval = median_interval(values) or (math.nan, math.nan)
        rows.append(
            {
                "estimator": name,
                "cases": len(cases),
                "median RMSE": float(np.median(values)) if values else math.nan,
                "from": interval[0],
                "to": interval[1],
                "bias": _middle(cases, "bias"),
                "delay": _middle(cases, "delay"),
                "after a step": _middle(cases, "step_delay"),
                "over constant": skill(cases, results.get(CONSTANT)),
                "over force balance": skill(cases, results.get(FORCE_BALANCE)),
                "95 %": skill_interval(cases, results.get(FORCE_BALANCE)),
                "diverged": sum(one.diverged for one in cases),
                "step": _middle(cases, "microseconds"),
            }
        )
    rows.sort(key=lambda row: (math.isnan(row["median RMSE"]), row["median RMSE"]))
    forms = dict.fromkeys(("median RMSE", "from", "to"), "{:.4f}") | {"bias": "{:+.4f}"}
    forms |= dict.fromkeys(("delay", "after a step"), "{:.2f} s")
    forms |= dict.fromkeys(("over constant", "over force balance"), "{:.2f}") | {"step": "{:.0f} µs"}
    return ReportTable(rows, forms, title="Adhesion")


def consistency(results: Results) -> ReportTable:
    """Return coverage, width, NEES and NIS with quantiles over the cases, of estimators that claim a deviation."""
    rows: list[dict[str, Any]] = []
    for name, cases in results.items():
        nees = np.array([one.nees for one in cases])
        if np.isnan(nees).all():
            continue
        quantiles = np.nanquantile(nees, (0.1, 0.5, 0.9))
        rows.append(
            {
                "estimator": name,
                "coverage": float(np.nanmean([one.coverage["adhesion"] for one in cases])),
                "width": _middle(cases, "width"),
                **dict(zip(("NEES 10 %", "NEES 50 %", "NEES 90 %"), map(float, quantiles), strict=True)),
                "NIS": _middle(cases, "nis"),
                "lost": float(np.nanmean([one.lost for one in cases])),
                "admitted": _middle(cases, "admitted"),
            }
        )
    forms = {"coverage": "{:.2f}", "width": "{:.4f}", "NIS": "{:.2g}", "lost": share, "admitted": share}
    return ReportTable(rows, forms | dict.fromkeys(("NEES 10 %", "NEES 50 %", "NEES 90 %"), "{:.2g}"), title="Claims")


def others(results: Results) -> ReportTable:
    """Return errors and coverage of pad friction and speed, and the skill of pad friction over the constant."""
    rows: list[dict[str, Any]] = []
    for name, cases in results.items():
        row: dict[str, Any] = {"estimator": name}
        for target, title in (("pad_friction", "pad friction"), ("speed", "speed")):
            errors = np.array([one.rmse[target] for one in cases])
            claims = np.array([one.coverage[target] for one in cases])
            row[f"{title} RMSE"] = math.nan if np.isnan(errors).all() else float(np.nanmedian(errors))
            row[f"{title} coverage"] = math.nan if np.isnan(claims).all() else float(np.nanmean(claims))
        row["pads over constant"] = skill(cases, results.get(CONSTANT), "pad_friction")
        rows.append(row)
    forms = {"pad friction RMSE": "{:.4f}", "speed RMSE": "{:.3f} m/s"}
    shares = ("pad friction coverage", "speed coverage", "pads over constant")
    return ReportTable(rows, forms | dict.fromkeys(shares, "{:.2f}"))


def by_family(results: Results, design: Sequence[RecordingCase], measure: Measure = "rmse") -> ReportTable:
    """Return the median RMSE of adhesion, or its mean coverage, in each family of cases."""
    families = [(field, value) for field in FAMILIES for value in sorted({family_of(case, field) for case in design})]
    rows: list[dict[str, Any]] = []
    for name, cases in results.items():
        values = np.array([getattr(one, measure)["adhesion"] for one in cases])
        if measure == "coverage" and np.isnan(values).all():
            continue
        row: dict[str, Any] = {"estimator": name}
        for field, value in families:
            inside = values[[family_of(case, field) == value for case in design]]
            middle = np.nanmedian if measure == "rmse" else np.nanmean
            row[value] = math.nan if np.isnan(inside).all() else float(middle(inside))
        rows.append(row)
    form, title = ("{:.4f}", "Median RMSE") if measure == "rmse" else ("{:.2f}", "Coverage")
    return ReportTable(rows, dict.fromkeys((value for _, value in families), form), title=f"{title} by family")


def skill(cases: Sequence[CaseErrors], reference: Sequence[CaseErrors] | None, target: str = "adhesion") -> float:
    """Return 1 − mean squared error over that of a reference in the same cases; NaN without one."""
    squares = _squares(cases, reference, target)
    return 1.0 - float(np.divide(*squares.sum(axis=0))) if squares.size else math.nan


def skill_interval(cases: Sequence[CaseErrors], reference: Sequence[CaseErrors] | None) -> str:
    """Return the percentile bootstrap interval of the skill for adhesion over the cases; empty with fewer than two."""
    squares = _squares(cases, reference, "adhesion")
    if len(squares) < 2:
        return ""
    draws = np.random.default_rng(RESAMPLING_SEED).integers(len(squares), size=(RESAMPLES, len(squares)))
    sums = squares[draws].sum(axis=1)
    low, high = np.quantile(1.0 - sums[:, 0] / sums[:, 1], (0.025, 0.975))
    return f"{low:.2f} to {high:.2f}"


def _squares(cases: Sequence[CaseErrors], reference: Sequence[CaseErrors] | None, target: str) -> Matrix:
    """Return the mean squared errors of an estimator and of a reference in the cases that have both, shape (k, 2)."""
    pairs = [(one.rmse[target], other.rmse[target]) for one, other in zip(cases, reference or (), strict=False)]
    squares = np.array(pairs, dtype=np.float64).reshape(-1, 2) ** 2
    return squares[np.isfinite(squares).all(axis=1)]


def _middle(cases: Sequence[CaseErrors], field: str) -> float:
    values = np.array([getattr(one, field) for one in cases], dtype=np.float64)
    return math.nan if np.isnan(values).all() else float(np.nanmedian(values))
