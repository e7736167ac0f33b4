"""Divide the tests in two floors: the cheapest that run every line and branch that all of them run, and the rest.

`make test` runs all tests but those in tests/left_out.toml, which `make test-all` runs. So a new test decides until it
has been measured, and so do the tests that notice mutants (tools/mutants.py) together with the regression.
What `make test` runs besides tests, the FMUs of the recipes and the regression, needs no test to run it again.
"""

import ast
import json
import os
import re
import shutil
import sqlite3
import subprocess
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from coverage import Coverage
from coverage.python import PythonFileReporter
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_array

from railgrip.base.arrays import Mask
from railgrip.base.files import write_text
from railgrip.report.console import say

ROOT = Path(__file__).parents[1]
PLACE = ROOT / "build/coverage"
FILE = ROOT / "tests/left_out.toml"
PACKAGES = ("harness", "estimators", "controllers", "fmus", "tools")
REGRESSION = "make test"
REPOSITORY = (
    *(f"tests/test_{name}.py" for name in ("conventions", "floors", "makefile", "mutants_apply")),
    "tests/docs/test_site.py::test_every_file_named_on_the_architecture_page_exists",
    "tests/report/test_common_stops.py::test_no_function_compares_entrants_without_selecting_common_stops",
)
EXPENSIVE = 3.0
"""Processor time of a parametrised test [s] from which on its cases are chosen one by one."""
SETTINGS = f"""[run]
branch = true
parallel = true
data_file = ${{COVERAGE_PLACE}}/data
context = ${{COVERAGE_TEST-}}
concurrency = multiprocessing,thread
patch = _exit
sigterm = true
disable_warnings = no-data-collected,module-not-measured,module-not-imported,couldnt-parse,already-imported
source = {",".join(str(ROOT / package) for package in PACKAGES)}
"""


def measure(name: str, command: Sequence[str], test: str = "") -> None:
    """Run Python with arguments; keep what it runs in a folder of this name instead of an earlier measurement."""
    folder = PLACE / name.replace("/", "-")
    folder.mkdir(parents=True, exist_ok=True)
    for file in folder.iterdir():
        file.unlink()
    settings = PLACE / "settings"
    settings.write_text(SETTINGS, encoding="utf-8")
    say(f"measuring {name}")
    path = os.pathsep.join(str(ROOT / place) for place in ("tools", "tests"))
    subprocess.run(
        [sys.executable, *command], cwd=ROOT, check=False,
        env=os.environ | {"COVERAGE_PROCESS_START": str(settings), "COVERAGE_PLACE": str(folder), "COVERAGE_TEST": test,
                          "RAILGRIP_CACHE": str(PLACE / "cache"), "PYTHONPATH": path},
    )  # fmt: skip


def measure_all(files: Sequence[Path], *, regression: bool) -> None:
    """Measure test files, those of a folder in one process, and the regression if required."""
    if regression:
        shutil.rmtree(PLACE / "cache", ignore_errors=True)  # as on a new machine, FMUs are built from nothing
        measure("make fmus", ["-m", "railgrip", "build"], test=REGRESSION)
        # In one process: a pool ends its workers before coverage.py has written what they ran.
        words = ["maintain", "regress", "--workers", "1", "--import-from", "docs/studies"]
        program = "from one_process import one_process\nfrom railgrip.__main__ import main\n"
        measure(REGRESSION, ["-c", f"{program}with one_process(): main({words})"], test=REGRESSION)
    for folder, group in groupby(files, lambda file: file.parent):
        names = [str(file.relative_to(ROOT)) for file in group]
        whole = len(names) == len([*folder.glob("test_*.py")])
        name = str(folder.relative_to(ROOT)) if whole else names[0]
        measure(name, ["-m", "pytest", "-n0", "-q", "-p", "measured_tests", "-p", "no:cacheprovider", *names])


@cache
def module(path: str) -> tuple[PythonFileReporter, set[int], set[tuple[int, int]]]:
    """Return coverage's reporter of a module, its lines that run when its functions are called, and its branches.

    The other lines run whenever the module is imported.
    """
    reporter = PythonFileReporter(path, Coverage(data_file=None))
    inside = {
        line
        for node in ast.walk(ast.parse(Path(path).read_bytes()))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        for line in range(node.body[0].lineno, (node.end_lineno or 0) + 1)
    }
    exits = reporter.exit_counts()
    return reporter, reporter.lines() & inside, {arc for arc in reporter.arcs() if exits.get(arc[0], 0) > 1}


@cache
def ran_by(path: str, start: int, end: int) -> list[tuple[str, int, int]]:
    """Return the lines in functions, and the branch, that a step from one line of a module to another runs."""
    reporter, lines, branches = module(path)
    run = reporter.translate_lines({line for line in (start, end) if line > 0}) & lines
    found = [(path, line, line) for line in run]
    return found + [(path, *arc) for arc in reporter.translate_arcs({(start, end)}) if arc in branches]


@cache
def tests_in(file: str) -> set[str]:
    """Return the names of the tests in a file, which may be gone."""
    path = ROOT / file
    return (
        set(re.findall(r"^def (test_\w+)", path.read_text(encoding="utf-8"), re.MULTILINE)) if path.exists() else set()
    )


def exists(test: str) -> bool:
    """Return whether a test that was once measured is still there."""
    file, _, name = test.partition("[")[0].partition("::")
    return name in tests_in(file)


def read(place: Path) -> tuple[dict[str, float], dict[str, set[int]]]:
    """Return the processor time of each measured test [s], and the numbers of the lines and branches that each ran."""
    lines = (line for file in sorted(place.glob("*/seconds.jsonl")) for line in file.open(encoding="utf-8"))
    seconds = {test: time for test, time in map(json.loads, lines) if exists(test)}
    bits: dict[tuple[str, int, int], int] = {}
    ran: dict[str, set[int]] = defaultdict(set)
    for file in sorted(place.glob("*/data.*")):
        # A process that a test kills leaves a file in part.
        with suppress(sqlite3.DatabaseError), sqlite3.connect(file) as data:
            rows = data.execute(
                "select context, path, fromno, tono from arc join context on context.id = context_id"
                " join file on file.id = file_id where context != '' and path like '%.py'"
            )
            for test, *step in rows:
                if test in seconds or test == REGRESSION:
                    ran[test].update(bits.setdefault(one, len(bits)) for one in ran_by(*step))
    return seconds, ran


def units(seconds: dict[str, float]) -> dict[str, str]:
    """Return for each measured test what is chosen as a whole: its function, or itself if its function is expensive."""
    of_function: dict[str, float] = defaultdict(float)
    for test, time in seconds.items():
        of_function[test.partition("[")[0]] += time
    return {
        test: test if of_function[name] > EXPENSIVE else name for test in seconds for name in [test.partition("[")[0]]
    }


def required(test: str) -> bool:
    """Return whether a test must notice mutants: wrong control laws, or functions that plant and prediction share.

    So must those which read the files of the repository and run none of its lines: no other test notices what they do.
    """
    if test.startswith(("tests/controllers/test_law_responses.py", *REPOSITORY)):
        return True
    return any(test.startswith(f"tests/modelica/{file}") and word in test for file, _, word in checks_of_mutants())


@cache
def checks_of_mutants() -> list[tuple[str, str, str]]:
    """Return file, option and word of each independent test of shared functions."""
    checks = tomllib.loads((ROOT / "tools/mutants.toml").read_text(encoding="utf-8"))["checks"].values()
    return [check.partition(" -k ") for check in checks]


def choose(seconds: dict[str, float], ran: dict[str, set[int]]) -> tuple[set[str], set[str]]:
    """Return the units that decide, and all units.

    Those that decide run all lines and branches, and cost at most half a percent more than the cheapest that do.
    """
    cost: dict[str, float] = defaultdict(lambda: 1e-3)
    has: dict[str, set[int]] = defaultdict(set)
    for test, unit in units(seconds).items():
        cost[unit] += seconds[test]
        has[unit] |= ran.get(test, set())
    names = [*cost]
    is_required = np.array([required(unit) for unit in names])
    runs = np.zeros((len(names), 1 + max(map(max, filter(None, ran.values())), default=0)), dtype=np.bool_)
    for row, unit in enumerate(names):
        runs[row, [*has[unit]]] = True
    once = np.zeros(runs.shape[1], dtype=np.bool_)
    once[[*ran.get(REGRESSION, ())]] = True
    once |= runs[is_required].any(axis=0)
    by_units = _distinct(runs[:, runs.any(axis=0) & ~once])
    prices = np.array([*cost.values()])
    chosen = milp(
        prices, integrality=np.ones(len(names)), bounds=Bounds(0, 1), options={"mip_rel_gap": 0.005, "time_limit": 600},
        constraints=LinearConstraint(csr_array(by_units.T.astype(float)), lb=1),
    )  # fmt: skip
    assert chosen.x is not None, chosen.message
    decides = is_required | (chosen.x > 0.5)
    by_regression = len(ran.get(REGRESSION, ()))
    say(f"{(once | runs.any(axis=0)).sum()} lines and branches, of which the regression runs {by_regression}")
    say(f"{decides.sum()} of {len(names)} tests decide: {prices[decides].sum():.0f} of {prices.sum():.0f} s")
    return {name for name, one in zip(names, decides, strict=True) if one}, set(names)


def _distinct(columns: Mask) -> Mask:
    """Return each different column once: lines that the same tests run need one of them."""
    packed = np.unique(np.packbits(columns, axis=0), axis=1)
    return np.unpackbits(packed, axis=0, count=len(columns)).astype(np.bool_)


def text_of(left_out: set[str]) -> Iterator[str]:
    """Yield the lines of the file."""
    yield "# Tests that `make test` leaves out: others run all of their lines and branches; written by `make floors`."
    for file, tests in groupby(sorted(left_out), lambda test: test.partition("::")[0]):
        yield f'"{file}" = ['
        yield from (f"  {json.dumps(test.partition('::')[2], ensure_ascii=False)}," for test in tests)
        yield "]"


def floors(
    paths: Annotated[list[Path] | None, typer.Argument(help="Folders or files of tests; all unless given.")] = None,
    out: Annotated[Path, typer.Option(help="File of the tests that are left out.")] = FILE,
) -> None:
    """Measure what tests run, and choose those that decide.

    With paths only these are measured again, and the file is written from all that were ever measured.
    """
    places = [path.resolve() for path in paths or [ROOT / "tests"]]
    files = sorted(file for path in places for file in ([path] if path.is_file() else path.rglob("test_*.py")))
    measure_all(files, regression=not paths)
    kept, all_ = choose(*read(PLACE))
    write_text(out, "\n".join(text_of(all_ - kept)) + "\n")
