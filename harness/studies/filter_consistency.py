"""Errors of the filters of the two-part train and their claimed deviations, under each load and each fault."""

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas
from typer import Option

import railgrip.scenario
from railgrip.campaign.work import Work
from railgrip.estimation.judge import rms
from railgrip.report.baseline import Finding, mean
from railgrip.report.frame import Frame, groups_of
from railgrip.report.page import Page
from railgrip.report.statistics import rank
from railgrip.report.table import ReportTable, whole_percent, write_tables
from railgrip.scenario.file import merge
from railgrip.scenario.load import read_toml, scenario_of
from railgrip.simulate.run import run_stop
from railgrip.studies.study import Study
from railgrip.studies.type_test.design import FAULTS
from railgrip.trace.measures import SLOWEST

PAGE = Path("docs/faults.md")
"""Folder relative to that of the project, in which the command runs."""

FILTERS = {
    "disturbed": {"model": "TrainPredictionDisturbed"},
    "disturbed, load ±10 %": {"model": "TrainPredictionDisturbed", "load_deviation": 0.1},
    "loaded": {"model": "TrainPredictionLoaded"},
}
"""Filters by their assumption on the load: nominal, uncertain, or estimated."""
LOADS = (0.8, 0.9, 1.0, 1.05, 1.12)
SCENARIOS = ("trapezoid", "sine_sweep", "random")
SEEDS = (1, 2, 3)

_ROOT = Path(railgrip.scenario.__file__).parent


AXES = ("scenario", "load", "fault", "seed", "filter")
COLUMNS = (*AXES, "rmse", "bias", "nees")

Case = tuple[str, float, str, int, str]
"""Name of the rail, mass relative to the assumed one, key of the type test's faults, seed of sensors and rail, and key
of `FILTERS`: a stop with valves and service sensors, under slip control without estimates, so that no filter affects
it."""


def errors_of(case: Case) -> dict[str, float]:
    """Run a case and return the errors of adhesion above 10 km/h.

    `rmse`: RMS error of the filter over all groups; `bias`: mean of estimate minus truth; `nees`: mean squared error
    over variance, mean of the groups.
    """
    scenario, load, fault, seed, name = case
    rail = read_toml(_ROOT / "library" / f"{scenario}.toml")
    table = merge(rail, read_toml(_ROOT / "equipment" / "service.toml"))
    changes = {"estimator": FILTERS[name], "truth": {"load": load}, "seed": seed}
    table = merge(merge(table, changes), FAULTS[fault]) | {"controller": {"kind": "slip_three_state"}}
    trace = run_stop(scenario_of(table, directory=_ROOT / "library", origin=scenario)).trace
    moving = trace["speed"].values > SLOWEST
    error = (trace["estimate_adhesion"].values - trace["group_adhesion"].values)[moving]
    squares = (error / trace["estimate_adhesion_sd"].values[moving]) ** 2
    return {"rmse": rms(error), "bias": float(np.mean(error)), "nees": float(np.mean(squares))}


def by_load(frame: Frame) -> ReportTable:
    """Return the errors of each filter under each load; the frame has a row for each case, of `AXES` and its errors."""
    rows = [
        {"load": load, "filter": name, "stops": len(stops), "α RMSE": rms(stops["rmse"].to_numpy())}
        | {"α bias": float(np.mean(stops["bias"].to_numpy()))}
        | _nees(stops)
        for (load, name), stops in groups_of(frame, ("load", "filter"))
    ]
    return ReportTable(rows, _FORMS, ("filter",), title="Adhesion by load")


def by_fault(frame: Frame) -> ReportTable:
    """Return the consistency of each filter under each fault, over the same loads."""
    rows = [
        {"fault": fault, "stops": len(stops) // len(FILTERS)}
        | {
            name: " / ".join(f"{nees:.2g}" for nees in _nees(part).values())
            for (name,), part in groups_of(stops, ["filter"])
        }
        for (fault,), stops in groups_of(frame, ["fault"])
    ]
    return ReportTable(rows, left=("fault",), title="NEES by fault: 10 %, median, 90 %")


def _nees(stops: Frame) -> dict[str, float]:
    quantiles = {"NEES 10 %": 0.1, "NEES 50 %": 0.5, "NEES 90 %": 0.9}
    return {title: float(np.quantile(stops["nees"], share)) for title, share in quantiles.items()}


@dataclass(frozen=True)
class FilterConsistency(Study, quick="one rail, one seed, and no faults"):
    """Compare errors of adhesion with what the filters claim, under each load and each fault of the type test."""

    write: Annotated[bool, Option("--write", help="Write both tables into docs/faults.md.")] = False

    def page(self, work: Work) -> Page:
        """Return errors by load and consistency by fault; the small form is one rail and one seed."""
        rails, seeds = (SCENARIOS[:1], SEEDS[:1]) if self.quick else (SCENARIOS, SEEDS)
        loads = list(product(rails, LOADS, ("none",), seeds, FILTERS))
        faults = [] if self.quick else list(product(rails, LADEN, FAULTS, seeds[:1], FILTERS))
        cases = list(dict.fromkeys([*loads, *faults]))
        errors = dict(zip(cases, work.map(errors_of, cases), strict=True))
        of_loads, of_faults = (
            pandas.DataFrame([dict(zip(AXES, case, strict=True)) | errors[case] for case in part], columns=COLUMNS)
            for part in (loads, faults)
        )
        tables = {"loads": by_load(of_loads), "faults": by_fault(of_faults)}
        if self.write:
            write_tables(PAGE, tables)
        return Page(
            title="What the filters of the train claim, by load and by fault",
            question="Are the filters of the train as sure of adhesion as they are right, if the load is another one?",
            answer=_answer(of_loads),
            template="studies/filter_consistency.md.jinja",
            values=tables,
            screen=tuple(tables.values()),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return the errors of two filters in a train that is lighter by a fifth."""
        cases = [("trapezoid", 0.8, "none", 1, name) for name in ("disturbed", "loaded")]
        return [
            mean(f"{name}, a fifth lighter: adhesion RMSE", errors["rmse"])
            for (*_, name), errors in zip(cases, work.map(errors_of, cases), strict=True)
        ]


STUDY = FilterConsistency

LADEN = (0.8, 1.0, 1.05)
"""Loads under which faults are compared: those of the type test."""

_FORMS = {
    "load": whole_percent,
    **dict.fromkeys(("α RMSE", "α bias"), "{:.4f}"),
    **dict.fromkeys(("NEES 10 %", "NEES 50 %", "NEES 90 %"), "{:.2g}"),
}


def _answer(frame: Frame) -> str:
    medians = rank(frame, "filter", AXES[:-1], "nees")["median"].items()
    errors = [f"{rms(frame['rmse'][frame['filter'] == name].to_numpy()):.4f}" for name, _ in medians]
    return (
        f"A consistent filter has a NEES of 1; the median over all loads is "
        f"{', '.join(f'{nees:.2g} ({name})' for name, nees in medians)}. "
        f"In the same order the RMSE of adhesion is {', '.join(errors)}."
    )
