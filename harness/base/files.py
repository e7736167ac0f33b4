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
from typing import Any, BinaryIO, Final, Literal

from railgrip.base.errors import InputError, Unwritten
from railgrip.base.units import place

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


LARGEST_TEXT: Final = 4 << 20
"""Bytes of a file that a person writes; the longest in this project has 20,000."""
LARGEST_TABLE: Final = 1 << 30
"""Bytes of a recording or a table of samples; an hour of 40 signals at 100 Hz has a tenth of it."""


@contextmanager
def open_regular(path: Path, largest: int = LARGEST_TEXT) -> Generator[BinaryIO]:
    """Open a file that a user names for reading, in bytes.

    A pipe or a device is refused because reading it can take forever.

    Args:
        path: File; links are followed.
        largest: Size that is accepted [bytes].

    Raises:
        InputError: The file is missing, unreadable, too large, or not a regular file.
    """
    name = place(path)
    try:
        # Without O_NONBLOCK, opening a pipe waits until another process writes to it.
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except FileNotFoundError as problem:
        raise InputError(f"{name}: there is no such file; correct the path") from problem
    except (OSError, ValueError) as problem:  # ValueError: a null character in the path
        reason = problem.strerror if isinstance(problem, OSError) else problem
        raise InputError(f"{name}: cannot be read: {reason}") from problem
    try:
        status = os.fstat(number)
        if stat.S_ISDIR(status.st_mode):
            raise InputError(f"{name}: is a folder, and a file is expected")
        if not stat.S_ISREG(status.st_mode):
            raise InputError(f"{name}: is a pipe or a device; copy its content into a file and name that")
        if status.st_size > largest:
            raise InputError(
                f"{name}: has {status.st_size / 1e6:,.0f} MB, which is more than the {largest / 1e6:,.0f} MB that such "
                "a file may have; name a smaller file"
            )
    except InputError:
        os.close(number)
        raise
    with os.fdopen(number, "rb") as stream:
        yield stream


def read_bytes(path: Path, largest: int = LARGEST_TEXT) -> bytes:
    """Return the content of a file that a user names; see `open_regular`.

    Raises:
        InputError: See `open_regular`.
    """
    with open_regular(path, largest) as stream:
        try:
            return stream.read(largest)
        except OSError as problem:
            raise InputError(f"{place(path)}: cannot be read: {problem.strerror}") from problem


def read_text(path: Path, largest: int = LARGEST_TEXT) -> str:
    """Return the text of a UTF-8 file that a user names, without a byte order mark, and with "\\n" as end of line.

    Raises:
        InputError: See `open_regular`; or the content is not UTF-8.
    """
    try:
        return read_bytes(path, largest).decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as problem:
        raise InputError(f"{place(path)}: is not text in UTF-8 ({problem}); save it in that encoding") from problem


def require_regular(path: Path, largest: int) -> None:
    """Check a file that a library is going to open by its path; see `open_regular`.

    Raises:
        InputError: See `open_regular`.
    """
    with open_regular(path, largest):
        pass


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
