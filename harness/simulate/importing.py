"""Import the user-defined classes that a scenario names, and record their origin in results."""

import hashlib
import inspect
import os
import sys
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module, invalidate_caches
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from railgrip.base.errors import ScenarioError
from railgrip.base.registry import Role, installed_names
from railgrip.base.units import cut, short
from railgrip.scenario.kinds import Custom
from railgrip.simulate import custom

_Table = TypeVar("_Table", bound=Custom)


def part_of(table: Custom, role: Role, folders: Sequence[Path] = ()) -> Any:
    """Return a new object of the class that a table names.

    Raises:
        ScenarioError: See `class_of`, or the class does not take these parameters.
    """
    return instance_of(class_of(table, role, folders), table.parameters, _table(role))


def class_of(table: Custom, role: Role, folders: Sequence[Path] = ()) -> type:
    """Import the class that a table names.

    Text in a file decides which code is imported here, so only two places are trusted: `folders`, which the command
        line or a caller names, and entry points of installed packages. A class is called only after its type and the
        methods of its role have been checked.

    Raises:
        ScenarioError: The module is in neither place or cannot be imported, or it lacks the class.
    """
    who = f"{_table(role)} kind {cut(table.kind)}"
    points = installed_names(role)
    class_name = points.get(table.kind, table.kind)
    module, _, name = class_name.partition(":")
    if not all(part.isidentifier() for part in module.split(".")):
        raise ScenarioError(f"{who}: {cut(module)} is not the name of a module")
    is_installed = class_name in points.values()
    invalidate_caches()  # a file may have been written a moment ago
    if not is_installed and PathFinder.find_spec(module.partition(".")[0], [str(folder) for folder in folders]) is None:
        raise ScenarioError(
            f"{who}: the module {cut(module)} cannot be imported: a class that a file names comes from a folder named "
            f"by --import-from DIR (import_from=[…] in Python), or is an entry point railgrip.{role} of an installed "
            "package"
        )
    with _path_without_current_folder(() if is_installed else folders):
        loaded: Any = custom.call_user_code(
            lambda: import_module(module),
            lambda problem: ScenarioError(f"{who}: the module {cut(module)} cannot be imported: {problem}"),
        )
    file = getattr(loaded, "__file__", None)
    if not is_installed and not (file and any(Path(file).is_relative_to(folder.resolve()) for folder in folders)):
        raise ScenarioError(
            f"{who}: another module named {module} is loaded already, from {file or 'Python itself'}; rename yours"
        )
    found: Any = loaded
    for part in name.split("."):
        found = getattr(found, part, None)
    if not isinstance(found, type):
        raise ScenarioError(f"{who}: the module {module} has no class {cut(name)}")
    custom.require_methods(found, found.__name__, role)
    return found


def instance_of(kind: type, parameters: Mapping[str, Any], where: str) -> Any:
    """Return a new object of a user's class.

    Raises:
        ScenarioError: The class does not take these parameters, or raises; the message begins with `where`.
    """
    return custom.call_user_code(
        lambda: kind(**parameters),
        lambda problem: ScenarioError(
            f"{where} {kind.__name__} cannot be made with parameters {short(dict(parameters))}: {problem}"
        ),
    )


def _table(role: Role) -> str:
    return {"sensors": "[sensors]", "plants": "[vehicle]"}.get(role, f"[{role.removesuffix('s')}]")


def table_of(part: object, table: type[_Table] = Custom, **keys: Any) -> _Table:
    """Return the table that represents an object given by a caller; `keys` are further keys of that table."""
    return table(kind=_name(type(part)), parameters=_plain_attributes(part), **keys)


def origin_of(part: object, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the origin of an object's class, as JSON values: its name, a digest of its source, its arguments.

    The digest is that of the module's file, else of the class's source text; None if neither exists. The arguments of
    an object given by a caller are its public plain attributes.
    """
    kind = type(part)
    return {"class": _name(kind), "source_sha256": _source(kind), "parameters": dict(parameters)}


def _name(kind: type) -> str:
    return f"{kind.__module__}:{kind.__qualname__}"


def _source(kind: type) -> str | None:
    try:
        content = Path(inspect.getfile(kind)).read_bytes()
    except (OSError, TypeError):
        try:
            content = inspect.getsource(kind).encode()  # of a notebook, which keeps its cells
        except (OSError, TypeError):
            return None
    return hashlib.sha256(content).hexdigest()


def _plain_attributes(part: object) -> dict[str, Any]:
    attributes: dict[str, Any] = vars(part) if hasattr(part, "__dict__") else {}
    values = {name: _plain(value) for name, value in attributes.items() if not name.startswith("_")}
    return {name: value for name, value in values.items() if value is not None}


def _plain(value: object, levels: int = 12) -> Any:
    """Return a number, string or array as JSON values.

    The result is None for other types, and for lists nested more deeply than `levels`.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        elements = [_plain(element, levels - 1) for element in value] if levels else [None]
        return None if any(element is None for element in elements) else elements
    return value if isinstance(value, bool | int | float | str) else None


@contextmanager
def _path_without_current_folder(folders: Sequence[Path]) -> Generator[None]:
    here, path = os.path.realpath(Path.cwd()), list(sys.path)
    sys.path[:] = [
        *(str(folder.resolve()) for folder in folders),
        *(entry for entry in path if entry and os.path.realpath(entry) != here),
    ]
    try:
        yield
    finally:
        sys.path[:] = path
