"""Tables of the errors of estimators: leaderboard, claims, families, and other targets."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final, Literal

import numpy as np

from railgrip.estimators.belief import Matrix
from railgrip.report.statistics import bootstrap_interval, median_interval
from railgrip.report.table import ReportTable, share
from railgrip.studies.estimators.judge import CONSTANT, FORCE_BALANCE, CaseBound, CaseErrors
from railgrip.studies.estimators.recordings import FAMILIES, RecordingCase, family_of
from railgrip.studies.estimators.replay import LAGS

Measure = Literal["rmse", "coverage"]

REFERENCES: Final = (CONSTANT, FORCE_BALANCE)

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


def available(results: Results) -> ReportTable:
    """Return the errors of the available adhesion of every estimator that knows it somewhere.

    Errors are root mean squares over the cases of those where an estimator knows it; the references are judged there
    too.
    """
    rows: list[dict[str, Any]] = []
    for name, cases in results.items():
        errors = [one.available for one in cases]
        squares = np.array([(one.rmse, one.recent, one.constant) for one in errors]) ** 2
        squares = squares[np.isfinite(squares).all(axis=1)]
        if not squares.size:
            continue
        own, recent, constant = np.sqrt(np.mean(squares, axis=0)).tolist()
        rows.append(
            {
                "estimator": name,
                "known": float(np.nanmean([one.known for one in errors])),
                "RMSE": own,
                "bias": float(np.nanmean([one.bias for one in errors])),
                "coverage": float(np.nanmean([one.coverage for one in errors])),
                "RMSE of the last second": recent,
                "RMSE of the constant": constant,
                "over the last second": _skill(squares[:, :2]),
                "95 %": _interval(squares[:, :2]),
            }
        )
    forms = {"known": share, "bias": "{:+.4f}", "coverage": "{:.2f}", "over the last second": "{:.2f}"}
    errors = ("RMSE", "RMSE of the last second", "RMSE of the constant")
    return ReportTable(rows, forms | dict.fromkeys(errors, "{:.4f}"), title="Available adhesion")


def by_family(results: Results, design: Sequence[RecordingCase], measure: Measure = "rmse") -> ReportTable:
    """Return the median RMSE of adhesion, or its mean coverage, of each estimator in each family of cases."""
    middle = np.nanmedian if measure == "rmse" else np.nanmean
    values = {name: np.array([getattr(one, measure)["adhesion"] for one in cases]) for name, cases in results.items()}
    claiming = {name: errors for name, errors in values.items() if not np.isnan(errors).all()}
    rows: list[dict[str, Any]] = []
    for field in FAMILIES:
        families = [family_of(case, field) for case in design]
        for family in sorted(set(families)):
            inside = [one == family for one in families]
            row: dict[str, Any] = {"family": family, "cases": sum(inside)}
            for name, errors in claiming.items():
                row[name] = math.nan if np.isnan(errors[inside]).all() else float(middle(errors[inside]))
            rows.append(row)
    form, title = ("{:.4f}", "Median RMSE") if measure == "rmse" else ("{:.2f}", "Coverage")
    return ReportTable(rows, dict.fromkeys(claiming, form), ("family",), title=f"{title} by family")


def pads_by_group(results: Results, bounds: Sequence[CaseBound]) -> ReportTable:
    """Return the root mean square error of the pad friction of each group over the cases, where it is identifiable."""
    shares = np.array([bound.identifiable for bound in bounds])
    errors = {name: np.array([one.pads for one in cases]) for name, cases in results.items()}
    rows = [
        {"group": group + 1, "identifiable": float(np.nanmean(shares[:, group]))}
        | {name: float(np.sqrt(np.nanmean(values[:, group] ** 2))) for name, values in errors.items()}
        for group in range(shares.shape[1])
        if not all(np.isnan(values[:, group]).all() for values in errors.values())
    ]
    return ReportTable(
        rows, {"identifiable": share} | dict.fromkeys(errors, "{:.4f}"), title="Pad friction where identifiable"
    )


def skill_of_groups(cases: Sequence[CaseErrors], reference: Sequence[CaseErrors]) -> list[float]:
    """Return the skill of the pad friction of each group where it is identifiable; NaN where it never is."""
    pairs = np.array([(one.pads, other.pads) for one, other in zip(cases, reference, strict=True)]) ** 2
    finite = (pairs[:, :, group] for group in range(pairs.shape[2]))
    return [_skill(squares[np.isfinite(squares).all(axis=1)]) for squares in finite]


def targets(results: Results, design: Sequence[RecordingCase], bound: float) -> ReportTable:
    """Return the targets and the values of the estimator on board with the smallest median RMSE.

    Args:
        results: Errors by estimator.
        design: The cases.
        bound: Median over the cases of the Cramér-Rao bound of adhesion for the prediction of `fmu`.
    """
    rows = {str(row["estimator"]): row for row in leaderboard(results).rows}
    name = next(each for each in rows if each not in (*REFERENCES, *LAGS))
    coverage = [row[name] for row in by_family(results, design, "coverage").rows if name in row]
    groups = [math.nan, *skill_of_groups(results[name], results[CONSTANT])]
    found = [
        (
            "RMSE of fmu over the bound",
            "at most 1.2",
            rows["fmu"]["median RMSE"] / bound if "fmu" in rows else math.nan,
        ),
        ("skill over the force balance", "at least 0.6", rows[name]["over force balance"]),
        ("lowest coverage of a family", "at least 0.90", min(coverage, default=math.nan)),
        ("highest coverage of a family", "at most 0.98", max(coverage, default=math.nan)),
        ("lowest skill of the pads of a group over the constant, where identifiable", "above 0", np.nanmin(groups)),
        ("processor time of a step [µs]", "at most 15", rows[name]["step"]),
    ]
    return ReportTable.of(("target", "required", name), found, "{:.2f}", left=2, title="Targets")


def skill(cases: Sequence[CaseErrors], reference: Sequence[CaseErrors] | None, target: str = "adhesion") -> float:
    """Return 1 − mean squared error over that of a reference in the same cases; NaN without one."""
    return _skill(_squares(cases, reference, target))


def skill_interval(cases: Sequence[CaseErrors], reference: Sequence[CaseErrors] | None) -> str:
    """Return the percentile bootstrap interval of the skill for adhesion over the cases; empty with fewer than two."""
    return _interval(_squares(cases, reference, "adhesion"))


def _skill(squares: Matrix) -> float:
    return 1.0 - float(np.divide(*squares.sum(axis=0))) if squares.size else math.nan


def _interval(squares: Matrix) -> str:
    interval = bootstrap_interval(squares, lambda draws: 1.0 - np.divide(*draws.sum(axis=1).T))
    return "" if interval is None else "{:.2f} to {:.2f}".format(*interval).replace("-", "−")


def _squares(cases: Sequence[CaseErrors], reference: Sequence[CaseErrors] | None, target: str) -> Matrix:
    """Return the mean squared errors of an estimator and of a reference in the cases that have both, shape (k, 2)."""
    pairs = [(one.rmse[target], other.rmse[target]) for one, other in zip(cases, reference or (), strict=False)]
    squares = np.array(pairs, dtype=np.float64).reshape(-1, 2) ** 2
    return squares[np.isfinite(squares).all(axis=1)]


def _middle(cases: Sequence[CaseErrors], field: str) -> float:
    values = np.array([getattr(one, field) for one in cases], dtype=np.float64)
    return math.nan if np.isnan(values).all() else float(np.nanmedian(values))
