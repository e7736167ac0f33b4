"""Files that are whole or not there."""

import json
import math
import os
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from railgrip.errors import Unwritten

PARTIAL = ".*.partial"
"""Pattern of what a process that was killed while writing leaves behind."""


@contextmanager
def replacing(path: Path) -> Generator[Path]:
    """Yield a path to write beside `path`; it takes its place when the block ends well, else vanishes.

    Ctrl-C counts as a failure: whoever finds `path` finds all of it.

    Raises:
        Unwritten: The disk is full, or may not be written.
    """
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            yield partial
            partial.replace(path)
        finally:
            partial.unlink(missing_ok=True)
    except OSError as problem:
        raise Unwritten(f"{path}: cannot be written: {problem.strerror or problem}") from problem


def write_text(path: Path, text: str) -> None:
    """Write a whole text file, or leave what was there; see `replacing`."""
    write_bytes(path, text.encode())


def write_json(path: Path, content: Any) -> None:
    """Write a whole JSON file, null in place of numbers that are none: JSON has neither NaN nor infinity."""
    write_text(path, json.dumps(_finite(content), indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def write_bytes(path: Path, content: bytes) -> None:
    """Write a whole file, or leave what was there; see `replacing`."""
    with replacing(path) as partial:
        partial.write_bytes(content)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(element) for key, element in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(element) for element in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
