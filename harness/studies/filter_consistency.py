"""Errors of the filters of the two-part train and their claimed deviations, under each load and each fault."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from typer import Option

import railgrip.scenario
from railgrip.campaign.work import Work
from railgrip.estimation.judge import rms
from railgrip.report.baseline import Finding, mean
from railgrip.report.marked import write_tables
from railgrip.report.page import Page
from railgrip.report.table import ReportTable, whole_percent
from railgrip.scenario.file import merge
from railgrip.scenario.load import read_toml, scenario_of
from railgrip.simulate.run import run_stop
from railgrip.studies.study import Study
from railgrip.studies.type_test.design import FAULTS
from railgrip.trace.estimation import SLOWEST

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


Case = tuple[str, float, str, int, str]
"""Name of the rail, mass relative to the assumed one, key of the type test's faults, seed of sensors and rail, and key
of `FILTERS`: a stop with valves and service sensors, under slip control without estimates, so that no filter affects
it."""


class Errors(NamedTuple):
    """Errors of adhesion in a stop above 10 km/h.

    Attributes:
        rmse: RMS error of the filter over all groups.
        bias: Mean of estimate minus truth.
        nees: Mean squared error over variance, mean of the groups.
    """

    rmse: float
    bias: float
    nees: float


def errors_of(case: Case) -> Errors:
    """Run a case."""
    scenario, load, fault, seed, name = case
    rail = read_toml(_ROOT / "library" / f"{scenario}.toml")
    table = merge(rail, read_toml(_ROOT / "equipment" / "service.toml"))
    changes = {"estimator": FILTERS[name], "truth": {"load": load}, "seed": seed}
    table = merge(merge(table, changes), FAULTS[fault]) | {"controller": {"kind": "slip_three_state"}}
    trace = run_stop(scenario_of(table, directory=_ROOT / "library", origin=scenario)).trace
    moving = trace["speed"].values > SLOWEST
    error = (trace["estimate_adhesion"].values - trace["group_adhesion"].values)[moving]
    squares = (error / trace["estimate_adhesion_sd"].values[moving]) ** 2
    return Errors(rms(error), float(np.mean(error)), float(np.mean(squares)))


Results = Mapping[Case, Errors]


def by_load(results: Results) -> ReportTable:
    """Return the errors of each filter under each load, without a fault."""
    rows: list[dict[str, Any]] = []
    for load, name in product(LOADS, FILTERS):
        errors = _of(results, name, [load], "none")
        if errors:
            rmse, bias, _ = zip(*errors, strict=True)
            row = {"load": load, "filter": name, "stops": len(errors), "α RMSE": rms(np.array(rmse))}
            rows.append(row | {"α bias": float(np.mean(bias))} | _nees(errors))
    return ReportTable(rows, _FORMS, ("filter",), title="Adhesion by load")


def by_fault(results: Results) -> ReportTable:
    """Return the consistency of each filter under each fault, over the same loads."""
    rows: list[dict[str, Any]] = []
    for fault in FAULTS:
        of_filters = {name: _of(results, name, LADEN, fault) for name in FILTERS}
        if all(of_filters.values()):
            texts = {
                name: " / ".join(f"{nees:.2g}" for nees in _nees(errors).values())
                for name, errors in of_filters.items()
            }
            rows.append({"fault": fault, "stops": len(next(iter(of_filters.values())))} | texts)
    return ReportTable(rows, left=("fault",), title="NEES by fault: 10 %, median, 90 %")


def _of(results: Results, name: str, loads: Sequence[float], fault: str) -> list[Errors]:
    return [
        errors
        for (_, load, case_fault, _, case_name), errors in results.items()
        if (case_name, case_fault) == (name, fault) and load in loads
    ]


def _nees(errors: Sequence[Errors]) -> dict[str, float]:
    quantiles = {"NEES 10 %": 0.1, "NEES 50 %": 0.5, "NEES 90 %": 0.9}
    return {title: float(np.quantile([one.nees for one in errors], q)) for title, q in quantiles.items()}


@dataclass(frozen=True)
class FilterConsistency(Study):
    """Compare errors of adhesion with what the filters claim, under each load and each fault of the type test."""

    write: Annotated[bool, Option("--write", help="Write both tables into docs/faults.md.")] = False
    quick: bool = False

    def page(self, work: Work) -> Page:
        """Return errors by load and consistency by fault; the small form is one rail and one seed."""
        rails, seeds = (SCENARIOS[:1], SEEDS[:1]) if self.quick else (SCENARIOS, SEEDS)
        loads = list(product(rails, LOADS, ("none",), seeds, FILTERS))
        faults = [] if self.quick else list(product(rails, LADEN, FAULTS, seeds[:1], FILTERS))
        cases = list(dict.fromkeys([*loads, *faults]))
        results = dict(zip(cases, work.map(errors_of, cases), strict=True))
        tables = {
            "loads": by_load({case: results[case] for case in loads}),
            "faults": by_fault({case: results[case] for case in faults}),
        }
        if self.write:
            write_tables(PAGE, tables)
        return Page(
            title="What the filters of the train claim, by load and by fault",
            question="Are the filters of the train as sure of adhesion as they are right, if the load is another one?",
            answer=_answer({case: results[case] for case in loads}),
            template="studies/filter_consistency.md.jinja",
            values=tables,
            screen=tuple(tables.values()),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return the errors of two filters in a train that is lighter by a fifth."""
        cases = [("trapezoid", 0.8, "none", 1, name) for name in ("disturbed", "loaded")]
        return [
            mean(f"{name}, a fifth lighter: adhesion RMSE", errors.rmse)
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


def _answer(results: Results) -> str:
    medians: list[str] = []
    errors: list[str] = []
    for name in FILTERS:
        rmse, _, nees = zip(*_of(results, name, LOADS, "none"), strict=True)
        medians.append(f"{np.median(nees):.2g} ({name})")
        errors.append(f"{rms(np.array(rmse)):.4f}")
    return (
        f"A consistent filter has a NEES of 1; the median over all loads is {', '.join(medians)}. "
        f"In the same order the RMSE of adhesion is {', '.join(errors)}."
    )
