"""Check that this installation is complete.

Each check does its own imports, so that a broken package is reported like any other problem.
"""

import csv
import platform
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution, version
from pathlib import Path
from tempfile import TemporaryFile, gettempdir
from typing import get_args

import typer

import railgrip
from railgrip.base import cache
from railgrip.base.errors import RailgripError
from railgrip.base.programs import find_program, requirements
from railgrip.base.registry import Role, installed_names
from railgrip.report.console import complain, say, show_table
from railgrip.report.table import ReportTable


@dataclass(frozen=True, slots=True)
class CheckResult:
    """Result of a check.

    Attributes:
        what: Subject of the check.
        found: Result in words.
        remedy: Remedy for a problem; empty without a problem.
    """

    what: str
    found: str
    remedy: str = ""


def doctor() -> None:
    """Check versions, compilers, folders and parts of other packages.

    Exit code 1 means that there are problems; each comes with its remedy.
    """
    findings = [finding for name, check in CHECKS.items() for finding in _findings_of(name, check)]
    rows = [
        {"": "PROBLEM" if finding.remedy else "ok", "check": finding.what, "found": finding.found}
        for finding in findings
    ]
    show_table(ReportTable(rows, left=("", "check", "found")))
    problems = [finding for finding in findings if finding.remedy]
    for problem in problems:
        complain(f"{problem.what}: {problem.found}: {problem.remedy}")
    if problems:
        raise typer.Exit(1)
    say("No problems.")


def _findings_of(name: str, check: Callable[[], Iterator[CheckResult]]) -> list[CheckResult]:
    try:
        return list(check())
    except RailgripError as problem:
        return [CheckResult(name, "fails", str(problem))]
    except Exception as problem:  # a compiled package that does not load may raise any exception
        words = f"{type(problem).__name__}: {problem}"
        return [CheckResult(name, words, "install railgrip again, with the option --force-reinstall of pip")]


def _versions() -> Iterator[CheckResult]:
    yield CheckResult("railgrip", f"{railgrip.__version__} in {Path(railgrip.__file__).parent}")
    yield CheckResult("Python", f"{platform.python_version()} on {platform.platform()}, {sys.executable}")
    found: list[str] = []
    for name, requirement in requirements().items():
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            yield CheckResult(name, "is not installed", f"python -m pip install '{requirement}'")
    yield CheckResult("packages", ", ".join(found))


def _files_of_the_package() -> Iterator[CheckResult]:
    installed = distribution("railgrip")
    # From Python 3.12 on, `files` leaves out those that are missing.
    names = [row[0] for row in csv.reader((installed.read_text("RECORD") or "").splitlines())]
    names = [name for name in names if name.startswith("railgrip/") and not name.endswith(".pyc")]
    missing = [name for name in names if not Path(str(installed.locate_file(name))).is_file()]
    if missing:
        words = f"{len(missing)} of {len(names)} files are missing, such as {missing[0]}"
        yield CheckResult(
            "files of the package", words, "install railgrip again, with the options --force-reinstall --no-deps of pip"
        )
    else:
        found = f"{len(names)}, all there" if names else "used from a folder of sources"
        yield CheckResult("files of the package", found)


def _compiler() -> Iterator[CheckResult]:
    from railgrip.fmus.native.toolchain import binary, compiler

    cc = compiler()
    size = len(binary({"doctor.c": "double half(double x) { return 0.5 * x; }\n"}, "doctor"))
    yield CheckResult("C compiler", f"{' '.join(cc.command)} ({cc.version}), compiles a library of {size} bytes")


def _openmodelica() -> Iterator[CheckResult]:
    from railgrip.fmus.openmodelica import missing_programs

    omc = find_program("omc")
    if omc is not None and (missing := " and ".join(missing_programs())):
        yield CheckResult("OpenModelica", f"{omc} needs {missing}", f"install {missing}, or take omc from the PATH")
    else:
        yield CheckResult("OpenModelica", omc or "not found; the built-in compiler builds the FMUs")


def _fmus() -> Iterator[CheckResult]:
    from railgrip.fmi.description import PLATFORM

    yield CheckResult("FMUs", f"FMPy {version('fmpy')} loads those with binaries for {PLATFORM}")


def _cache() -> Iterator[CheckResult]:
    folder = cache.folder()
    cache.keep("doctor", "writable", "written", b"by railgrip doctor")
    size = sum(file.lstat().st_size for file in folder.rglob("*") if not file.is_dir())
    most = f"{cache.LARGEST / 1e9:.0f} GB at most"
    yield CheckResult("cache", f"{folder}, {size / 1e6:.0f} MB, {most}; {cache.VARIABLE} names another")


def _folders() -> Iterator[CheckResult]:
    for what, folder, remedy in (
        ("temporary folder", Path(gettempdir()), "name one that you may write in TMPDIR, or make room"),
        ("current folder", Path.cwd(), "results go to build below it: change to another folder, or use --out"),
    ):
        try:
            with TemporaryFile(dir=folder) as file:
                file.write(b"railgrip doctor")
        except OSError as problem:
            yield CheckResult(what, f"{folder} cannot be written: {problem.strerror}", remedy)
        else:
            room = shutil.disk_usage(folder).free
            yield CheckResult(what, f"{folder}, {room / 1e9:.1f} GB free")


def _parts_of_other_packages() -> Iterator[CheckResult]:
    from railgrip.scenario.table import Custom
    from railgrip.simulate.user_parts import class_of

    names = [(role, name) for role in get_args(Role) for name in installed_names(role)]
    for role, name in names:
        what = f"{role.removesuffix('s')} {name}"
        try:
            class_of(Custom(kind=name), role)
        except RailgripError as problem:
            yield CheckResult(what, str(problem), f"correct or remove the package with the entry point railgrip.{role}")
        else:
            yield CheckResult(what, installed_names(role)[name])
    if not names:
        yield CheckResult("parts of other packages", f"none; entry points are railgrip.{', '.join(get_args(Role))}")


CHECKS: Mapping[str, Callable[[], Iterator[CheckResult]]] = {
    "versions": _versions,
    "files of the package": _files_of_the_package,
    "C compiler": _compiler,
    "OpenModelica": _openmodelica,
    "FMUs": _fmus,
    "cache": _cache,
    "folders": _folders,
    "parts of other packages": _parts_of_other_packages,
}
