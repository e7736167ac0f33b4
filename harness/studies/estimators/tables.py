"""Tables of the errors of estimators: leaderboard, claims, families, other targets, and other vehicles."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
import pandas

from railgrip.estimation.judgement import error_figures, rms
from railgrip.estimation.lateral.run import STIFFNESS_NAMES, LateralCase, bound_of_run, simulate
from railgrip.estimation.lateral.run_measures import beliefs_about
from railgrip.estimation.lateral.wheelset import TESTS
from railgrip.estimation.run import context_of, filter_data, run_kind
from railgrip.estimation.sources import recording_of_estimation
from railgrip.estimation.spec import load_specification, prediction_for, settings_for
from railgrip.estimators.belief import Matrix
from railgrip.recording.samples import period_of, truth_of
from railgrip.report.frame import Frame, groups_of
from railgrip.report.statistics import bootstrap_interval, median_interval, on_common, rank
from railgrip.report.table import Form, ReportTable, share
from railgrip.studies.estimators.case_errors import CaseBound
from railgrip.studies.estimators.recordings import FAMILIES
from railgrip.studies.estimators.replay import CONSTANT, FORCE_BALANCE, bound_along, columns, entry_of

Measure = Literal["rmse", "coverage"]

ESTIMATIONS: Final = ("wagon", "rig_own", "rig_paper")
"""Estimations of the library with the scenario of their recording; the last two have the same."""

KINDS: Final = ("fmu", "unscented", "sage_husa", "interacting")
"""Filters over the prediction of one of `ESTIMATIONS`."""

SETTLED: Final = 0.5
"""Time after which errors are judged [s]: the filters do not know adhesion at the start."""

STATES: Final = ("group_adhesion", "pad_friction")


def _error(value: float) -> str:
    # The error of an estimator that diverged is infinite, so that it is the last; its cell is empty.
    return f"{value:.4f}" if math.isfinite(value) else ""


RANKS: Final[Mapping[str, tuple[str, Form]]] = {
    "estimator": ("estimator", ""),
    "cases": ("cases", "{}"),
    "median": ("median RMSE", _error),
    "low": ("from", _error),
    "high": ("to", _error),
    "bias": ("bias", "{:+.4f}"),
    "delay": ("delay", "{:.2f} s"),
    "step_delay": ("after a step", "{:.2f} s"),
    "over_constant": ("over constant", "{:.2f}"),
    "over_force_balance": ("over force balance", "{:.2f}"),
    "interval": ("95 %", ""),
    "diverged": ("diverged", "{}"),
    "microseconds": ("step", "{:.0f} µs"),
}
"""Column of `rank_estimators` → its title in the leaderboard, and its form."""


def rank_estimators(frame: Frame) -> Frame:
    """Return the errors of adhesion of every estimator in the columns of `RANKS`, the smallest median first.

    Estimators are compared in the cases that all of them have; where one diverged, its error is infinite. Skill is 1
    minus the mean squared error over that of the reference, and `interval` that of the skill over the force balance.

    Args:
        frame: A row for each estimator and case: `estimator`, `case`, and what `errors_of` returns, nested names joined
            by a dot.
    """
    frame = on_common(frame.assign(error=_endless(frame)), "estimator", ["case"], "error")
    rows: list[tuple[str | float, ...]] = []
    for name, count, median in rank(frame, "estimator", ["case"], "error")[["cases", "median"]].itertuples():
        cases = frame[frame["estimator"] == name]
        ends = median_interval(cases["error"]) or (math.nan, math.nan)
        medians = (cases[figure].median() for figure in ("bias", "delay", "step_delay"))
        over_balance = squares_of(frame, name, FORCE_BALANCE)
        skills = (skill(squares_of(frame, name, CONSTANT)), skill(over_balance), _interval(over_balance))
        effort = (cases["diverged"].sum(), cases["microseconds"].median())
        rows.append((name, count, median, *ends, *medians, *skills, *effort))
    return pandas.DataFrame(rows, columns=list(RANKS), dtype=object)


def leaderboard(ranked: Frame) -> ReportTable:
    """Return ranked estimators as a table."""
    return ReportTable.of(dict(RANKS.values()), ranked.itertuples(index=False), title="Adhesion")


def consistency(frame: Frame) -> ReportTable:
    """Return coverage, width, NEES and NIS with quantiles over the cases in which all that claim a deviation do so."""
    rows = [
        (
            name,
            cases["coverage.adhesion"].mean(),
            cases["width"].median(),
            *np.quantile(cases["nees"], (0.1, 0.5, 0.9)).tolist(),
            cases["nis"].median(),
            cases["lost"].mean(),
            cases["admitted"].median(),
        )
        for (name,), cases in groups_of(on_common(frame, "estimator", ["case"], "nees"), ["estimator"])
    ]
    forms: dict[str, Form] = {"estimator": "", "coverage": "{:.2f}", "width": "{:.4f}"}
    forms |= dict.fromkeys(("NEES 10 %", "NEES 50 %", "NEES 90 %", "NIS"), "{:.2g}")
    forms |= dict.fromkeys(("lost", "admitted"), share)
    return ReportTable.of(forms, rows, title="Claims")


def others(frame: Frame) -> ReportTable:
    """Return errors and coverage of pad friction and speed, and the skill of pad friction over the constant."""
    names = frame["estimator"].unique()
    columns = [names]
    for target in ("pad_friction", "speed"):
        cases = on_common(frame, "estimator", ["case"], f"rmse.{target}").groupby("estimator")
        for figure in (cases[f"rmse.{target}"].median(), cases[f"coverage.{target}"].mean()):
            columns.append([figure.get(name) for name in names])
    columns.append([skill(squares_of(frame, name, CONSTANT, "pad_friction")) for name in names])
    forms = {"estimator": "", "pad friction RMSE": "{:.4f}", "pad friction coverage": "{:.2f}"}
    forms |= {"speed RMSE": "{:.3f} m/s", "speed coverage": "{:.2f}", "pads over constant": "{:.2f}"}
    return ReportTable.of(forms, zip(*columns, strict=True))


def available(frame: Frame) -> ReportTable:
    """Return the errors of the available adhesion of every estimator that knows it somewhere.

    Errors are root mean squares over the cases of those where an estimator knows it; the references are judged there
    too.
    """
    rows: list[tuple[str | float, ...]] = []
    for (name,), cases in groups_of(frame, ["estimator"]):
        squares = _finite(cases[["available.rmse", "available.recent", "available.constant"]])
        if squares.size:
            own, *of_references = np.sqrt(np.mean(squares, axis=0)).tolist()
            known, bias, covered = (cases[f"available.{figure}"].mean() for figure in ("known", "bias", "coverage"))
            gain = squares[:, :2]
            rows.append((name, known, own, bias, covered, *of_references, skill(gain), _interval(gain)))
    forms: dict[str, Form] = {
        "estimator": "",
        "known": share,
        "RMSE": "{:.4f}",
        "bias": "{:+.4f}",
        "coverage": "{:.2f}",
    }
    forms |= dict.fromkeys(("RMSE of the last second", "RMSE of the constant"), "{:.4f}")
    return ReportTable.of(forms | {"over the last second": "{:.2f}", "95 %": ""}, rows, title="Available adhesion")


def by_family(frame: Frame, measure: Measure = "rmse") -> ReportTable:
    """Return the median RMSE of adhesion, or its mean coverage, of each estimator in each family of cases.

    Cases that an estimator lacks are left out; where one diverged, its error is infinite.
    """
    frame = frame.assign(**{"rmse.adhesion": _endless(frame)})
    errors = _by_case(frame, f"{measure}.adhesion")
    errors = errors.loc[:, np.isfinite(errors).any()].dropna()
    cases = frame.drop_duplicates("case").set_index("case")
    middle = "median" if measure == "rmse" else "mean"
    rows = [
        (family, len(inside), *(getattr(inside[name], middle)() for name in inside))
        for field in FAMILIES
        for family, inside in errors.groupby(cases[field])
    ]
    form, title = (_error, "Median RMSE") if measure == "rmse" else ("{:.2f}", "Coverage")
    forms = {"family": "", "cases": "{}", **dict.fromkeys(errors, form)}
    return ReportTable.of(forms, rows, title=f"{title} by family")


def pads_by_group(frame: Frame, bounds: Sequence[CaseBound]) -> ReportTable:
    """Return the root mean square error of the pad friction of each group over the cases, where it is identifiable."""
    shares = np.array([identifiable for _, identifiable in bounds])
    errors = {name: _pads(cases) for (name,), cases in groups_of(frame, ["estimator"])}
    rows = [
        {"group": group + 1, "identifiable": float(np.nanmean(shares[:, group]))}
        | {name: float(np.sqrt(pandas.Series(values[:, group] ** 2).mean())) for name, values in errors.items()}
        for group in range(shares.shape[1])
        if not all(np.isnan(values[:, group]).all() for values in errors.values())
    ]
    return ReportTable(
        rows, {"identifiable": share} | dict.fromkeys(errors, "{:.4f}"), title="Pad friction where identifiable"
    )


def _pads(cases: Frame) -> Matrix:
    return np.array(cases["pads"].tolist(), dtype=np.float64)


def skill_of_groups(own: Frame, reference: Frame) -> list[float]:
    """Return the skill of the pad friction of each group where it is identifiable; NaN where it never is."""
    groups = zip(_pads(own).T, _pads(reference).T, strict=True)
    return [skill(_finite(np.column_stack(pair))) for pair in groups]


def targets(frame: Frame, ranked: Frame, bound: float) -> ReportTable:
    """Return the targets and the values of the estimator on board with the smallest median RMSE.

    Args:
        frame: As for `rank_estimators`, which returns `ranked`.
        ranked: Estimators, the smallest error first.
        bound: Median over the cases of the Cramér-Rao bound of adhesion for the prediction of `fmu`.
    """
    by_name = ranked.set_index("estimator")
    name = next(each for each in by_name.index if not entry_of(each).is_reference and entry_of(each).later == 0)
    best = by_name.loc[name]
    coverage = [row[name] for row in by_family(frame, "coverage").rows if name in row]
    own, constant = (frame[frame["estimator"] == each] for each in (name, CONSTANT))
    groups = [math.nan, *skill_of_groups(own, constant)]
    ratio = by_name.loc["fmu", "median"] / bound if "fmu" in by_name.index else math.nan
    values = [
        ("RMSE of fmu over the bound", "at most 1.2", ratio),
        ("skill over the force balance", "at least 0.6", best["over_force_balance"]),
        ("lowest coverage of a family", "at least 0.90", min(coverage, default=math.nan)),
        ("highest coverage of a family", "at most 0.98", max(coverage, default=math.nan)),
        ("lowest skill of the pads of a group over the constant, where identifiable", "above 0", np.nanmin(groups)),
        ("processor time of a step [µs]", "at most 15", best["microseconds"]),
    ]
    return ReportTable.of(("target", "required", name), values, "{:.2f}", left=2, title="Targets")


def skill(squares: Matrix) -> float:
    """Return 1 − mean squared error over that of a reference in the same cases, shape (k, 2); NaN without cases."""
    return 1.0 - float(np.divide(*squares.sum(axis=0))) if squares.size else math.nan


def _interval(squares: Matrix) -> str:
    """Return the percentile bootstrap interval of the skill over the cases; empty with too few."""
    interval = bootstrap_interval(squares, lambda draws: 1.0 - np.divide(*draws.sum(axis=1).T))
    return "" if interval is None else "{:.2f} to {:.2f}".format(*interval).replace("-", "−")


def squares_of(frame: Frame, estimator: str, reference: str, target: str = "adhesion") -> Matrix:
    """Return the mean squared errors of an estimator and of a reference in the cases that have both, shape (k, 2)."""
    errors = _by_case(frame, f"rmse.{target}")
    return _finite(errors[[estimator, reference]]) if reference in errors else np.empty((0, 2))


def _endless(frame: Frame) -> Frame:
    """Return the RMSE of adhesion, infinite where the estimator diverged."""
    return frame["rmse.adhesion"].mask(frame["diverged"].astype(bool), math.inf)


def _by_case(frame: Frame, figure: str) -> Frame:
    """Return a figure with a row for each case and a column for each estimator, in the order of the frame."""
    table = frame.pivot(index="case", columns="estimator", values=figure)
    return table.reindex(index=frame["case"].unique(), columns=frame["estimator"].unique())


def _finite(errors: Any) -> Matrix:
    """Return the squares of the rows in which all errors exist."""
    squares = np.array(errors, dtype=np.float64, order="C") ** 2
    return squares[np.isfinite(squares).all(axis=1)]


OTHERS: Final = ("family", "estimator", "quantity", "RMSE", "bound", "coverage", "NEES")
"""Columns of the errors of filters of other vehicles: the root mean square error of a quantity and that of its bound,
the share of errors within the claimed 95 % interval, and their mean square over the claimed variance."""


def errors_of_estimation(name: str) -> Frame:
    """Return the errors of `KINDS` on the recording of an estimation of the library, a row for each state.

    The bound is that of the prediction linearised along the true states, with the noises of the estimation and without
    its gate.
    """
    specification = load_specification(Path(name))
    recording = recording_of_estimation(specification)
    prediction, settings = prediction_for(specification), settings_for(specification, period_of(recording))
    data = filter_data(recording, prediction, settings)
    context = context_of(prediction, settings, data)
    names = context.prediction.states
    truth = np.column_stack([truth_of(recording, state) for state in names])
    judged = recording["time"].values >= SETTLED
    smallest = np.sqrt(bound_along(context, data, truth))
    rows: list[dict[str, str | float]] = []
    for kind in KINDS:
        run = run_kind(kind, context, data)
        for state in STATES:
            of = columns(names, state)
            error, deviation = (run.mean - truth)[judged][:, of], np.sqrt(run.variance)[judged][:, of]
            about = {"family": name, "estimator": kind, "quantity": state, "bound": rms(smallest[judged][:, of])}
            rows.append(about | error_figures(error, deviation))
    return pandas.DataFrame(rows, columns=list(OTHERS))


def errors_of_lateral(seed: int) -> Frame:
    """Return the errors of friction of the lateral filters in the first test of the study, on the plant of the paper.

    The bound is that of each filter's own prediction, without and with the creep stiffness.
    """
    case = LateralCase(test=TESTS[0], speed=20.0, plant="paper", seed=seed)
    trace = simulate(case, STIFFNESS_NAMES)
    judged = trace.time >= SETTLED
    rows: list[dict[str, str | float]] = []
    for name in STIFFNESS_NAMES:
        belief = beliefs_about(trace, name)["friction"]
        smallest = beliefs_about(replace(trace, beliefs={name: bound_of_run(case, name)}), name)["friction"].deviation
        error = (belief.mean - trace.truth["friction"])[judged]
        about = {"family": "lateral", "estimator": name, "quantity": "friction", "bound": rms(smallest[judged])}
        rows.append(about | error_figures(error, belief.deviation[judged]))
    return pandas.DataFrame(rows, columns=list(OTHERS))


def vehicles(frame: Frame) -> ReportTable:
    """Return the errors of all families as a table."""
    forms = {"RMSE": "{:.4f}", "bound": "{:.4f}", "coverage": "{:.2f}", "NEES": "{:.2g}"}
    return ReportTable.of_frame(frame, forms, OTHERS[:3], title="Other vehicles")
