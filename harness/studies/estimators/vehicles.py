"""Filters of other vehicles than trains in the same comparison: wagon, roller rig and lateral wheelset."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from railgrip.base.names import ElementName
from railgrip.estimation.judge import NORMAL_95, rms
from railgrip.estimation.run import filter_data
from railgrip.estimation.several import context_of, run_kind
from railgrip.estimation.sources import recording_of_estimation
from railgrip.estimation.spec import load_specification, prediction_for, settings_for
from railgrip.estimators.belief import Array
from railgrip.recording.samples import period_of, truth_of
from railgrip.report.table import Form, ReportTable
from railgrip.studies.estimators.replay import bound_along
from railgrip.studies.lateral.judge import beliefs_about
from railgrip.studies.lateral.run import STIFFNESS_NAMES, LateralCase, bound_of_run, simulate
from railgrip.studies.lateral.wheelset import TESTS

KINDS: Final = ("fmu", "unscented", "sage_husa", "interacting")
"""Filters over the prediction of an estimation of the library."""

ESTIMATIONS: Final = ("wagon", "rig_own", "rig_paper")
"""Estimations of the library with the scenario of their recording; the last two have the same."""

SETTLED: Final = 0.5
"""Time after which errors are judged [s]: the filters do not know adhesion at the start."""

STATES: Final = ("group_adhesion", "pad_friction")

Row = dict[str, Any]


def rows_of_estimation(name: str) -> list[Row]:
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
    rows: list[Row] = []
    for kind in KINDS:
        run = run_kind(kind, context, data)
        for state in STATES:
            of = [i for i, each in enumerate(names) if ElementName.of(each).array == state]
            error, deviation = (run.mean - truth)[judged][:, of], np.sqrt(run.variance)[judged][:, of]
            rows.append(_row(name, kind, state, error, deviation) | {"bound": rms(smallest[judged][:, of])})
    return rows


def rows_of_lateral(seed: int) -> list[Row]:
    """Return the errors of friction of the lateral filters in the first test of the study, on the plant of the paper.

    The bound is that of each filter's own prediction, without and with the creep stiffness.
    """
    case = LateralCase(test=TESTS[0], speed=20.0, plant="paper", seed=seed)
    trace = simulate(case, STIFFNESS_NAMES)
    judged = trace.time >= SETTLED
    rows: list[Row] = []
    for name in STIFFNESS_NAMES:
        belief = beliefs_about(trace, name)["friction"]
        smallest = beliefs_about(replace(trace, beliefs={name: bound_of_run(case, name)}), name)["friction"].deviation
        error = (belief.mean - trace.truth["friction"])[judged]
        row = _row("lateral", name, "friction", error, belief.deviation[judged])
        rows.append(row | {"bound": rms(smallest[judged])})
    return rows


def _row(family: str, estimator: str, state: str, error: Array, deviation: Array) -> Row:
    return {
        "family": family,
        "estimator": estimator,
        "quantity": state,
        "RMSE": rms(error),
        "coverage": float(np.mean(np.abs(error) <= NORMAL_95 * deviation)),
        "NEES": float(np.mean((error / deviation) ** 2)),
    }


def vehicles(rows: Sequence[Row]) -> ReportTable:
    """Return the errors of all families as a table."""
    columns = ("family", "estimator", "quantity", "RMSE", "bound", "coverage", "NEES")
    table = [{column: row.get(column, "") for column in columns} for row in rows]
    forms: dict[str, Form] = {"RMSE": "{:.4f}", "bound": _bound, "coverage": "{:.2f}", "NEES": "{:.2g}"}
    return ReportTable(table, forms, left=("family", "estimator", "quantity"), title="Other vehicles")


def _bound(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4f}"
