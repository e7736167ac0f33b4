"""The files of the project, in a clone and in an unpacked source distribution."""

import ast
import os
from collections.abc import Iterator
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
BASELINES = ROOT / "tests/baselines"
PACKAGES = ("harness/", "controllers/", "estimators/", "fmus/", "tools/")


@cache
def project_files() -> tuple[str, ...]:
    """Return the paths of all files that .gitignore does not list, relative to the folder of the project."""
    ignored = [".git", *(line.strip("/") for line in (ROOT / ".gitignore").read_text(encoding="utf-8").split())]

    def kept(names: list[str]) -> Iterator[str]:
        return (name for name in names if not any(fnmatch(name, pattern) for pattern in ignored))

    found: list[str] = []
    for folder, folders, files in os.walk(ROOT):
        folders[:] = kept(folders)
        found += [(Path(folder) / name).relative_to(ROOT).as_posix() for name in kept(files)]
    return tuple(sorted(found))


@cache
def modules() -> tuple[Path, ...]:
    """Return the modules of the packages and of the tools."""
    return tuple(ROOT / name for name in project_files() if name.endswith(".py") and name.startswith(PACKAGES))


def trees() -> dict[Path, tuple[str, ast.Module]]:
    """Return text and syntax tree of each of these modules: too large to keep for all tests."""
    texts = {path: path.read_text(encoding="utf-8") for path in modules()}
    return {path: (text, ast.parse(text)) for path, text in texts.items()}
