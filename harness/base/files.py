"""Write files completely or not at all, and create temporary folders that are removed with their process.

A temporary folder contains a marker file, and its process holds a lock on it. The system releases the lock of a process
that was killed; the next process that creates a temporary folder removes marked folders without a lock, and no others.
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

from railgrip.base.errors import InputError, ScenarioError, WriteFailed
from railgrip.base.units import place, short

PARTIAL = ".*.partial"
"""Pattern of the files that a process leaves when it is killed while writing."""


@contextmanager
def replacing(path: Path) -> Generator[Path]:
    """Yield a temporary path next to `path`, which it replaces after the block; on failure it is removed.

    Ctrl-C counts as a failure: a file at `path` is always complete.

    Raises:
        WriteFailed: The disk is full, or the folder is not writable.
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
        raise WriteFailed(f"{path}: cannot be written: {problem.strerror or problem}") from problem


def write_text(path: Path, text: str) -> None:
    """Write a text file completely, or keep the previous one; see `replacing`."""
    write_bytes(path, text.encode())


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file completely, with null for numbers that are not finite, which JSON does not support."""
    write_text(path, json.dumps(finite(content), indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file completely, or keep the previous one; see `replacing`."""
    with replacing(path) as partial:
        partial.write_bytes(content)


LARGEST_TEXT: Final = 4 << 20
"""Maximum size in bytes of a file written by hand; the longest in this project has 20,000."""
LARGEST_TABLE: Final = 1 << 30
"""Maximum size in bytes of a recording or a table of samples; an hour of 40 signals at 100 Hz has a tenth of it."""


@contextmanager
def open_regular(path: Path, largest: int = LARGEST_TEXT, *, if_missing: str = "") -> Generator[BinaryIO]:
    """Open a user's file for reading, in bytes.

    Pipes and devices are refused because reading them may never end.

    Args:
        path: File; links are followed.
        largest: Maximum size [bytes].
        if_missing: Words that end the message on a missing file.

    Raises:
        InputError: The file is missing, unreadable, too large, or not a regular file.
    """
    name = place(path)
    try:
        # Without O_NONBLOCK, opening a pipe waits until another process writes to it.
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except FileNotFoundError as problem:
        raise InputError(f"{name}: there is no such file; correct the path{if_missing}") from problem
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


def read_bytes(path: Path, largest: int = LARGEST_TEXT, *, if_missing: str = "") -> bytes:
    """Return the content of a user's file; see `open_regular`.

    Raises:
        InputError: See `open_regular`.
    """
    with open_regular(path, largest, if_missing=if_missing) as stream:
        try:
            return stream.read(largest)
        except OSError as problem:
            raise InputError(f"{place(path)}: cannot be read: {problem.strerror}") from problem


def path_of(value: Any, name: str) -> Path:
    """Return the path that is an argument of this name; raise ScenarioError if it is none."""
    if not isinstance(value, str | Path):
        raise ScenarioError(f"{name} is {short(value)}; expected is a name or a path")
    return Path(value)


def read_text(path: Path, largest: int = LARGEST_TEXT, *, if_missing: str = "") -> str:
    """Return the text of a user's UTF-8 file, without a byte order mark, and with "\\n" as end of line.

    Raises:
        InputError: See `open_regular`; or the content is an archive or not UTF-8.
    """
    content = read_bytes(path, largest, if_missing=if_missing)
    if content.startswith(b"PK\x03\x04"):
        raise InputError(f"{place(path)}: is a zip archive, as .fmu, .ssp and .xlsx files are; name a file of text")
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as problem:
        raise InputError(f"{place(path)}: is not text in UTF-8 ({problem}); save it in that encoding") from problem


def require_regular(path: Path, largest: int, *, if_missing: str = "") -> None:
    """Check a file that a library will open by its path; see `open_regular`.

    Raises:
        InputError: See `open_regular`.
    """
    with open_regular(path, largest, if_missing=if_missing):
        pass


def remove(folder: Path, *names: str) -> None:
    """Remove files from a folder; missing ones are ignored.

    Raises:
        WriteFailed: The folder is not writable.
    """
    for name in names:
        try:
            (folder / name).unlink(missing_ok=True)
        except OSError as problem:
            raise WriteFailed(f"{folder / name}: cannot be removed: {problem.strerror}") from problem


def finite(value: Any) -> Any:
    """Replace numbers that are not finite by None in nested lists and dictionaries."""
    if isinstance(value, dict):
        return {key: finite(element) for key, element in value.items()}
    if isinstance(value, list | tuple):
        return [finite(element) for element in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


Purpose = Literal["build", "far", "fmu", "study", "workers"]
_PREFIX: Final = "railgrip-"
_MARK: Final = ".railgrip-temporary"
"""Marker file in each temporary folder of `scratch`: a folder without it is never removed."""


@contextmanager
def scratch(purpose: Purpose) -> Generator[Path]:
    """Yield a temporary folder, removed at the end; `purpose` is part of its name.

    Raises:
        WriteFailed: No temporary folder is writable.
    """
    try:
        temporary = Path(tempfile.gettempdir()).absolute()
        _remove_stale(temporary)
        folder = Path(tempfile.mkdtemp(prefix=f"{_PREFIX}{purpose}-{os.getpid()}-", dir=temporary))
    except OSError as problem:
        raise WriteFailed(
            f"no temporary folder can be written ({problem.strerror}); make room, lift the limit of file sizes, or "
            "name another folder in TMPDIR"
        ) from problem
    try:
        # The marker is written under the lock: a marked folder without a lock belongs to a dead process.
        with lock_folder(folder):
            (folder / _MARK).touch()
            yield folder
    finally:
        # Some platforms cannot remove a library that is still mapped; the system clears it later.
        shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def lock_folder(folder: Path, *, wait: bool = False) -> Generator[bool]:
    """Hold the lock of a folder, which the system releases when this process ends; yield whether it was free.

    Args:
        wait: Whether to wait until the lock is free.
    """
    if os.name != "posix":
        yield False  # such locks exist on POSIX only; on other systems no folder is removed
        return
    import fcntl

    number = os.open(folder, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        try:
            fcntl.flock(number, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
            free = True
        except OSError:
            free = False
        yield free
    finally:
        os.close(number)


@cache
def _remove_stale(temporary: Path) -> None:
    if os.name != "posix":
        return  # without locks it is unknown whether a folder is in use
    # A process that was killed leaves its folders behind; the lock of a running one is held.
    for folder in temporary.glob(f"{_PREFIX}*"):
        with suppress(OSError):
            mark = (folder / _MARK).lstat()
            is_marked = stat.S_ISREG(mark.st_mode) and {mark.st_uid, folder.lstat().st_uid} == {os.geteuid()}
            if is_marked:
                with lock_folder(folder) as free:
                    if free:
                        shutil.rmtree(folder, ignore_errors=True)
