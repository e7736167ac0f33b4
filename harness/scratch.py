"""Temporary folders that go with their process, however it ends.

Each carries the number of its process, which also holds a lock on it. Of a process that was killed the system frees the
lock; the next one that wants a folder removes what lies there without.
"""

import os
import shutil
import tempfile
import time
from collections.abc import Generator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Final

_PREFIX: Final = "railgrip-"
_FRESH: Final = 60.0  # s


@contextmanager
def scratch(purpose: str) -> Generator[Path]:
    """Yield a temporary folder, removed at the end; `purpose` is part of its name."""
    _remove_stale(Path(tempfile.gettempdir()), purpose)
    # A library that is still mapped may not be removable on some platforms; there the system clears it later.
    with (
        tempfile.TemporaryDirectory(prefix=f"{_PREFIX}{purpose}-{os.getpid()}-", ignore_cleanup_errors=True) as name,
        locked(Path(name)),
    ):
        yield Path(name)


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
def _remove_stale(temporary: Path, purpose: str) -> None:
    """Remove what runs left behind that were killed; once in a process."""
    for folder in temporary.glob(f"{_PREFIX}{purpose}-[0-9]*-*"):
        with suppress(OSError):
            status = folder.lstat()
            # One that was made this minute may not have its lock yet.
            if os.name == "posix" and status.st_uid == os.geteuid() and time.time() - status.st_mtime > _FRESH:
                with locked(folder) as free:
                    if free:
                        shutil.rmtree(folder, ignore_errors=True)
