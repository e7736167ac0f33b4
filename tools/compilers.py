"""What each compiler covers, takes and needs: the table of docs/how_to/compilers.md."""

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import pandas
from suites import counts

from railgrip.base.cache import VARIABLE
from railgrip.campaign.workers import environment
from railgrip.fmi.description import describe
from railgrip.fmus.build import Compiler, build_one
from railgrip.fmus.openmodelica import REQUIRED, TOLERANCE, version_line
from railgrip.fmus.recipe import read_recipes
from railgrip.report.table import ReportTable
from railgrip.studies.bench import plant_step

SUITES: Final = {
    "compliance": "Modelica compliance library",
    "omc": "OpenModelica's tests",
    "reference": "examples of the Modelica Standard Library with published results",
}
"""Kind of `make suites` → its name in the table."""
PLANTS: Final = ("TwoPartTrain", "TwoPartTrainPneumatic")
"""Recipes whose build and step are measured: without events, and with valves, whose dead times are events."""
INPUTS: Final = {"pressure_command": 2.5e5, "valve_command": 1.0, "mu0": 0.3}
"""A service braking without slides [Pa, 1, 1]; each plant has one of the two commands."""


def compare(suites: Path, compilers: Sequence[Compiler]) -> ReportTable:
    """Return a row for each property of the compilers and a column for each of them.

    Args:
        suites: Folder of the CSV files of `make suites`; a suite without a file is left out.
        compilers: native, openmodelica or both.
    """
    names = {"native": "built-in compiler", "openmodelica": "OpenModelica"}
    columns = {names[one]: coverage(suites, one) | durations(one) | properties(one) for one in compilers}
    what = dict.fromkeys(row for column in columns.values() for row in column)
    rows = [{"": row} | {name: column.get(row) for name, column in columns.items()} for row in what]
    return ReportTable(rows, left=("", *columns))


def coverage(suites: Path, compiler: Compiler) -> dict[str, str]:
    """Return the number of classes of each verdict for each suite, legal and illegal classes apart."""
    found: dict[str, str] = {}
    for kind, name in SUITES.items():
        file = suites / f"{kind}-{compiler}.csv"
        if not file.is_file():
            continue
        for what, verdicts in counts(pandas.read_csv(file)).items():
            texts = [f"{count} {verdict}" for verdict, count in verdicts.most_common()]
            texts += ["0 wrong"] * (what == "legal" and compiler == "native" and "wrong" not in verdicts)
            found[f"{name}, {verdicts.total()} {what} classes"] = ", ".join(texts)
    return found


def durations(compiler: Compiler) -> dict[str, str]:
    """Return processor times of builds from an empty cache, and of a step of 1 ms of their FMUs."""
    builds: dict[str, str] = {}
    steps: dict[str, str] = {}
    with tempfile.TemporaryDirectory() as folder, environment({VARIABLE: f"{folder}/cache"}):
        for name, which in zip(PLANTS, ("the first", "one more"), strict=True):
            begin = sum(os.times()[:4])
            file = build_one(name, compiler).path
            builds[f"build of {which} plant, {name}"] = f"{sum(os.times()[:4]) - begin:.1f} s of processor time"
            steps[f"step of 1 ms, {name}"] = f"{plant_step(describe(file), INPUTS):.0f} µs"
    return builds | steps


def properties(compiler: Compiler) -> dict[str, str]:
    """Return solver and tolerance of the plants' FMUs, what a build needs, and the version."""
    recipe = read_recipes()[PLANTS[0]]
    if compiler == "native":
        solver, tolerance = f"Rosenbrock, {recipe.solver}", f"{recipe.tolerance:.0e}, the parameter `_tolerance`"
        needs, version = "a C compiler, or the extra `compiler`", "part of railgrip"
    else:
        solver, tolerance = "CVODE", f"{TOLERANCE:.0e}, fixed in the FMU"
        needs, version = f"`omc`, a C compiler, {', '.join(f'`{one}`' for one in REQUIRED)}", version_line()
    return {"solver of a plant": solver, "its tolerance": tolerance, "a build needs": needs, "version": version}
