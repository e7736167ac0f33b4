"""Every command, option, study and target of the Makefile runs to its end in its smallest form.

Commands and options are those of the command line itself, targets those of `make help`; each needs a row here. A line
with the processor time of each row is printed at the end: `pytest tests/cli/test_every_command.py -s`.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from command_line import done
from commands import tools
from one_process import one_process
from project_files import ROOT
from test_suites import write_library
from typer.main import get_command

from railgrip.cli.app import app, command_of
from railgrip.fmus.recipe import write_lock

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="make and links to an environment")

OF_ALL = {"--version", "--quiet", "--verbose"}
"""Options of every command, which tests/cli/test_commands.py tests."""

OF_STUDIES = "--workers 1 --format svg --fresh --out"
NEW = "harness/scenario/campaigns"

COMMANDS = {
    "--version": "railgrip 0",
    "--quiet --verbose list trains": "emu387",
    "run trapezoid --with service --set start.speed=15 --import-from . --out out/stops/run --json": '"standstill"',
    "campaign table1 --only scenario=trapezoid --only controller=slip_two_state,full_brake --set start.speed=5"
    " --out out/campaign --workers 1 --fresh --panels none --format svg --import-from . --against slip_two_state":
        "out/campaign/index.html",
    "report out/campaign --panels none --format svg --against full_brake": "out/campaign/index.html",
    "report out/campaign --write own.md": "own.md: campaign, distances",
    "compare out/stops/run out/campaign/trapezoid-ideal-full_brake --out out/compare --format svg":
        "out/compare/index.html",
    "compare out/stops/run out/campaign/trapezoid-ideal-full_brake --json": "{",
    "table out/stops/run --out out/run.csv": "out/run.csv",
    "list trains --json": '"emu387"',
    "new scenario out/own.toml": "out/own.toml",
    "new regression own/stops.toml --workflow": "own/stops.toml",
    "schema train": '"properties"',
    "train show emu387 --out out/emu387.svg": "out/emu387.svg",
    "train check emu387 --json": '"findings"',
    "train calculate emu387 --speed '80 km/h' --step '40 km/h' --draws 2 --seed 2 --json": "{",
    "train calculate emu387 --speed '80 km/h' --out out/calculated": "out/calculated/calculation.pdf",
    "build TwoPartTrain --compiler native": "build/fmus/TwoPartTrain.fmu",
    "build Own --library own.mo --out out/own/Own.fmu": "out/own/Own.fmu",
    "build --list": "TwoPartTrain",
    "build TwoPartTrain --check": "1 FMUs are valid and match lock.toml",
    "build --check --update": "lock.toml written",
    "map build/fmus/TwoPartTrain.fmu --speed 5 --wheelsets-of-group 1 --wheelsets-of-group 1 --wheelsets-of-group 1"
    " --wheelsets-of-group 1 --period 0.001": "[vehicle.formation]",
    "export trapezoid --with service --set estimator.kind=none --set controller.kind=slip_two_state --part controller"
    " --fmi 3 --out out/law.fmu": "out/law.fmu",
    "export plain --library --out out/library --import-from .": "out/library/plain_onboard.h",
    "export plain --ssp out/plain.ssp": "out/plain.ssp",
    "export plain --page out/plain.html": "out/plain.html",
    "inspect out/run.csv --for stop --time 'time [s]' --decimal . --order day-first --out out/stop.toml":
        "out/stop.toml",
    "inspect out/run.csv --for train --train emu387 --json": '"proposal"',
    "estimate rig_own --set name=own --scenario rig_slide --seed 2 --import-from . --out out/estimate --json": "{",
    "estimate train --train vt642 --data out/stops/run/trace.nc --out out/train": "out/train/index.html",
    "observability rig_own --set name=own --scenario rig_slide --seed 2 --import-from . --out out/observability":
        "out/observability/observability.csv",
    "run rig_slide --out out/rig": "out/rig/stop.json",
    "observability rig_own --data out/rig/trace.nc --out out/observed": "out/observed/observability.csv",
    "monitor out/stops --out out/monitor.png": "out/monitor.png",
    "doctor": "C compiler",
    "tools conditioning one.toml --repeats 2 --relative 1e-6 --lots 0 --stops plain-sbc --out out/conditioning"
    " --workers 1 --fresh": "one.conditioning.json",
    "tools discretisation one.toml --repeats 1 --stops plain-sbc --only steps --workers 1 --fresh": "one.cond",
    "tools validation --baselines tests/baselines --docs docs": "docs/validation.md",
    "tools fmus out/own --out out/fmus.csv --write": "out/fmus.csv",
    "tools sizes --write": "casadi",
    "tools pages two_maxima --anew --quick": "build/studies/two_maxima/two_maxima_1.svg",
    "tools compilers --suites out": "built-in compiler",
    "maintain regress --baselines small --out out/regress --workers 1 --import-from . --json": "small/etcs.toml",
    "maintain regress --baselines small --out out/regress --workers 1 --junit out/junit.xml": "out/junit.xml",
    "maintain accept --reason R --baselines small --out out/regress": "nothing changed",
    "study": "type_test",
    "study benefit vt642 --quick": "gains.csv",
    "study benefit vt642 --measures sand --line leaves --controller slip_two_state --draws 2 --write": "gains.csv",
    "study estimators --estimator constant --train vt642 --cases 2 --sealed": "index.html",
    "study estimators --estimator constant --quick": "index.html",
    "study etcs emu387 --write": "limits.csv",
    "study etcs emu387 --quick": "limits.csv",
    "study k_factors vt642 --quick": "k_factors.json",
    "study pad_monitor --quick": "index.html",
    "study stop_at_target --draws 1 --sets 0 --write": "errors.csv",
    "study stop_at_target --quick": "errors.csv",
    "study type_test --validation --cases 1 --controller full_brake --limits harness/report/library/limits.toml"
    " --import-from .": "index.html",
    "study type_test --quick --controller slip_two_state": "index.html",
    "study type_test --sealed --version 2 --cases 1 --controller full_brake": "index.html",
}  # fmt: skip
"""Command → a file that it writes, for a study in its folder, or a text that it prints."""

ONE = "--workers 1 --only controller=slip_two_state"
SEARCH = "--population 8 --generations 1 --stage 1 --seed 2 --workers 1 --import-from ."
MAKE = {
    "help": "list the targets",
    "install": "Nothing to be done",
    f"simulate PUBLISHED= OPTIONS='{ONE} --only scenario=trapezoid'": "build/table1/index.html",
    f"unseen OPTIONS='{ONE} --only draw=1'": "build/unseen/index.html",
    f"adverse OPTIONS='{ONE} --only case=soap'": "build/adverse/index.html",
    f"report OPTIONS='{ONE} --only scenario=trapezoid --panels none'": "build/shapes/index.html",
    """headlines REASON=R BASELINES=small OPTIONS="--workers 1 --repeats 2 --stops 'trapezoid-[iw]*-*_two_state'" """:
        "docs/validation.md",
    """convergence OPTIONS="--workers 1 --repeats 2 --stops '*-simple-*full_brake'" """: "docs/validation.md",
    "validation": "docs/validation.md",
    "regress-long BASELINES=small": "build/regress-long/etcs",
    "calibrate OPTIONS='--scenario trapezoid --out out/levels'": "out/levels/trapezoid.toml",
    "tune-control OPTIONS='--law slip_three_state --cases 1 --version 2 --budget 5 --workers 1 --out out'":
        "out/slip_three_state.type_test_2.toml",
    f"tune OPTIONS='{SEARCH} --campaign {NEW}/field_test.toml'":
        "harness/estimation/field_test/library/consistent.toml",
    f"type-test OPTIONS='--version 2 --cases 24 --shipped --against slip_two_state --write {OF_STUDIES} out/type_test'":
        "out/type_test/version_2/index.html",
    "trains OPTIONS=--quick": "build/studies/trains/trains.md",
    f"bench OPTIONS='--quick {OF_STUDIES} out/bench'": "out/bench/quick/durations.csv",
    "lateral OPTIONS=--quick": "build/studies/lateral/lateral.md",
    "learn OPTIONS=--quick": "build/axle_box/quick/friction.json",
    f"monitor OPTIONS='--seeds 1 --stops 40 --pressure-offset 4000 {OF_STUDIES} out/pads'": "out/pads/index.html",
    "k-factors OPTIONS='--set estimate.samples=20 --set estimate.runs=2 --set loop.samples=20 --set loop.runs=2"
    f" --import-from . --write {OF_STUDIES} out/k_factors'": "out/k_factors/k_factors.json",
    "estimate OPTIONS=--quick": "build/estimate/wagon-relaxing/index.html",
    "mutants OPTIONS='--stops trapezoid-ideal-slip_two_state --only A_piston --workers 1'":
        "1 of 1 mutants were noticed",
    "test TESTS=tests/test_units.py BASELINES=small": "processor time: ",
    "test-all TESTS=tests/scenario/test_quantities.py TYPES=harness/base/units.py": "processor time: ",
    "floors TESTS=tests/test_units.py OPTIONS='--out out/left_out.toml'": "out/left_out.toml",
    "portable TESTS=tests/test_units.py": "build/portable/stop.json",
    "fuzz TESTS=tests/test_units.py": " passed",
    "conditioning-omc OPTIONS='--workers 1'": "conditioning-omc needs OpenModelica's omc on the PATH",
    "test-omc TESTS=tests/test_units.py": "test-omc needs OpenModelica's omc on the PATH",
    "regress-omc BASELINES=small": "regress-omc needs OpenModelica's omc on the PATH",
    "suites SUITE=suite KIND=compliance OPTIONS='--only Right --seconds 60 --control --compiler native --out s.csv'":
        "s.csv",
    "clean": "rm -rf build",
}  # fmt: skip
"""Arguments of make → a file that it writes, or a text that it prints; without OpenModelica, so that all can run it."""

MINUTES = {
    "study benefit vt642 --quick", "study type_test --quick --controller slip_two_state",
    "tune", "type-test", "trains", "bench", "lateral", "learn", "monitor", "k-factors", "estimate", "mutants", "test",
    "floors", "portable",
}  # fmt: skip
"""Rows and targets that take half a minute or more in their smallest form, which `make fuzz` runs."""

ELSEWHERE = {
    "docs": "docs/test_site.py",
    "target": "stops/test_exported_library.py",
    "tools target": "stops/test_exported_library.py",
    "--show-completion": "cli/test_commands.py",
    "--install-completion": "cli/test_commands.py",
    "ride": "learned/test_rides.py",
    "campaign --scheduler": "cli/test_cluster.py",
    "monitor --map": "estimate/test_monitor_folder.py",
    "export --platforms": "fmus/test_under_wine.py",
    "maintain regress --across-compilers": "cli/test_regression.py",
    "tools conditioning --import-from": "test_own_classes.py",
    "tools compilers --write": "test_suites.py",
    "tools suites --library": "test_suites.py",
    "tools validation --openmodelica": "report/test_baselines.py",
    "study etcs --line": "etcs/test_etcs_command.py",
    "study etcs --national": "etcs/test_etcs_command.py",
    "study estimators --tune": "estimators/test_estimator_study.py",
    "study type_test --train": "type_test/test_type_test_command.py",
    "study type_test --task": "type_test/test_type_test_command.py",
    "study type_test --case": "type_test/test_type_test_command.py",
}
"""Target, command or option → the test that runs it."""

WHOLE = {
    "--write": ("estimators",),
    "--loop": ("estimators",),
}  # fmt: skip
"""Options of studies that take minutes in any form, and are not run here: they write the numbers of the whole study."""


# Without the variables of a `make test` that runs this test, and without OpenModelica.
ENVIRONMENT = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))} | {
    "PATH": os.pathsep.join(part for part in os.environ["PATH"].split(os.pathsep) if not Path(part, "omc").exists())
}


def tree(command: Any, *path: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield path and object of a command and of all commands in it."""
    yield path, command
    for name in command.list_commands(None) if hasattr(command, "list_commands") else ():
        yield from tree(command.get_command(None, name), *path, name)


ALL = dict(tree(get_command(app))) | dict(tree(command_of("tools", tools), "tools"))


def words_of(row: str) -> tuple[tuple[str, ...], list[str]]:
    """Return the path of the command in a row, and its options."""
    words = shlex.split(row)
    path = next(tuple(words[:n]) for n in (2, 1, 0) if tuple(words[:n]) in ALL)
    return path, [word for word in words if word.startswith("--")]


def options_of(path: tuple[str, ...]) -> list[list[str]]:
    """Return the names of each option of a command, without those of all commands."""
    return [p.opts for p in ALL[path].params if p.opts[0].startswith("--") and not (path and OF_ALL & {*p.opts})]


def elsewhere(what: str) -> bool:
    """Return whether another test, which has the words, runs a target, a command or an option."""
    file = ELSEWHERE.get(what)
    if file is None:
        return False
    path = ROOT / "tests" / file
    inputs = path.with_name("tables.toml")
    text = path.read_text(encoding="utf-8") + (inputs.read_text(encoding="utf-8") if inputs.is_file() else "")
    return all(word in text for word in what.split())


def of_make(row: str) -> list[str]:
    """Return the commands that make would run."""
    command = ["make", "--dry-run", "--always-make", *shlex.split(row), f"VENV={sys.prefix}"]
    lines = subprocess.run(command, cwd=ROOT, env=ENVIRONMENT, capture_output=True, text=True, check=True).stdout
    return lines.replace("\\\n", " ").splitlines()


def targets() -> dict[str, str]:
    """Return the targets that `make help` lists, and their explanations."""
    lines = subprocess.run(["make", "help"], cwd=ROOT, env=ENVIRONMENT, capture_output=True, text=True, check=True)
    return dict(line.split("\t", 1) for line in lines.stdout.splitlines() if "\t" in line)


def test_each_command_and_each_option_has_a_row() -> None:
    rows = list(COMMANDS)
    rows += re.findall(
        r"bin/(?:railgrip|python(?= tools )) (.*)", "\n".join(line for row in MAKE for line in of_make(row))
    )
    used: dict[tuple[str, ...], set[str]] = {}
    for row in rows:
        path, options = words_of(re.split(r" &|;", row)[0])
        used.setdefault(path, set()).update(options)
        if path[:1] == ("study",) and len(path) == 2:
            # tests/cli/test_cluster.py has --scheduler, which is one option for all studies.
            used[path].update(re.findall(r"--\w+", f"{OF_STUDIES} --scheduler"))
    missing = [
        " ".join(path)
        for path, command in ALL.items()
        if not hasattr(command, "list_commands") and path not in used and not elsewhere(" ".join(path))
    ]
    missing += [
        " ".join((*path, option))
        for path in used
        for option, *others in options_of(path)
        if not used[path].intersection((option, *others))
        and not elsewhere(" ".join((*path, option)))
        and path[-1] not in WHOLE.get(option, ())
    ]
    assert not missing, f"add a row with its smallest form, or the test that runs it: {', '.join(missing)}"
    unknown = [
        " ".join((*path, option))
        for path, options in used.items()
        for option in options - {"--quick"} - {name for p in ALL[path].params for name in (*p.opts, *p.secondary_opts)}
    ]
    assert not unknown, f"there is no such command or option; correct the row: {', '.join(unknown)}"


def test_each_target_of_make_help_has_a_row() -> None:
    run = {shlex.split(row)[0]: set(of_make(row)) for row in MAKE}
    listed = targets()
    assert not run.keys() - listed.keys(), "there is no such target in `make help`; correct the row"
    for target in listed.keys() - run.keys() - ELSEWHERE.keys():
        # A prerequisite runs with the target that needs it.
        assert any(set(of_make(f"{target} {row.partition(' ')[2]}")) <= run[row.split()[0]] for row in MAKE), (
            f"add a row for `make {target}` in its smallest form"
        )


def test_each_row_elsewhere_is_true() -> None:
    assert [what for what in ELSEWHERE if not elsewhere(what)] == []


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the project, in which commands may write, with an environment that make takes for its own."""
    folder = tmp_path_factory.mktemp("every") / "a project"
    skip = shutil.ignore_patterns(".git", ".venv*", "build", "__pycache__", ".*_cache", ".hypothesis")
    shutil.copytree(ROOT, folder, ignore=skip)
    (folder / "venv").mkdir()
    for place in Path(sys.prefix).iterdir():
        if not place.name.startswith((".ready", ".made")):
            (folder / "venv" / place.name).symlink_to(place)
    for name in (".ready", ".ready-dev", ".made-by-make"):
        (folder / "venv" / name).touch()
    (folder / "own.mo").write_text("model Own\n  Real x(start=1, fixed=true);\nequation\n  der(x) = -x;\nend Own;\n")
    (folder / "own.md").write_text("<!-- campaign, distances: written by `railgrip report` -->\n<!-- end -->\n")
    (folder / "one.toml").write_text(ONE_STOP)
    write_library(folder / "suite")
    (folder / "small").mkdir()
    shutil.copy(ROOT / "tests/baselines/etcs.toml", folder / "small")
    return folder


ONE_STOP = f"""
name = "one"
description = "One short stop."
scenarios = ["{NEW}/../library/plain.toml"]
conditioning = "one.conditioning.json"

[axes.controller.sbc]
controller.kind = "slip_two_state"
start.speed = 5
"""


@pytest.fixture(scope="module")
def spent() -> Iterator[dict[str, float]]:
    """Processor time of each row [s], printed at the end."""
    found: dict[str, float] = {}
    yield found
    print()
    for row, seconds in sorted(found.items(), key=lambda item: -item[1]):
        print(f"{seconds:6.1f} s  {row}")
    print(f"{sum(found.values()):6.1f} s  in all")


def processor_time() -> float:
    return sum(os.times()[:4])


def skip_minutes(what: str) -> None:
    if what in MINUTES and "RAILGRIP_FUZZ" not in os.environ:
        pytest.skip("takes half a minute or more; `make fuzz` runs it")


def paths_of(row: str) -> set[str]:
    """Return the files and folders that a row names or writes."""
    return {word for word in [*shlex.split(row), COMMANDS[row]] if re.fullmatch(r"\w+(/[\w./-]+|\.toml)", word)}


def rows_before(row: str) -> list[str]:
    """Return the rows above that write what a row reads, and what these read: rows that share a path."""
    found = [row]
    for other in reversed([*COMMANDS][: [*COMMANDS].index(row)]):
        pairs = ((f"{a}/", f"{b}/") for a in paths_of(other) for each in found for b in paths_of(each))
        if any(a.startswith(b) or b.startswith(a) for a, b in pairs):
            found.append(other)
    return found[:0:-1]


def is_gone(project: Path, written: str) -> bool:
    """Return whether a file in build that a row has written is no longer there, as after `make clean`."""
    return written.startswith("build/") and not (project / written).exists()


@pytest.mark.parametrize("row", COMMANDS, ids=lambda row: " ".join(words_of(row)[0]) or row)
def test_a_command_runs_to_its_end(
    row: str, project: Path, spent: dict[str, float], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    skip_minutes(row)
    monkeypatch.chdir(project)
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setattr("railgrip.cli.fmus.write_lock", partial(write_lock, file=project / "fmus/lock.toml"))
    monkeypatch.setattr("railgrip.studies.benefit.chain._KNOTS", 2)  # headways for two factors instead of sixteen
    rows = [*rows_before(row), row]  # those that a row below needed have run already
    for each in [one for one in rows if f"railgrip {one}" not in spent or is_gone(project, COMMANDS[one])]:
        path, _ = words_of(each)
        words, folder = shlex.split(each), project
        if path[:1] == ("study",) and len(path) == 2:
            folder = project / "out" / path[1]
            words += [*OF_STUDIES.split(), str(folder)]
        start = processor_time()
        with one_process():
            ended = done(capfd, *words)
        seconds = processor_time() - start
        assert ended.code == 0, ended.err
        assert COMMANDS[each] in ended.out + ended.err or list(folder.rglob(COMMANDS[each]))
        spent[f"railgrip {each}"] = seconds


@pytest.mark.parametrize("row", MAKE, ids=lambda row: row.split()[0])
def test_a_target_runs_to_its_end(row: str, project: Path, spent: dict[str, float]) -> None:
    skip_minutes(row.split()[0])
    before = processor_time()
    ended = subprocess.run(
        ["make", *shlex.split(row), "VENV=venv"], cwd=project, env=ENVIRONMENT | {"OPTIONS": "--wrong"},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    spent[f"make {row}"] = processor_time() - before
    assert ended.returncode == (2 if "-omc" in row else 0), ended.stderr
    assert MAKE[row] in ended.stdout + ended.stderr or (project / MAKE[row]).exists()
