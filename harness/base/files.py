"""Files that are whole or not there, and temporary folders that go with their process, however it ends.

A temporary folder contains a mark, and its process holds a lock on it. The system frees the lock of a process that was
killed; the next process that makes a temporary folder removes the marked folders without a lock, and no others.
"""

import json
import math
import os
import shutil
import stat
import tempfile
from collections.abc import Generator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, Final, Literal

from railgrip.base.errors import Unwritten

PARTIAL = ".*.partial"
"""Pattern of what a process that was killed while writing leaves behind."""


@contextmanager
def replacing(path: Path) -> Generator[Path]:
    """Yield a path to write beside `path`; it takes its place when the block ends well, else vanishes.

    Ctrl-C counts as a failure: a file at `path` is always complete.

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
    write_text(path, json.dumps(finite(content), indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def write_bytes(path: Path, content: bytes) -> None:
    """Write a whole file, or leave what was there; see `replacing`."""
    with replacing(path) as partial:
        partial.write_bytes(content)


def remove(folder: Path, *names: str) -> None:
    """Remove files from a folder; those that are not there are none.

    Raises:
        Unwritten: The folder may not be written.
    """
    for name in names:
        try:
            (folder / name).unlink(missing_ok=True)
        except OSError as problem:
            raise Unwritten(f"{folder / name}: cannot be removed: {problem.strerror}") from problem


def finite(value: Any) -> Any:
    """Return a value of lists, dictionaries and numbers with None in place of numbers that are not finite."""
    if isinstance(value, dict):
        return {key: finite(element) for key, element in value.items()}
    if isinstance(value, list | tuple):
        return [finite(element) for element in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


Purpose = Literal["build", "far", "fmu", "study", "workers"]
_PREFIX: Final = "railgrip-"
_MARK: Final = ".railgrip-temporary"
"""File in each temporary folder that `scratch` made: a folder without it belongs to somebody else."""


@contextmanager
def scratch(purpose: Purpose) -> Generator[Path]:
    """Yield a temporary folder, removed at the end; `purpose` is part of its name.

    Raises:
        Unwritten: No folder for temporary files can be written.
    """
    try:
        temporary = Path(tempfile.gettempdir()).absolute()
        _remove_stale(temporary)
        folder = Path(tempfile.mkdtemp(prefix=f"{_PREFIX}{purpose}-{os.getpid()}-", dir=temporary))
    except OSError as problem:
        raise Unwritten(
            f"no temporary folder can be written ({problem.strerror}); make room, lift the limit of file sizes, or "
            "name another folder in TMPDIR"
        ) from problem
    try:
        # The mark is written under the lock: a marked folder without a lock has lost its process.
        with locked(folder):
            (folder / _MARK).touch()
            yield folder
    finally:
        # A library that is still mapped may not be removable on some platforms; there the system clears it later.
        shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def locked(folder: Path) -> Generator[bool]:
    """Hold the lock of a folder, which the system releases however this process ends; yield whether it was free."""
    if os.name != "posix":
        yield False  # such locks are POSIX; nothing is removed elsewhere
        return
    import fcntl

    number = os.open(folder, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
            free = True
        except OSError:
            free = False
        yield free
    finally:
        os.close(number)


@cache
def _remove_stale(temporary: Path) -> None:
    """Remove what runs left behind that were killed; once in a process."""
    if os.name != "posix":
        return  # without locks its use is unknown
    for folder in temporary.glob(f"{_PREFIX}*"):
        with suppress(OSError):
            mark = (folder / _MARK).lstat()
            is_marked = stat.S_ISREG(mark.st_mode) and {mark.st_uid, folder.lstat().st_uid} == {os.geteuid()}
            if is_marked:
                with locked(folder) as free:
                    if free:
                        shutil.rmtree(folder, ignore_errors=True)
