"""Libraries of Modelica classes on disk, and digests over everything that a compiled class depends on."""

import hashlib
import os
import re
from collections.abc import Iterable
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

from railgrip.base import cache, units
from railgrip.base.errors import InputError
from railgrip.base.files import LARGEST_TABLE, read_bytes

# Resolved, because rumoca treats a library that it finds by two paths as two libraries.
MODELICA = (Path(__file__).parents[2] / "modelica").resolve()
LIBRARY = MODELICA / "RailBraking"
LARGEST_WHOLE = 1 << 20
"""Largest size of a library [bytes] that the front end reads as a whole; it takes about a second for this size."""


def require_class_name(name: str) -> None:
    """Raise an error for a class name with quoted identifiers: it becomes part of file names and of omc's script.

    Raises:
        InputError: It has a quoted identifier or characters other than letters, digits and underscores.
    """
    if not re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", name, flags=re.ASCII):
        raise InputError(
            f"{name!r} is not the name of a Modelica class: it has letters, digits and underscores, with dots between "
            "packages, such as MyLib.MyTrain."
        )


def is_trusted(library: Path) -> bool:
    """Return whether a library is from this project: built-in, or generated into the user's cache."""
    return any(library.is_relative_to(folder) for folder in (MODELICA, cache.folder() / "modelica"))


def library_digest(library: Path) -> str:
    """Return a digest over the names and contents of a library's Modelica files, or of one file."""
    if not library.is_dir():
        return hashlib.sha256(read_bytes(library, LARGEST_TABLE)).hexdigest()
    out = hashlib.sha256()
    for file in modelica_files(library):
        out.update(file.relative_to(library.parent).as_posix().encode() + b"\0")
        out.update(read_bytes(file) + b"\0")
    return out.hexdigest()


def modelica_files(library: Path) -> list[Path]:
    """Return the Modelica files and files `package.order` of a library's folder, or its only file."""
    if not library.is_dir():
        return [library]
    return sorted(
        Path(folder, name)
        for folder, _, names in os.walk(library)
        for name in names
        if name.endswith(".mo") or name == "package.order"
    )


def library_of(file: Path) -> Path:
    """Return the library of a file: the folder of a `package.mo`, else the file itself."""
    return file.parent if file.name == "package.mo" else file


def sources_digest(library: Path) -> str:
    """Return a digest over everything that a class of a library may use: the library itself, and RailBraking."""
    own = library_digest(library)
    return own if library == LIBRARY else hashlib.sha256(f"{own} {library_digest(LIBRARY)}".encode()).hexdigest()


def digest(parts: Iterable[str]) -> str:
    """Return the SHA-256 of texts, each followed by a zero byte."""
    out = hashlib.sha256()
    for part in parts:
        out.update(part.encode() + b"\0")
    return out.hexdigest()


@lru_cache(maxsize=1)
def compiler_digest() -> str:
    """Return a digest over the source of the built-in compiler and the versions of packages that it uses."""
    here = Path(__file__).parent
    files = sorted(file for file in here.rglob("*") if file.suffix in (".py", ".c", ".h", ".toml", ".jinja"))
    base = Path(units.__file__)
    files += [base, base.with_name("system.py"), units.DEFINITIONS]
    packages = [version(name) for name in ("rumoca", "casadi", "numpy", "scipy")]
    return digest([*packages, *(file.read_text(encoding="utf-8") for file in files)])
