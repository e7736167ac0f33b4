"""Libraries of Modelica classes on disk."""

import hashlib
import os
from pathlib import Path

LIBRARY = Path(__file__).parents[2] / "modelica" / "RailBraking"


def library_digest(library: Path) -> str:
    """Return a digest over the names and contents of a library's Modelica files, or of one file."""
    if not library.is_dir():
        return hashlib.sha256(library.read_bytes()).hexdigest()
    files = sorted(
        Path(folder, name)
        for folder, _, names in os.walk(library)
        for name in names
        if name.endswith(".mo") or name == "package.order"
    )
    out = hashlib.sha256()
    for file in files:
        out.update(file.relative_to(library.parent).as_posix().encode() + b"\0")
        out.update(file.read_bytes() + b"\0")
    return out.hexdigest()


def library_of(file: Path) -> Path:
    """Return the library that a file stands for: the folder of a `package.mo`, else the file itself."""
    return file.parent if file.name == "package.mo" else file


def sources_digest(library: Path) -> str:
    """Return a digest over all that a class of a library may be made of: the library itself, and RailBraking."""
    own = library_digest(library)
    return own if library == LIBRARY else hashlib.sha256(f"{own} {library_digest(LIBRARY)}".encode()).hexdigest()
