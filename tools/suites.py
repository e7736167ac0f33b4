"""Other people's Modelica test suites, built and simulated with the built-in compiler.

The suites are not part of this project; the user has a copy of them:

    compliance  the Modelica compliance library: classes that a compiler must accept, with assertions, or refuse
    omc         OpenModelica's testsuite/simulation/modelica: scripts with expected values
    reference   a library with published reference results, such as ModelicaTest; the folder of results has
                a file comparisonSignals.txt and a CSV file for each class

Each class is translated, compiled and simulated in a separate process with a time limit. The CSV file has one line
per class with its verdict:

    right          the FMU fulfils all assertions, or has the expected values
    other solution the FMU has other values than expected, which fulfil the equations of the class (see EQUATIONS)
    refused        a sentence refuses it; for classes that must be refused, this is the right answer
    accepted       a class that must be refused has an FMU that runs
    fails          a class that must be refused has an FMU, but the simulation ends with an error
    wrong          the FMU violates an assertion or has other values
    no simulation  the FMU of a legal class ends with another error than an assertion, and says so
    crash          the compiler ends with a signal, or its message is internal text
    hang           a time limit ended it
    translated     OpenModelica, if --compiler names it, makes C code of a legal class; it is not compiled

With --control, the assertions of a right class are inverted, as warnings with numbers; an assertion that does not warn
checks nothing. If the class with warnings does not run, each assertion is inverted in turn, and the class must fail.
The line of the class ends with the number of assertions, and of those that check nothing.
"""

import contextlib
import csv
import itertools
import math
import multiprocessing
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import fmpy
import fmpy.fmi1
import numpy as np
import pandas
import typer
from fmpy.fmi2 import FMU2Slave
from fmpy.simulation import Recorder

from railgrip.base.errors import InputError
from railgrip.fmus.build import Compiler, translate
from railgrip.fmus.native import package
from railgrip.fmus.native.library import library_of, name_of
from railgrip.fmus.openmodelica import errors
from railgrip.fmus.recipe import Recipe
from railgrip.report.console import say

SECONDS = 60.0
"""Time limit of one class [s]; the slowest right class takes a tenth of it."""
TOLERANCE = 1e-7
"""Relative error of a step of the solver: well below the accuracy of expected values, which is mostly 1e-5."""
ACCURACY = 1e-3
"""Permitted deviation, relative to the largest magnitude of a signal."""
RESIDUAL = 1e-5
"""Permitted residual of `EQUATIONS`, whose terms are of about 1: the error of many steps at `TOLERANCE`."""
INTERNAL = re.compile(r"panicked|[Ii]nternal error|Traceback|\b\w+Error\b|unreachable|fails on this class|KeyError")
"""Text that no user can act on."""


WARNING = "inverted assertion"
"""Begin of the messages of inverted assertions, which is followed by their number."""


EQUATIONS: dict[str, Callable[[float, dict[Any, float]], list[float]]] = {
    # Powell's badly scaled and Brown's almost linear function (problems 3 and 27 of Moré, Garbow and Hillstrom, 1981)
    # have several roots; the expected ones differ from script to script, by the solver of the script.
    "nonlinear_system.problem4": lambda _, v: [
        1e4 * v["x1"] * v["x2"] - 1,
        math.exp(-v["x1"]) + math.exp(-v["x2"]) - 1.0001,
    ],
    "nonlinear_system.problem7": lambda _, v: [
        *(v[f"x[{i}]"] + sum(v.values()) - 11 for i in range(1, 10)),
        math.prod(v.values()) - 1,
    ],
    # The scripts integrate with Euler's method and expect its error.
    "testSolver.bug2231": lambda t, v: [v["x[1]"] - math.exp(t)],
    "testSolver.problem3": lambda t, v: [v["x"] - 1 - t, v["x1"] - 1 - t**2, v["x2"] - math.exp(-t)],
}
"""Class → residuals of its equations, or of their solution, for the time [s] and the values of its expected signals."""


@dataclass(frozen=True, kw_only=True)
class SuiteCase:
    """One class of a suite.

    Attributes:
        legal: Whether a compiler must accept it.
        libraries: Folders with `package.mo`, or files; the first has the class.
        stop: Start and end of the simulation [s].
        times: Instants at which signals are known [s].
        expected: Name of a signal → its values at `times`; NaN where none is known.
    """

    class_name: str
    libraries: tuple[Path, ...]
    legal: bool = True
    start: float = 0.0
    stop: float = 1.0
    times: tuple[float, ...] = ()
    expected: dict[str, tuple[float, ...]] = field(default_factory=dict)


@dataclass(frozen=True)
class Verdict:
    """The verdict on a case, with the message or deviation as `detail`."""

    verdict: str
    detail: str = ""


def simulate(case: SuiteCase, fmu: Path) -> Verdict:
    """Simulate an FMU and compare its signals with the expected ones; the detail begins with numbers of `WARNING`s."""
    messages: list[str] = []
    warned: set[int] = set()

    def log(_environment: object, _instance: bytes, status: int, _category: bytes, message: bytes) -> None:
        text = message.decode(errors="replace")
        warned.update(int(number) for number in re.findall(rf"{WARNING} (\d+)", text))
        if status > 1:
            messages.append(text)

    description = fmpy.read_model_description(str(fmu))
    assert description.coSimulation is not None, "`build` makes FMUs for co-simulation"
    # An expected value at an event may be the one before or after it, so each instant has a narrow neighbourhood.
    width = 1e-5 * (case.stop - case.start)
    grid = {case.start, case.stop, *np.linspace(case.start, case.stop, 51).tolist()}
    grid |= {t + shift for t in case.times for shift in (-width, 0.0, width)}
    grid = sorted(t for t in grid if case.start <= t <= case.stop)
    try:
        instance = fmpy.instantiate_fmu(fmpy.extract(str(fmu)), description, "CoSimulation", logger=log)
        assert isinstance(instance, FMU2Slave)
        recorder = Recorder(instance, description, [*case.expected])
        instance.setupExperiment(startTime=case.start)
        instance.enterInitializationMode()
        instance.exitInitializationMode()
        recorder.sample(case.start)
        for before, after in itertools.pairwise(grid):
            instance.doStep(currentCommunicationPoint=before, communicationStepSize=after - before)
            recorder.sample(after)
    except fmpy.fmi1.FMICallException as error:
        text = messages[0] if messages else str(error)
        return Verdict("wrong" if "assertion (" in text else "no simulation", text)
    if warned:
        return Verdict("right", " ".join(map(str, sorted(warned))))
    found = pandas.DataFrame(recorder.result()).set_index("time").astype(float)
    if missing := [name for name in case.expected if name not in found]:
        return Verdict("no signal", f"the FMU has no {', '.join(missing[:5])}")
    return compare(case, found, width)


def compare(case: SuiteCase, found: pandas.DataFrame, width: float) -> Verdict:
    """Compare the values of signals, columns over time, with the expected ones."""
    worst, where = 0.0, ""
    for name, values in case.expected.items():
        expected = np.array(values)
        scale = float(np.nanmax(np.abs(expected))) if np.isfinite(expected).any() else 0.0
        for t, value in zip(case.times, expected, strict=True):
            near = found.loc[[u for u in (t - width, t, t + width) if u in found.index], name].tolist()
            if math.isnan(value) or not near:
                continue
            if any(math.isnan(v) for v in near):
                return Verdict("wrong", f"{name} is NaN at {t:g} s")
            deviation = max(min(near) - value, value - max(near), 0.0) / (scale + 1e-6)
            if deviation > worst:
                worst, where = deviation, f"{name} at {t:g} s: {near[len(near) // 2]:g} instead of {value:g}"
    verdict = "right" if worst <= ACCURACY else "wrong"
    if verdict == "wrong" and case.class_name in EQUATIONS:
        instants = [t for t in case.times if t in found.index]
        values = found[list(case.expected)].loc[instants].to_dict("records")
        residuals = [abs(r) for t, v in zip(instants, values, strict=True) for r in EQUATIONS[case.class_name](t, v)]
        if max(residuals, default=math.inf) <= RESIDUAL:
            return Verdict("other solution", f"largest residual {max(residuals):.1e}; {where}")
    return Verdict(verdict, f"{worst:.1e} {where}".strip() if case.expected else "")


def build(case: SuiteCase, folder: Path) -> Path | Verdict:
    """Return the FMU of a class, or the outcome of a failed build."""
    table = {"class": case.class_name, "interfaces": ("cs",), "solver": "rodas4", "tolerance": TOLERANCE, "step": 1e-3}
    try:
        source, _ = translate(Recipe.model_validate(table), case.libraries[0], case.libraries[1:])
        content = package.archive_bytes(source, flags=("-O0",))
    except RecursionError as error:
        return Verdict("crash", f"RecursionError: {error}")
    except InputError as error:
        return Verdict("crash" if INTERNAL.search(str(error)) else "refused", str(error))
    except Exception as error:
        return Verdict("crash", f"{type(error).__name__}: {error}")
    fmu = folder / "case.fmu"
    fmu.write_bytes(content)
    return fmu


def judge(case: SuiteCase, folder: Path) -> Verdict:
    """Build and simulate a class in this process."""
    fmu = build(case, folder)
    if isinstance(fmu, Verdict):
        return fmu
    outcome = simulate(case, fmu)
    if case.legal:
        return outcome
    return replace(outcome, verdict="accepted" if outcome.verdict in ("right", "no signal") else "fails")


def translated(case: SuiteCase, folder: Path) -> Verdict:
    """Return whether OpenModelica translates a class."""
    files = [one / "package.mo" if one.is_dir() else one for one in reversed(case.libraries)]
    loads = " ".join(f'loadFile("{file.resolve()}");' for file in files)
    script = f"{loads} getErrorString(); translateModel({case.class_name}); getErrorString();\n"
    (folder / "run.mos").write_text(script, encoding="utf-8")
    ran = subprocess.run(["omc", "-n=1", "run.mos"], cwd=folder, capture_output=True, check=False)
    if (folder / f"{case.class_name}.c").exists():
        return Verdict("translated" if case.legal else "accepted")
    return Verdict("crash" if ran.returncode < 0 else "refused", "\n".join(errors(ran.stdout.decode(errors="replace"))))


JUDGES = {"native": judge, "openmodelica": translated}
"""Compiler → function that returns its verdict on a case; it may write into a folder."""


def judge_apart(case: SuiteCase, seconds: float, compiler: Compiler = "native") -> Verdict:
    """Judge a class in a copy of this process, which has all packages in memory, with a time limit."""
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def child() -> None:
            os.setsid()
            output = os.open(folder / "output", os.O_CREAT | os.O_WRONLY)
            os.dup2(output, 1)
            os.dup2(output, 2)
            tempfile.tempdir = name
            sender.send(JUDGES[compiler](case, folder))
            sender.close()
            os._exit(0)

        process = context.Process(target=child)
        process.start()
        assert process.pid is not None, "it has started"
        sender.close()
        outcome = None
        with contextlib.suppress(EOFError):
            outcome = receiver.recv() if receiver.poll(seconds) else Verdict("hang", f"more than {seconds:g} s")
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        process.join()
        if outcome is None:
            output = (folder / "output").read_text(encoding="utf-8", errors="replace").strip()
            outcome = Verdict("crash", f"ended with {process.exitcode}: {output[-300:]}")
    return outcome


# The compliance library


def compliance(root: Path, scratch: Path, only: str = "") -> Iterator[SuiteCase]:
    """Yield the classes of the compliance library, each with a library of only the files that it names."""
    root = root / "ModelicaCompliance" if (root / "ModelicaCompliance").is_dir() else root
    for file in sorted(root.rglob("*.mo")):
        marked = re.search(
            r"TestCase\s*\(\s*shouldPass\s*=\s*(true|false)", file.read_text(encoding="utf-8", errors="replace")
        )
        parts = file.relative_to(root).with_suffix("").parts
        if marked is None or file.name == "Template.mo" or not re.search(only, ".".join([root.name, *parts])):
            continue
        stop = re.search(r"StopTime\s*=\s*([\d.eE+-]+)", file.read_text(encoding="utf-8", errors="replace"))
        yield SuiteCase(
            class_name=".".join([root.name, *parts]),
            libraries=(excerpt(root, file, scratch / "_".join(parts)),),
            legal=marked[1] == "true",
            stop=float(stop[1]) if stop else 0.01,
        )


def excerpt(root: Path, file: Path, folder: Path) -> Path:
    """Copy a file of a library, the packages around it, and the files next to it that it names."""
    files, left = set[Path](), [file, root / "Icons.mo", root / "Util.mo"]
    while left:
        one = left.pop()
        if one in files or not one.is_file():
            continue
        files.add(one)
        left += [parent / "package.mo" for parent in one.parents if parent.is_relative_to(root)]
        words = set(re.findall(r"\w+", one.read_text(encoding="utf-8", errors="replace")))
        left += [near for near in one.parent.glob("*.mo") if near.stem in words and one.name != "package.mo"]
    for one in files:
        copy = folder / root.name / one.relative_to(root)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(one, copy)
    return folder / root.name


_SKIPPED = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:[^"\\]|\\.)*"', re.DOTALL)


def assertions(text: str) -> list[tuple[int, list[int]]]:
    """Return the places of the arguments of each assertion: their begin, and the end of each of them."""
    blank, found = _SKIPPED.sub(lambda match: " " * len(match[0]), text), list[tuple[int, list[int]]]()
    for match in re.finditer(r"\bassert\s*\(", blank):
        depth, end, ends = 0, match.end(), list[int]()
        while end < len(blank) and (depth or blank[end] != ")"):
            depth += (blank[end] in "([{") - (blank[end] in ")]}")
            ends += [end] if blank[end] == "," and not depth else []
            end += 1
        found.append((match.end(), [*ends, end]))
    return found


def unchecked(case: SuiteCase, seconds: float) -> str:
    """Return the number of assertions of a right class, and of those that hold when inverted as well."""
    library = case.libraries[0]
    file = library.joinpath(*case.class_name.split(".")[1:]).with_suffix(".mo")
    text = file.read_text(encoding="utf-8")
    places = assertions(text)
    try:
        changed = text
        for number, (begin, ends) in reversed([*enumerate(places)]):
            message = f', "{WARNING} {number} ", AssertionLevel.warning'
            changed = f"{changed[:begin]}not ({changed[begin : ends[0]]}){message}{changed[ends[-1] :]}"
        file.write_text(changed, encoding="utf-8")
        outcome = judge_apart(case, seconds)
        idle = len(places) - len(outcome.detail.split())
        if outcome.verdict != "right":
            idle = 0
            for begin, ends in places:
                file.write_text(f"{text[:begin]}not ({text[begin : ends[0]]}){text[ends[0] :]}", encoding="utf-8")
                idle += judge_apart(case, seconds).verdict == "right"
    finally:
        file.write_text(text, encoding="utf-8")
    return f"{len(places)} assertions, {idle} check nothing"


# OpenModelica's scripts


def omc(root: Path) -> Iterator[SuiteCase]:
    """Yield the scripts that simulate one class of one file and print values of variables at given times."""
    for script in sorted(root.rglob("*.mos")):
        case = script_case(script)
        if case is not None:
            yield case


_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"


def script_case(script: Path) -> SuiteCase | None:
    """Return the case of one script; None unless each printed value belongs to a `val(variable, time)`."""
    text = script.read_text(encoding="utf-8", errors="replace")
    status = re.search(r"^//\s*status:\s*(\w+)", text, re.MULTILINE)
    commands, _, result = text.partition("// Result:")
    commands = re.sub(r"//[^\n]*", "", commands)
    runs = re.findall(r"\bsimulate\s*\(([^;]*)\)", commands)
    files = [script.parent / name for name in re.findall(r'loadFile\s*\(\s*"([^"]+)"', commands)]
    files = [file for file in files if file.is_file()]
    if (status and status[1] != "correct") or len(runs) != 1 or not files or "loadModel" in commands:
        return None
    call = rf"^\s*val\s*\(\s*((?:[^;\n,\[]|\[[^]\n]*\])+?)\s*,\s*({_NUMBER}|\{{[^}}]*\}})\s*[^)]*\)\s*;"
    asked = re.findall(call, commands, re.MULTILINE)
    answers = result.rpartition("end SimulationResult;")[2]
    values = re.findall(rf"^//\s*({_NUMBER}|\{{[^}}]*\}})\s*$", answers, re.MULTILINE)
    if not asked or len(asked) != len(values):
        return None
    known: dict[tuple[str, float], float] = {}
    for (name, when), value in zip(asked, values, strict=True):
        instants, numbers = ([float(n) for n in re.findall(_NUMBER, words)] for words in (when, value))
        if len(instants) != len(numbers):
            return None
        known |= {(name.replace(" ", ""), t): number for t, number in zip(instants, numbers, strict=True)}
    times = sorted({t for _, t in known})
    names = dict.fromkeys(name for name, _ in known)
    options = dict(re.findall(rf"(\w+)\s*=\s*({_NUMBER})", runs[0]))
    return SuiteCase(
        class_name=runs[0].partition(",")[0].strip(),
        libraries=tuple(files),
        start=float(options.get("startTime", 0)),
        stop=float(options.get("stopTime", 1)),
        times=tuple(times),
        expected={name: tuple(known.get((name, t), math.nan) for t in times) for name in names},
    )


# Reference results


def reference(libraries: Sequence[Path], results: Path, only: str = "", most: int = 500) -> Iterator[SuiteCase]:
    """Yield the classes of libraries with published results: a CSV file next to a `comparisonSignals.txt`."""
    libraries = [library_of(library.absolute()) for library in libraries]
    for signals in sorted(results.rglob("comparisonSignals.txt")):
        tables = sorted(signals.parent.glob("*.csv"))
        parts = signals.parent.relative_to(results).parts
        own = [library for library in libraries if name_of(library) == parts[0]]
        if len(tables) != 1 or not own or not re.search(only, ".".join(parts)):
            continue
        rows = pandas.read_csv(tables[0], index_col=0)
        wanted = [name.strip() for name in signals.read_text(encoding="utf-8").split("\n")]
        # Of instants with two rows, an event, and of more rows than necessary only some are compared.
        once = rows.loc[~rows.index.duplicated(keep=False)]
        chosen = once.iloc[:: max(1, len(once) // most)]
        yield SuiteCase(
            class_name=".".join(parts),
            libraries=(own[0], *(library for library in libraries if library != own[0])),
            start=float(rows.index[0]),
            stop=float(rows.index[-1]),
            times=tuple(chosen.index.astype(float)),
            expected={str(name): tuple(of) for name, of in chosen.items() if name in wanted},
        )


# The table


def reason(detail: str) -> str:
    """Return the common part of messages about different classes."""
    text = re.sub(r"^[\w.]+ does not compile \([^)]*\): ", "", detail).strip()
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    line = lines[1] if len(lines) > 1 and lines[0].endswith(":") else (lines or [""])[0]
    line = re.sub(r"[\w/.]+\.mo:\d+: ", "", line)
    line = re.sub(r"ModelicaCompliance[\w.]*|`[^`]*`|'[^']*'|\"[^\"]*\"", "…", line)
    return re.sub(r"\d+", "N", line)[:110]


def counts(rows: pandas.DataFrame) -> dict[str, Counter[str]]:
    """Return the number of classes of each verdict, for "legal" and "illegal" classes, if there are any."""
    found = {
        what: Counter(rows["verdict"][rows["legal"] == legal]) for what, legal in (("legal", True), ("illegal", False))
    }
    return {what: verdicts for what, verdicts in found.items() if verdicts}


def table(rows: pandas.DataFrame) -> str:
    """Return the counts of verdicts, and the reasons of refusals by their number."""
    lines = [
        f"{verdicts.total()} {what}: {', '.join(f'{count} {verdict}' for verdict, count in verdicts.most_common())}"
        for what, verdicts in counts(rows).items()
    ]
    refused = rows.loc[rows["legal"] & (rows["verdict"] == "refused"), "detail"]
    why = Counter(map(reason, refused))
    lines += ["reasons of refusals of legal classes:", *(f"{count:5d}  {text}" for text, count in why.most_common())]
    others = rows[~rows["verdict"].isin(("right", "translated", "refused", "accepted", "fails"))]
    for verdict, name, detail in zip(others["verdict"], others["class"], others["detail"], strict=True):
        lines.append(f"{verdict}: {name}: {' '.join(str(detail).split())[:200]}")
    return "\n".join(lines)


def suites(
    kind: Annotated[Literal["compliance", "omc", "reference"], typer.Argument(help="Kind of the suite.")],
    suite: Annotated[Path, typer.Argument(help="Folder of the suite; for reference, of its results.")],
    library: Annotated[list[Path] | None, typer.Option(help="For reference: a library; repeatable.")] = None,
    only: Annotated[str, typer.Option(help="Regular expression for the names of classes.")] = "",
    seconds: Annotated[float, typer.Option(help="Time limit of a class.")] = SECONDS,
    compiler: Annotated[Compiler, typer.Option(help="The built-in one, or OpenModelica's.")] = "native",
    control: Annotated[bool, typer.Option("--control", help="Invert the assertions of right classes.")] = False,
    out: Annotated[Path | None, typer.Option(help="CSV file.", show_default="build/suites/KIND-COMPILER.csv")] = None,
) -> None:
    """Build and simulate the classes of a copy of a Modelica test suite."""
    out = out or Path("build/suites", f"{kind}-{compiler}.csv")
    out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch, out.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["class", "legal", "verdict", "seconds", "detail"])
        cases = {
            "compliance": lambda: compliance(suite, Path(scratch), only),
            "omc": lambda: omc(suite),
            "reference": lambda: reference(library or [], suite, only),
        }[kind]()
        for case in cases:
            if not re.search(only, case.class_name):
                continue
            began = time.perf_counter()
            outcome = judge_apart(case, seconds, compiler)
            if control and case.legal and outcome.verdict == "right" and kind == "compliance":
                outcome = replace(outcome, detail=unchecked(case, seconds))
            took = f"{time.perf_counter() - began:.1f}"
            writer.writerow([case.class_name, case.legal, outcome.verdict, took, outcome.detail])
            stream.flush()
    rows = pandas.read_csv(out, keep_default_na=False)
    if rows.empty:
        raise InputError(f"{suite}: no class of the kind {kind} was found")
    say(table(rows))
