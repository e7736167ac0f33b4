"""A digest of a controller's source and parameters, from which its sealed set of cases is drawn."""

import ast
import hashlib
import json
from collections.abc import Iterable, Sequence
from importlib.util import find_spec
from pathlib import Path

from railgrip.base import registry
from railgrip.base.errors import InputError, ScenarioError
from railgrip.base.files import LARGEST_TABLE, read_bytes
from railgrip.studies.type_test.entrants import Entrant


def controller_digest(entrant: Entrant, folders: Sequence[Path] = ()) -> str:
    """Return a SHA-256 of the tables of an entrant, its parameters and its source.

    Comments, docstrings and the layout of a source do not count: they do not change the stops. Of a user's class it is
    the module of the class, without the modules that it imports; of an FMU the file.

    Args:
        entrant: The controller.
        folders: Folders in which modules of users are found.

    Raises:
        ScenarioError: The source does not exist.
    """
    table = entrant.tables["controller"]
    kind = str(table["kind"])
    digest = hashlib.sha256(json.dumps(entrant.tables, sort_keys=True, default=str).encode())
    if kind in registry.modules(registry.LAWS):
        for content in _of_law(kind):
            digest.update(content)
    elif kind == "fmu":
        digest.update(_bytes(Path(str(table["file"]))))
    elif ":" in kind:
        digest.update(_meaning(_module_file(kind.partition(":")[0], folders)))
    return digest.hexdigest()


def _of_law(kind: str) -> Iterable[bytes]:
    """Yield the sources of a law and of the laws that it imports, and all its sets of parameters."""
    found, waiting = set[str](), [kind]
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        found.add(name)
        path = _module_file(f"{registry.LAWS}.{name}", ())
        yield _meaning(path)
        tree = ast.parse(path.read_text(encoding="utf-8"))
        imports = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
        waiting += [module.rpartition(".")[2] for module in imports if module.startswith(f"{registry.LAWS}.")]
    for name, file in sorted(registry.files(registry.LAWS).items()):
        if name.partition(".")[0] in found:
            yield name.encode() + file.read_bytes()


def _module_file(module: str, folders: Sequence[Path]) -> Path:
    relative = Path(*module.split("."))
    for folder in folders:
        for file in (folder / relative.with_suffix(".py"), folder / relative / "__init__.py"):
            if file.is_file():
                return file
    spec = find_spec(module)
    if spec is None:
        raise ScenarioError(f"--controller: there is no module {module}; correct the name, or add --import-from")
    if not spec.has_location or spec.origin is None or Path(spec.origin).suffix != ".py":
        raise ScenarioError(
            f"--controller: the module {module} is part of Python or compiled, and has no source in Python; a "
            "controller is a class of your own, module:Class"
        )
    return Path(spec.origin)


def _meaning(path: Path) -> bytes:
    """Return the syntax tree of a source without docstrings, as text."""
    try:
        tree = ast.parse(_bytes(path))
    except (SyntaxError, ValueError, RecursionError) as problem:
        raise ScenarioError(f"{path.name}: is not a module in Python: {problem}") from problem
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and ast.get_docstring(
            node, clean=False
        ):
            node.body = node.body[1:]
    return ast.dump(tree).encode()


def _bytes(path: Path) -> bytes:
    try:
        return read_bytes(path, LARGEST_TABLE)
    except InputError as problem:
        raise ScenarioError(f"--controller: {problem}") from problem
