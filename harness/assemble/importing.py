"""Classes that a scenario names, and what a result says of them."""

import hashlib
import importlib
import inspect
import os
import sys
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from railgrip.errors import ScenarioError
from railgrip.scenario.custom import Custom, Role, installed_names
from railgrip.units import cut


@dataclass(frozen=True, slots=True, kw_only=True)
class Origin:
    """Which class took part in a stop.

    Attributes:
        name: module:Class.
        source: SHA-256 of the module's file, else of the class's source text; None where there is neither.
        parameters: Arguments of the class; of an object that was given as such its public plain attributes.
    """

    name: str
    source: str | None
    parameters: Mapping[str, Any]

    def to_plain(self) -> dict[str, Any]:
        """Return it as JSON values."""
        plain = asdict(self)
        return {"class": plain["name"], "source_sha256": plain["source"], "parameters": dict(self.parameters)}


def party_of(table: Custom, role: Role, folders: Sequence[Path] = ()) -> Any:
    """Import the class that a table names, and return a new object of it.

    The module is taken from the installed environment and from `folders`, never from the current folder alone: a
    scenario that came with a folder of files runs none of them.

    Raises:
        ScenarioError: There is no such module or class, or it does not take these parameters.
    """
    where = {"sensors": "[sensors]", "plants": "[vehicle]"}.get(role, f"[{role.removesuffix('s')}]")
    class_name = table.kind if ":" in table.kind else installed_names(role)[table.kind]
    module, _, name = class_name.partition(":")
    with _path_without_current_folder(folders):
        try:
            factory: Any = importlib.import_module(module)
        except Exception as problem:
            raise ScenarioError(
                f"{where} kind {cut(table.kind)}: the module {cut(module)} cannot be imported: "
                f"{type(problem).__name__}: {problem}; install its package, or name its folder by --import-from DIR"
            ) from problem
    for part in name.split("."):
        factory = getattr(factory, part, None)
    if not callable(factory):
        raise ScenarioError(f"{where} kind {cut(table.kind)}: the module {module} has no class {cut(name)}")
    try:
        return factory(**table.parameters)
    except Exception as problem:
        raise ScenarioError(
            f"{where} {name} cannot be made with parameters {dict(table.parameters)}: {type(problem).__name__}: "
            f"{problem}"
        ) from problem


def table_of(own: object) -> Custom:
    """Return the table that stands for an object given as such."""
    return Custom(kind=f"{type(own).__module__}:{type(own).__qualname__}", parameters=_plain_attributes(own))


def origin_of(own: object, parameters: Mapping[str, Any]) -> Origin:
    """Return what a result says of an object's class."""
    kind = type(own)
    return Origin(name=f"{kind.__module__}:{kind.__qualname__}", source=_source(kind), parameters=parameters)


def _source(kind: type) -> str | None:
    try:
        content = Path(inspect.getfile(kind)).read_bytes()
    except (OSError, TypeError):
        try:
            content = inspect.getsource(kind).encode()  # of a notebook, which keeps its cells
        except (OSError, TypeError):
            return None
    return hashlib.sha256(content).hexdigest()


def _plain_attributes(own: object) -> dict[str, Any]:
    attributes: dict[str, Any] = getattr(own, "__dict__", {})
    values = {name: _plain(value) for name, value in attributes.items() if not name.startswith("_")}
    return {name: value for name, value in values.items() if value is not None}


def _plain(value: object) -> Any:
    """Return a number, text or array as JSON values, else None."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        elements = [_plain(element) for element in value]
        return None if any(element is None for element in elements) else elements
    return value if isinstance(value, bool | int | float | str) else None


@contextmanager
def _path_without_current_folder(folders: Sequence[Path]) -> Generator[None]:
    here, whole = os.path.realpath(Path.cwd()), list(sys.path)
    sys.path[:] = [
        *(str(folder.resolve()) for folder in folders),
        *(entry for entry in whole if entry and os.path.realpath(entry) != here),
    ]
    try:
        yield
    finally:
        sys.path[:] = whole
