"""Errors of the filters of the two-part train, and what they claim, under each load and each fault."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from typer import Option

import railgrip.scenario
from railgrip.campaign.work import Work
from railgrip.report.baseline import Finding, mean
from railgrip.report.marked import write_tables
from railgrip.report.page import Page
from railgrip.report.table import Table
from railgrip.scenario.load import read_toml, scenario_of
from railgrip.scenario.merge import merged
from railgrip.simulate.run import run_stop
from railgrip.studies.study import Study
from railgrip.studies.type_test.design import FAULTS
from railgrip.trace.estimation import SLOWEST

PAGE = Path("docs/faults.md")
"""From the folder of the project, where the command runs."""

FILTERS = {
    "disturbed": {"model": "TrainPredictionDisturbed"},
    "disturbed, load ±10 %": {"model": "TrainPredictionDisturbed", "load_deviation": 0.1},
    "loaded": {"model": "TrainPredictionLoaded"},
}
"""Filters by what they assume of the load: that it is nominal, that it is not, and that it can be learned."""
LOADS = (0.8, 0.9, 1.0, 1.05, 1.12)
SCENARIOS = ("trapezoid", "sine_sweep", "random")
SEEDS = (1, 2, 3)

_ROOT = Path(railgrip.scenario.__file__).parent


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A stop with valves and service sensors, under slip control without estimates: no filter moves it.

    Attributes:
        scenario: Name of the rail.
        load: Mass over the one that the filter knows.
        fault: Key of the type test's faults.
        filter: Key of `FILTERS`.
        seed: Of sensors and rail.
    """

    scenario: str
    load: float
    fault: str
    filter: str
    seed: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Errors:
    """Errors of adhesion in a stop above 10 km/h.

    Attributes:
        rmse: Of the filter, over all groups.
        bias: Mean of estimate minus truth.
        nees: Mean squared error over variance, mean of the groups.
    """

    rmse: float
    bias: float
    nees: float


def errors_of(case: Case) -> Errors:
    """Run a case."""
    rail = read_toml(_ROOT / "library" / f"{case.scenario}.toml")
    table = merged(rail, read_toml(_ROOT / "equipment" / "service.toml"))
    changes = {"estimator": FILTERS[case.filter], "truth": {"load": case.load}, "seed": case.seed}
    table = merged(merged(table, changes), FAULTS[case.fault]) | {"controller": {"kind": "slip_three_state"}}
    trace = run_stop(scenario_of(table, directory=_ROOT / "library", origin=case.scenario)).trace
    moving = trace["speed"].values > SLOWEST
    error = (trace["estimate_adhesion"].values - trace["group_adhesion"].values)[moving]
    squares = (error / trace["estimate_adhesion_sd"].values[moving]) ** 2
    return Errors(
        rmse=float(np.sqrt(np.mean(error**2))),
        bias=float(np.mean(error)),
        nees=float(np.mean(squares)),
    )


Results = Mapping[Case, Errors]


def by_load(results: Results) -> Table:
    """Return the errors of each filter under each load, without a fault."""
    rows: list[dict[str, Any]] = []
    for load, name in product(LOADS, FILTERS):
        cases = [e for c, e in results.items() if (c.load, c.filter, c.fault) == (load, name, "none")]
        if cases:
            rmse = float(np.sqrt(np.mean([case.rmse**2 for case in cases])))
            bias = float(np.mean([case.bias for case in cases]))
            rows.append(
                {"load": load, "filter": name, "stops": len(cases), "α RMSE": rmse, "α bias": bias} | _nees(cases)
            )
    return Table(rows, _FORMS, ("filter",), title="Adhesion by load")


def by_fault(results: Results) -> Table:
    """Return the consistency of each filter under each fault, over the same loads."""
    rows: list[dict[str, Any]] = []
    for fault in FAULTS:
        row: dict[str, Any] = {"fault": fault}
        for name in FILTERS:
            cases = [e for c, e in results.items() if (c.filter, c.fault, c.load in LADEN) == (name, fault, True)]
            row |= (
                {"stops": len(cases)} | {name: " / ".join(f"{value:.2g}" for value in _nees(cases).values())}
                if cases
                else {}
            )
        if len(row) > 1:
            rows.append(row)
    return Table(rows, left=("fault",), title="NEES by fault: 10 %, median, 90 %")


def _nees(errors: Sequence[Errors]) -> dict[str, float]:
    values = [case.nees for case in errors]
    return {
        f"NEES {title}": float(np.quantile(values, q)) for title, q in (("10 %", 0.1), ("50 %", 0.5), ("90 %", 0.9))
    }


@dataclass(frozen=True)
class FilterConsistency(Study):
    """Compare errors of adhesion with what the filters claim, under each load and each fault of the type test."""

    write: Annotated[bool, Option("--write", help="Write both tables into docs/faults.md.")] = False
    quick: bool = False

    def page(self, work: Work) -> Page:
        """Return errors by load and consistency by fault; the small form is one rail and one seed."""
        rails, seeds = (SCENARIOS[:1], SEEDS[:1]) if self.quick else (SCENARIOS, SEEDS)
        loads = _cases(rails, LOADS, ("none",), seeds)
        faults = [] if self.quick else _cases(rails, LADEN, FAULTS, seeds[:1])
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
        cases = _cases(("trapezoid",), (0.8,), ("none",), (1,))
        return [
            mean(f"{case.filter}, a fifth lighter: adhesion RMSE", errors.rmse)
            for case, errors in zip(cases, work.map(errors_of, cases), strict=True)
            if case.filter != "disturbed, load ±10 %"
        ]


STUDY = FilterConsistency

LADEN = (0.8, 1.0, 1.05)
"""Loads under which faults are compared: those of the type test."""

_FORMS = {
    "load": "{:.0%}",
    **dict.fromkeys(("α RMSE", "α bias"), "{:.4f}"),
    **dict.fromkeys(("NEES 10 %", "NEES 50 %", "NEES 90 %"), "{:.2g}"),
}


def _answer(results: Results) -> str:
    """Return the median consistency and the error of each filter over all loads."""
    words: list[str] = []
    for name in FILTERS:
        errors_of = [errors for case, errors in results.items() if case.filter == name]
        rmse = float(np.sqrt(np.mean([one.rmse**2 for one in errors_of])))
        words.append(f"{name}: NEES {np.median([one.nees for one in errors_of]):.2g}, RMSE of adhesion {rmse:.4f}")
    return f"Medians over all loads, of which a NEES of 1 is consistent, are {'; '.join(words)}."


def _cases(rails: Sequence[str], loads: Sequence[float], faults: Iterable[str], seeds: Sequence[int]) -> list[Case]:
    return [
        Case(scenario=rail, load=load, fault=fault, filter=name, seed=seed)
        for rail, load, fault, seed, name in product(rails, loads, faults, seeds, FILTERS)
    ]
