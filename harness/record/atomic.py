"""Files that are whole or not there."""

import os
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

PARTIAL = ".*.partial"
"""Pattern of what a process that was killed while writing leaves behind."""


@contextmanager
def replacing(path: Path) -> Generator[Path]:
    """Yield a path to write beside `path`; it takes its place when the block ends well, else vanishes.

    Ctrl-C counts as a failure: whoever finds `path` finds all of it.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a whole text file, or leave what was there."""
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8")
