"""Count the small defects that the accepted numbers of table 1 notice: one change at a time, then its regression.

Each mutant is a row of mutants.toml: a file, its old text, the new text, and the meaning. It changes a copy of the
sources in build/mutants, never the sources. A constant of the plant is changed as a parameter in the files of
equipment: the same FMU with another value, which saves its compilation. The formation follows, and with it the values
that control laws and predictions derive from it; the declaration in Modelica does not change. All other mutants change
the text that contains the defect. Mutants of equations have a wrong sign or factor, or lack a term: in plant, in
prediction, or in a function that both share; such a function must also fail a test that does not need table 1. Besides
table 1, the accepted responses of the control laws in open loop may notice a mutant, and a stop whose FMU has another
creep curve than its scenario is refused.

Copies stay in build/mutants, and stops of the same sources are not run again.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from fnmatch import fnmatch
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import pandas
import typer

import railgrip
from railgrip.base.errors import FmuError, InputError
from railgrip.campaign.run import find_result, run, write_description
from railgrip.cli.app import Workers
from railgrip.report.baseline import compare, findings_of, load_baseline
from railgrip.report.console import say
from railgrip.report.results import read_results
from railgrip.report.table import ReportTable, write_tables, yes_no
from railgrip.scenario.campaign import load_campaign
from railgrip.simulate.run import run_stop

ROOT = Path(__file__).parents[1]
PLACE = ROOT / "build/mutants"
PACKAGES = ("estimators", "controllers", "fmus", "modelica")
BASELINE = Path("tests/baselines/table1.toml")
DATA = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
MODELICA = ROOT / "modelica/RailBraking"
PAGE = ROOT / "docs/regression.md"

IDEAL = "harness/scenario/equipment/ideal.toml"
SERVICE = "harness/scenario/equipment/service.toml"


@dataclass(frozen=True, slots=True)
class Edit:
    """Replace each occurrence of a text in a file."""

    file: str
    old: str
    new: str

    def apply(self, root: Path) -> None:
        """Apply it to a copy of the sources; if the old text does not exist, the row is wrong."""
        path = root / self.file
        before = path.read_text(encoding="utf-8")
        after = before.replace(self.old, self.new)
        assert after != before, f"{self.file}: '{self.old}' is not there, or is no change"
        path.write_text(after, encoding="utf-8")


@dataclass(frozen=True, slots=True)
class Mutant:
    """A single change: its meaning, and its edits."""

    meaning: str
    edits: tuple[Edit, ...]


def constant(name: str, declared_in: str, factor: float = 1.01, equipment: Sequence[str] = (IDEAL, SERVICE)) -> Mutant:
    """Return a mutant that changes a parameter of the plant, read from its declaration, in files of equipment."""
    text = (MODELICA / f"{declared_in}.mo").read_text(encoding="utf-8")
    found = re.search(rf"\b{name}(?:\([^)]*\))?\s*=\s*(\{{[\d., ]+\}}|[\d.e-]+)", text)
    assert found, f"{declared_in}: {name} has no number"
    values = [float(value) * factor for value in found[1].strip("{}").split(",")]
    value = repr(values) if found[1].startswith("{") else repr(values[0])
    edits = tuple(Edit(file, '\nplant = "', f'\nparameters.{name} = {value}\nplant = "') for file in equipment)
    return Mutant(f"plant: {name} {factor - 1:+.0%}", edits)


def rows(data: Mapping[str, Any]) -> Iterator[Mutant]:
    """Yield the mutants of mutants.toml."""
    for name, declared_in in data["constants"]:
        yield constant(name, declared_in)
    for name, declared_in, factor in data["constants_of_valves"]:
        yield constant(name, declared_in, factor, [SERVICE])
    for meaning, file, old, new in data["edits"]:
        yield Mutant(meaning, (Edit(file, old, new),))
    for meaning, file, old, new in data["equations"]:
        yield Mutant(meaning, (Edit(str((MODELICA / f"{file}.mo").relative_to(ROOT)), old, new),))


def copied(place: Path) -> None:
    """Copy the imported sources, with railgrip next to the files named by a baseline."""
    shutil.rmtree(place / "sources", ignore_errors=True)
    sources = place / "sources"
    skip = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "harness", sources / "harness", ignore=skip)
    (sources / "railgrip").symlink_to("harness")
    for package in PACKAGES:
        shutil.copytree(ROOT / package, sources / package, ignore=skip)
        (sources / "harness" / package).symlink_to(Path("..") / package)
    (sources / BASELINE).parent.mkdir(parents=True)
    shutil.copy(ROOT / BASELINE, sources / BASELINE)


def _folder(mutant: Mutant) -> str:
    return re.sub(r"\W+", "_", mutant.meaning)


def noticed(mutant: Mutant | None, stops: str, *, only_first: bool = False) -> dict[str, str]:
    """Return the rows of the baselines that were not kept, with their states; None means the unchanged sources.

    With `only_first` the stops end with the first that notices.
    """
    name = _folder(mutant) if mutant else "unchanged"
    place = PLACE / name
    copied(place)
    for edit in mutant.edits if mutant else ():
        edit.apply(place / "sources")
    code = "import json, mutants; print(json.dumps(mutants.regression(mutants.Path({!r}), {!r}, only_first={!r})))"
    done = _run_python(place, place / "sources", ["-c", code.format(str(place), stops, only_first)])
    if done.returncode:
        # A copy that does not run yields no verdict on the baselines: the row is wrong.
        raise InputError(f"{name}: {done.stderr[-2000:]}")
    return json.loads(done.stdout.splitlines()[-1])


def _run_python(place: Path, folder: Path, arguments: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Run a process in a folder that imports a copy; it does not use the user's cache for FMUs."""
    # The tests that are copied import modules in the folder `tests`.
    modules = os.pathsep.join(map(str, (place / "sources", ROOT / "tests", ROOT / "tools")))
    environment = os.environ | {"PYTHONPATH": modules, "RAILGRIP_CACHE": str(PLACE / "cache")}
    command = [sys.executable, *arguments]
    return subprocess.run(
        command, env=environment, capture_output=True, text=True, encoding="utf-8", cwd=folder, check=False
    )


def independent_check(mutant: Mutant) -> tuple[str, bool] | None:
    """Run the test that must notice a wrong shared function without table 1.

    Returns the arguments of pytest and whether the test failed, as it should; None for mutants of other files. Call it
    after `noticed`, which makes the copy.
    """
    checks = DATA["checks"]
    file = mutant.edits[0].file.removeprefix("modelica/RailBraking/").removesuffix(".mo")
    if file not in checks:
        return None
    done = run_copied_tests(PLACE / _folder(mutant), checks[file].split())
    assert done.returncode in (0, 1), f"{mutant.meaning}: {checks[file]} does not run: {done.stdout[-2000:]}"
    return checks[file], done.returncode == 1


def run_copied_tests(place: Path, arguments: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Run pytest with arguments in a copy of tests/modelica next to the sources that `copied` has made."""
    tests = place / "sources/tests/modelica"
    shutil.copytree(ROOT / "tests/modelica", tests, dirs_exist_ok=True)
    return _run_python(place, tests, ["-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *arguments])


def regression(place: Path, stops: str, *, only_first: bool) -> dict[str, str]:
    """Run stops with the imported copy of the sources; return name → state of the rows that were not kept."""
    sources = place / "sources"
    assert Path(str(railgrip.__file__)).is_relative_to(sources), f"{railgrip.__file__} is not the copy"
    baseline = load_baseline(sources / BASELINE)
    whole = load_campaign((sources / BASELINE).parent / str(baseline.campaign))
    patterns = stops.split(",")
    some = whole.only(lambda stop: any(fnmatch(stop.name, pattern) for pattern in patterns))
    assert some.stops, f"no stop is named like {stops}"
    some = replace(some, stops=tuple(replace(stop, keep_trace=False) for stop in some.stops))
    folder = place / "stops"
    folder.mkdir(exist_ok=True)
    write_description(some, folder)
    names: set[str] = set()
    moved: dict[str, str] = {}
    # Stops with further figures notice most mutants: with `only_first` the others are seldom needed.
    for stop in sorted(some.stops, key=lambda stop: -len(baseline.accepted[stop.name].figures)):
        if find_result(stop, folder / stop.name) is None:
            try:
                run(stop.scenario, folder / stop.name, run_stop, keep_trace=stop.keep_trace)
            except FmuError:  # the adhesion of the FMU is not that of the scenario's creep curve
                return {stop.name: "refused"}
        names.add(stop.name)
        if only_first or len(names) == len(some.stops):
            comparisons = compare(baseline, findings_of(read_results(folder)))
            moved = {each.name: each.state for each in comparisons if each.name in names and each.state != "kept"}
        if only_first and moved:
            break
    return moved or moved_responses()


def moved_responses() -> dict[str, str]:
    """Return the open-loop responses of control laws that differ from the accepted ones."""
    sys.path.insert(0, str(ROOT / "tests/controllers"))
    responses, approx = import_module("test_law_responses"), import_module("pytest").approx
    accepted = json.loads(responses.ACCEPTED.read_text(encoding="utf-8"))
    present = {name: responses.response(*law) for name, law in responses.LAWS.items()}
    return {name: "moved" for name, values in accepted.items() if present.get(name) != approx(values, rel=1e-6)}


def result_of(mutant: Mutant, stops: str, *, only_first: bool) -> dict[str, Any]:
    """Run a mutant; return its result.

    `kind`: the part of railgrip that contains it; `moved`: accepted stops and responses that changed, with their
    states; `check`, `fails`: test of a shared function and whether it failed, as it should, without one '' and False.
    """
    moved = noticed(mutant, stops, only_first=only_first)
    check, fails = independent_check(mutant) or ("", False)
    return {
        "kind": re.split("[:,]", mutant.meaning)[0],
        "mutant": mutant.meaning,
        "function": Path(mutant.edits[0].file).stem,
        "moved": [f"{name} ({state})" for name, state in moved.items()],
        "check": check,
        "fails": fails,
    }


def write_page(results: pandas.DataFrame) -> None:
    """Write the tables of docs/regression.md."""
    noticed = results["moved"].map(bool)
    missed = results["mutant"].str.partition(": ")[2].where(~noticed)
    by_kind = results.assign(noticed=noticed, missed=missed).groupby("kind", sort=False)
    kinds = by_kind.agg(mutants=("noticed", "size"), noticed=("noticed", "sum"), missed=("missed", _joined))
    kinds.loc["all"] = [len(results), noticed.sum(), ""]
    checks = results.loc[results["check"] != "", ["mutant", "function", "check", "fails"]]
    checks = checks.assign(check="`" + checks["check"] + "`", fails=checks["fails"].map(yes_no))
    columns = {"kind": "mutant in", "missed": "not noticed"}
    tables = {
        "mutants": ReportTable.of_frame(kinds.reset_index().rename(columns=columns), left=("mutant in",)),
        "checks": ReportTable.of_frame(checks.rename(columns={"check": "independent test"}), left=_CHECKED),
    }
    write_tables(PAGE, tables)


_CHECKED = ("mutant", "function", "independent test", "fails")


def _joined(texts: Iterable[Any]) -> str:
    return "; ".join(text for text in texts if isinstance(text, str))


def mutants(
    stops: Annotated[str, typer.Option(metavar="PATTERNS", help="Patterns of names of stops, with commas.")] = "*",
    only: Annotated[str, typer.Option(help="Only mutants whose meaning contains this.")] = "",
    first: Annotated[bool, typer.Option("--first", help="End a mutant with the first stop that notices it.")] = False,
    write: Annotated[bool, typer.Option("--write", help="Write the tables of docs/regression.md.")] = False,
    workers: Workers = 2,
) -> None:
    """Count the small defects that the regression notices."""
    if states := noticed(None, stops):
        raise InputError(f"without any mutant the regression says {states}: accept or correct that first")
    chosen = [mutant for mutant in rows(DATA) if only in mutant.meaning]
    results: list[dict[str, Any]] = []
    with ThreadPoolExecutor(workers) as pool:
        for one in pool.map(partial(result_of, stops=stops, only_first=first), chosen):
            results.append(one)
            check = one["check"] and f"; {one['check']}: {'fails' if one['fails'] else 'PASSES'}"
            say(f"{one['mutant']:55}  {len(one['moved']):2}  {', '.join(one['moved']) or '—'}{check}")
    say(f"{sum(bool(one['moved']) for one in results)} of {len(results)} mutants were noticed")
    if write:
        write_page(pandas.DataFrame(results))
