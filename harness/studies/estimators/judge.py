"""Errors of estimators by case, and their leaderboard."""

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import xarray

from railgrip.base.errors import FilterDiverged
from railgrip.estimation.judge import rms
from railgrip.estimators.belief import Array
from railgrip.report.statistics import median_interval
from railgrip.report.table import ReportTable
from railgrip.simulate.estimator import RELEASED_PADS
from railgrip.studies.estimators.recordings import RecordingCase, recording_of_case
from railgrip.studies.estimators.replay import Replay, bound_of, replay, states, with_estimates
from railgrip.trace.estimation import SLOWEST, adhesion_errors
from railgrip.vehicle.signals import READINGS

TARGETS: Final[Mapping[str, str]] = {"adhesion": "group_adhesion", "pad_friction": "pad_friction", "speed": "speed"}
"""Estimated quantity → true variable of the trace."""

CONSTANT: Final = "constant"
"""Name of the best constant of the training set."""

FORCE_BALANCE: Final = "force_balance"

NORMAL_95: Final = 1.96


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseErrors:
    """Errors of an estimator in one recording above 10 km/h.

    Attributes:
        digest: SHA-256 of the readings, equal for all estimators.
        diverged: Whether the filter diverged; errors are NaN then.
        rmse: Target → root mean square error over all groups.
        bias: Mean error of adhesion over all groups.
        delay: Delay of adhesion, mean of the groups [s].
        coverage: Target → share of samples within the claimed 95 % interval; NaN without a claim.
        width: Median width of the claimed 95 % interval of adhesion.
        nees: Mean squared error of adhesion over its variance, mean of the groups.
        nis: Median of the normalised innovation squared over its expected one; NaN without innovations.
        microseconds: Processor time of a step [µs].
    """

    digest: str
    diverged: bool
    rmse: Mapping[str, float]
    bias: float
    delay: float
    coverage: Mapping[str, float]
    width: float
    nees: float
    nis: float
    microseconds: float


EstimatorCase = tuple[RecordingCase, str, tuple[tuple[str, float], ...]]
"""A recording, the name of an estimator, and the best constants: target → value."""


def errors_of(case: EstimatorCase) -> CaseErrors:
    """Run an estimator over a recording and return its errors."""
    recording_case, estimator, constants = case
    recording = recording_of_case(recording_case)
    digest = hashlib.sha256(b"".join(recording[signal.name].values.tobytes() for signal in READINGS)).hexdigest()
    try:
        found = _constant(recording, dict(constants)) if estimator == CONSTANT else replay(recording_case, estimator)
    except FilterDiverged:
        nothing = dict.fromkeys(TARGETS, math.nan)
        return CaseErrors(
            digest=digest, diverged=True, rmse=nothing, bias=math.nan, delay=math.nan, coverage=nothing,
            width=math.nan, nees=math.nan, nis=math.nan, microseconds=math.nan,
        )  # fmt: skip
    return _judge(with_estimates(recording, states(estimator), found.mean, found.variance), found, digest)


def _constant(recording: xarray.Dataset, constants: Mapping[str, float]) -> Replay:
    bases = {"alpha": "adhesion", "mu_b": "pad_friction"}
    row = [constants.get(bases.get(name.partition("[")[0], ""), math.nan) for name in states()]
    mean = np.tile(row, (recording.sizes["time"], 1))
    return Replay(mean=mean, variance=np.full(mean.shape, math.nan), nis_ratio=None, microseconds=0.0)


def _judge(trace: xarray.Dataset, found: Replay, digest: str) -> CaseErrors:
    adhesion = adhesion_errors(trace)
    errors = {target: _errors(trace, target, true) for target, true in TARGETS.items()}
    return CaseErrors(
        digest=digest,
        diverged=False,
        rmse={target: rms(error) if error.size else math.nan for target, (error, _) in errors.items()},
        bias=_mean(adhesion["adhesion_bias"]),
        delay=_mean(adhesion["adhesion_delay"]),
        coverage={
            target: float(np.mean(np.abs(error) <= NORMAL_95 * sd)) if np.isfinite(sd).all() and sd.size else math.nan
            for target, (error, sd) in errors.items()
        },
        width=2.0 * NORMAL_95 * float(np.median(errors["adhesion"][1])),
        nees=_mean(adhesion["adhesion_nees"]),
        nis=math.nan if found.nis_ratio is None else found.nis_ratio,
        microseconds=found.microseconds,
    )


def _mean(values: tuple[float, ...] | None) -> float:
    return math.nan if values is None else float(np.mean(values))


def _moving(trace: xarray.Dataset, name: str) -> Array:
    return trace[name].values[trace["speed"].values > SLOWEST]


def _errors(trace: xarray.Dataset, target: str, true: str) -> tuple[Array, Array]:
    """Return error and claimed deviation of all groups above 10 km/h; of pad friction only while the pads press."""
    error = _moving(trace, f"estimate_{target}") - _moving(trace, true)
    deviation = _moving(trace, f"estimate_{target}_sd")
    if target != "pad_friction":
        return error.ravel(), deviation.ravel()
    presses = _moving(trace, "pad_force") > RELEASED_PADS
    return error[presses], deviation[presses]


def truths_of(case: RecordingCase) -> dict[str, tuple[float, int]]:
    """Return sum and number of the true values of adhesion and pad friction that are judged."""
    recording = recording_of_case(case)
    adhesion, pads = (_moving(recording, TARGETS[target]) for target in ("adhesion", "pad_friction"))
    pads = pads[_moving(recording, "pad_force") > RELEASED_PADS]
    return {"adhesion": (float(np.sum(adhesion)), adhesion.size), "pad_friction": (float(np.sum(pads)), pads.size)}


def bounds_of(case: RecordingCase) -> float:
    """Return the root mean square of the posterior Cramér-Rao bound of adhesion over groups and time."""
    bound = bound_of(case)
    return rms(np.array([each for name, each in zip(states(), bound, strict=True) if name.startswith("alpha")]))


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
                "over constant": skill(cases, results.get(CONSTANT)),
                "over force balance": skill(cases, results.get(FORCE_BALANCE)),
                "diverged": sum(one.diverged for one in cases),
                "step": _middle(cases, "microseconds"),
            }
        )
    rows.sort(key=lambda row: (math.isnan(row["median RMSE"]), row["median RMSE"]))
    forms = dict.fromkeys(("median RMSE", "from", "to"), "{:.4f}") | {"bias": "{:+.4f}", "delay": "{:.2f} s"}
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
            }
        )
    forms = {"coverage": "{:.2f}", "width": "{:.4f}", "NIS": "{:.2g}"}
    return ReportTable(rows, forms | dict.fromkeys(("NEES 10 %", "NEES 50 %", "NEES 90 %"), "{:.2g}"), title="Claims")


def others(results: Results) -> ReportTable:
    """Return errors and coverage of pad friction and speed."""
    rows: list[dict[str, Any]] = []
    for name, cases in results.items():
        row: dict[str, Any] = {"estimator": name}
        for target, title in (("pad_friction", "pad friction"), ("speed", "speed")):
            errors = np.array([one.rmse[target] for one in cases])
            claims = np.array([one.coverage[target] for one in cases])
            row[f"{title} RMSE"] = math.nan if np.isnan(errors).all() else float(np.nanmedian(errors))
            row[f"{title} coverage"] = math.nan if np.isnan(claims).all() else float(np.nanmean(claims))
        rows.append(row)
    forms = {"pad friction RMSE": "{:.4f}", "speed RMSE": "{:.3f} m/s"}
    return ReportTable(rows, forms | dict.fromkeys(("pad friction coverage", "speed coverage"), "{:.2f}"))


def by_family(results: Results, design: Sequence[RecordingCase]) -> ReportTable:
    """Return the median RMSE of adhesion by sensors and by demand."""
    families = {str(getattr(case, field)): field for field in ("sensors", "demand") for case in design}
    rows = [
        {"estimator": name}
        | {
            family: float(np.nanmedian([one.rmse["adhesion"] for one, case in pairs if getattr(case, field) == family]))
            for family, field in families.items()
        }
        for name, cases in results.items()
        for pairs in [list(zip(cases, design, strict=True))]
    ]
    return ReportTable(rows, dict.fromkeys(families, "{:.4f}"), title="Median RMSE of adhesion by sensors and demand")


def skill(cases: Sequence[CaseErrors], reference: Sequence[CaseErrors] | None) -> float:
    """Return 1 − mean squared error of adhesion over that of a reference in the same cases; NaN without one."""
    if reference is None:
        return math.nan
    pairs = [(one.rmse["adhesion"], other.rmse["adhesion"]) for one, other in zip(cases, reference, strict=True)]
    both = np.array([pair for pair in pairs if np.isfinite(pair).all()]).reshape(-1, 2)
    return 1.0 - float(np.sum(both[:, 0] ** 2) / np.sum(both[:, 1] ** 2)) if both.size else math.nan


def _middle(cases: Sequence[CaseErrors], field: str) -> float:
    values = np.array([getattr(one, field) for one in cases], dtype=np.float64)
    return math.nan if np.isnan(values).all() else float(np.nanmedian(values))
