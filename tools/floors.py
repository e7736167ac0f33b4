"""Divide the tests in two floors: the cheapest that run every line and branch that all of them run, and the rest.

`make test` runs all tests but those in tests/left_out.toml, which `make test-all` runs. So a new test decides until it
has been measured, and so do the tests that notice mutants (tools/mutants.py) together with the regression.
What `make test` runs besides tests, the FMUs of the recipes and the regression, needs no test to run it again.
"""

import ast
import heapq
import json
import os
import re
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

import typer

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
    subprocess.run(
        [sys.executable, *command], cwd=ROOT, check=False,
        env=os.environ | {"COVERAGE_PROCESS_START": str(settings), "COVERAGE_PLACE": str(folder), "COVERAGE_TEST": test,
                          "RAILGRIP_CACHE": str(PLACE / "cache"), "PYTHONPATH": str(ROOT / "tools")},
    )  # fmt: skip


def measure_all(files: Sequence[Path], *, regression: bool) -> None:
    """Measure test files, those of a folder in one process, and the regression if required."""
    if regression:
        measure(
            REGRESSION,
            ["-m", "railgrip", "maintain", "regress", "--workers", "1", "--import-from", "docs/studies"],
            test=REGRESSION,
        )
    for folder, group in groupby(files, lambda file: file.parent):
        names = [str(file.relative_to(ROOT)) for file in group]
        whole = len(names) == len([*folder.glob("test_*.py")])
        name = str(folder.relative_to(ROOT)) if whole else names[0]
        measure(name, ["-m", "pytest", "-n0", "-q", "-p", "measured_tests", "-p", "no:cacheprovider", *names])


def lines_in_functions(path: str) -> set[int]:
    """Return the lines of a module that run when its functions are called: the others run whenever it is imported."""
    return {
        line
        for node in ast.walk(ast.parse(Path(path).read_bytes()))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        for line in range(node.body[0].lineno, (node.end_lineno or 0) + 1)
    }


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


def read(place: Path) -> tuple[dict[str, float], dict[str, int]]:
    """Return the processor time of each measured test [s], and what each ran: a bit for each line and branch."""
    lines = (line for file in sorted(place.glob("*/seconds.jsonl")) for line in file.open(encoding="utf-8"))
    seconds = {test: time for test, time in map(json.loads, lines) if exists(test)}
    bits: dict[tuple[str, int, int], int] = {}
    inside: dict[str, set[int]] = {}
    ran: dict[str, set[int]] = defaultdict(set)
    for file in sorted(place.glob("*/data.*")):
        # A process that a test kills leaves a file in part.
        with suppress(sqlite3.DatabaseError), sqlite3.connect(file) as data:
            rows = data.execute(
                "select context, path, fromno, tono from arc join context on context.id = context_id"
                " join file on file.id = file_id where context != '' and path like '%.py'"
            )
            for test, path, start, end in rows:
                if test not in seconds and test != REGRESSION:
                    continue
                if path not in inside:
                    inside[path] = lines_in_functions(path)
                if max(abs(start), abs(end)) in inside[path] or min(start, end) in inside[path]:
                    ran[test].add(bits.setdefault((path, start, end), len(bits)))
    return seconds, {test: sum_of(found) for test, found in ran.items()}


def sum_of(bits: set[int]) -> int:
    """Return the number in which these bits are set."""
    field = bytearray(max(bits) // 8 + 1)
    for bit in bits:
        field[bit // 8] |= 1 << bit % 8
    return int.from_bytes(field, "little")


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


def choose(seconds: dict[str, float], ran: dict[str, int]) -> tuple[set[str], set[str]]:
    """Return the units that decide, chosen by what each adds in a second, and all units.

    The greedy choice costs at most a logarithm of the size more than the best one (Chvátal, 1979); units that later
    ones have made redundant go.
    """
    whole = units(seconds)
    cost: dict[str, float] = defaultdict(lambda: 1e-3)
    has: dict[str, int] = defaultdict(int)
    for test, unit in whole.items():
        cost[unit] += seconds[test]
        has[unit] |= ran.get(test, 0)
    chosen = [unit for test, unit in whole.items() if required(test)]
    covered = ran.get(REGRESSION, 0)
    for unit in chosen:
        covered |= has[unit]
    heap = [(-has[unit].bit_count() / cost[unit], unit) for unit in cost if unit not in chosen]
    heapq.heapify(heap)
    while heap:
        _, unit = heapq.heappop(heap)
        gain = -(has[unit] & ~covered).bit_count() / cost[unit]
        if heap and gain > heap[0][0]:
            heapq.heappush(heap, (gain, unit))
        elif gain:
            chosen.append(unit)
            covered |= has[unit]
    kept = dict.fromkeys(chosen)
    for unit in sorted(kept, key=lambda unit: -cost[unit]):
        others = ran.get(REGRESSION, 0)
        for other in kept:
            others |= has[other] if other != unit else 0
        if not has[unit] & ~others and not required(unit):
            del kept[unit]
    by_regression = ran.get(REGRESSION, 0).bit_count()
    say(f"{covered.bit_count()} lines and branches, of which the regression runs {by_regression}")
    say(f"{len(kept)} of {len(cost)} tests decide: {sum(cost[one] for one in kept):.0f} of {sum(cost.values()):.0f} s")
    return set(kept), set(cost)


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
