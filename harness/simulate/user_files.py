"""What the classes of a user consist of and read: files by digest and packages by version.

A stop with such a class depends on more than its scenario: on the modules that the class imports, also during the stop,
and on the files that it reads. Its result can be used again while all of them are as they were.
"""

import hashlib
import os
import sys
import sysconfig
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module, metadata
from importlib.machinery import PathFinder
from pathlib import Path
from types import FrameType
from typing import Any, Final

from railgrip.base.registry import Role, installed_names
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Custom
from railgrip.scenario.vehicle_table import PythonClass
from railgrip.simulate.user_parts import CALLS

_MODULE, _PACKAGE, _ABSENT = "module ", "package ", ""
_OWN: Final = ("railgrip", "railgrip.controllers", "railgrip.estimators", "railgrip.fmus")

_read: set[str] = set()


def user_kinds(scenario: Scenario) -> dict[Role, str]:
    """Return the user's classes that a scenario names, by their role."""
    tables: dict[Role, object] = {
        "controllers": scenario.controller, "estimators": scenario.estimator, "sensors": scenario.sensors
    }  # fmt: skip
    kinds: dict[Role, str] = {role: table.kind for role, table in tables.items() if isinstance(table, Custom)}
    source = scenario.vehicle.source
    if isinstance(source, PythonClass):
        kinds["plants"] = source.name
    return kinds


@cache
def record_files() -> None:
    """Record from now on, in this process, which files the classes of a user read or look for."""
    sys.addaudithook(_record)


def _record(event: str, arguments: tuple[Any, ...]) -> None:
    if event != "open" or not isinstance(arguments[0], str | bytes):
        return
    path, mode, flags = arguments
    if set(mode) & set("wax+") if isinstance(mode, str) else flags & (os.O_WRONLY | os.O_RDWR):
        return
    frame: FrameType | None = sys._getframe()  # pyright: ignore[reportPrivateUsage] - the only way to the callers
    while frame is not None and frame.f_code not in CALLS:
        frame = frame.f_back
    if frame is not None:
        _read.add(os.path.realpath(os.fsdecode(path)))


def dependencies_of(kinds: Mapping[Role, str]) -> dict[str, str]:
    """Return the dependencies of the user's classes of `user_kinds`, after the stop of their scenario in this process.

    "module NAME" → its file; path of a file that they consist of or read → SHA-256, or "" if there was none;
    "package NAME" → version. It may be more than they need, because processes run several stops. It is empty if a class
    has no file.
    """
    tops = _tops(kinds)
    origins = {name: getattr(sys.modules.get(name), "__file__", None) for name in tops}
    found = {f"{_MODULE}{name}": os.path.realpath(file) for name, file in origins.items() if file}
    if len(found) < len(tops):
        return {}
    files, packages = {path for path in _read if not _is_installed(path)}, set[str]()
    for name, module in list(sys.modules.items()):
        if name in ("__main__", "__mp_main__"):  # no class comes from there
            continue
        file, top = getattr(module, "__file__", None), name.partition(".")[0]
        if file and (top in tops or not _is_installed(file)):
            files.add(os.path.realpath(file))
        elif file:
            packages |= {*_distributions().get(top, ())}
    found |= {f"{_PACKAGE}{name}": metadata.version(name) for name in sorted(packages)}
    return found | {path: _digest(path) for path in sorted(files)}


def are_current(kinds: Mapping[Role, str], dependencies: Mapping[str, str], folders: Sequence[Path]) -> bool:
    """Return whether the user's classes of `user_kinds`, imported from folders, still have these dependencies."""
    now = {f"{_MODULE}{name}": _origin(name, None if is_installed else folders)
           for name, is_installed in _tops(kinds).items()}  # fmt: skip
    return bool(dependencies) and all(_now(name, now) == value for name, value in dependencies.items())


def _now(name: str, modules: Mapping[str, str | None]) -> str | None:
    if name.startswith(_MODULE):
        return modules.get(name)
    if name.startswith(_PACKAGE):
        try:
            return metadata.version(name.removeprefix(_PACKAGE))
        except metadata.PackageNotFoundError:
            return None
    return _digest(name)


def _tops(kinds: Mapping[Role, str]) -> dict[str, bool]:
    """Return the name of the outermost package or module of each class, and whether it is installed."""
    found: dict[str, bool] = {}
    for role, kind in kinds.items():
        points = installed_names(role)
        name = points.get(kind, kind)
        found[name.partition(":")[0].partition(".")[0]] = name in points.values()
    return found


def _origin(name: str, folders: Sequence[Path] | None) -> str | None:
    spec = PathFinder.find_spec(name, None if folders is None else [str(folder.resolve()) for folder in folders])
    return None if spec is None or spec.origin is None else os.path.realpath(spec.origin)


def _digest(path: str) -> str:
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError:
        return _ABSENT


@cache
def _installed() -> tuple[str, ...]:
    places = [sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    return tuple(
        f"{os.path.realpath(place)}{os.sep}" for place in (*places, *(import_module(name).__path__[0] for name in _OWN))
    )


def _is_installed(path: str) -> bool:
    """Return whether a file belongs to Python, an installed package or railgrip, or is bytecode of a module."""
    return os.path.realpath(path).startswith(_installed()) or path.endswith(".pyc")


_distributions = cache(metadata.packages_distributions)
