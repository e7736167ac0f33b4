"""A user's cache of compiled or simulated files: private to the user, and verified before use.

A library or an FMU from the cache is loaded into the process, so it must be the one that railgrip stored. The path of a
file is kind/key/digest/name: the key identifies the inputs that it was made from, the digest its content. The folder
may be removed at any time; when it becomes too large, the files with the oldest last use are removed.
"""

import hashlib
import os
import stat
import tempfile
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from functools import cache as once
from pathlib import Path

from platformdirs import user_cache_path

from railgrip.base.activity import activity
from railgrip.base.errors import InputError
from railgrip.base.files import lock_folder

VARIABLE = "RAILGRIP_CACHE"
"""Environment variable for another folder, an absolute path."""

LARGEST = 4_000_000_000
"""Maximum size of the cache in bytes; a study of axle boxes uses some hundred million."""
_IN_USE = 86400.0
"""Minimum time since its last use after which a file may be removed [s]: a process may be about to load it."""
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def folder() -> Path:
    """Return the folder of the cache, which need not exist.

    Raises:
        InputError: The path is relative: a folder from elsewhere could then supply libraries that are loaded.
    """
    variable = os.environ.get(VARIABLE)
    path = Path(variable) if variable else user_cache_path("railgrip", appauthor=False)
    if not path.is_absolute():
        raise InputError(f"the cache folder must be an absolute path, got '{path}'; correct {VARIABLE}.")
    return path.resolve()


def find(kind: str, key: str, name: str) -> Path | None:
    """Return a cached file, or None if no complete file of this user exists.

    Raises:
        InputError: Other users can write to the cache.
    """
    place = folder() / kind / key
    if not place.is_dir():
        return None
    for file in sorted(place.glob(f"*/{name}")):
        for above in _down_to(file.parent):
            _require_private(above)
        if _is_private(file, stat.S_ISREG) and _digest(file.read_bytes()) == file.parent.name:
            with suppress(OSError):
                os.utime(file)
            return file
    return None


def keep(kind: str, key: str, name: str, content: bytes) -> Path:
    """Store a file and return its path; safe if several processes store the same file at once.

    Raises:
        InputError: The cache cannot be written, or other users can write to it.
    """
    place = private_folder(kind, key, _digest(content))
    try:
        # Moved into place as a whole: other processes may be reading the file, or have loaded the one that is replaced.
        number, half = tempfile.mkstemp(dir=place)
        try:
            with os.fdopen(number, "wb") as stream:
                stream.write(content)
            try:
                Path(half).replace(place / name)
            except PermissionError:
                # Windows cannot replace a loaded library; the digest in its path guarantees the same content.
                if not (place / name).is_file():
                    raise
                Path(half).unlink(missing_ok=True)
        except BaseException:
            Path(half).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise _cannot_write(place, error) from error
    _prune_once(folder())
    return place / name


@contextmanager
def one_maker(kind: str, key: str, what: str) -> Generator[None]:
    """Wait until no other process makes the files of a key, so that they are made once; look for them afterwards.

    Without locks of folders, as on Windows, several processes may make the same files.

    Args:
        kind: As for `keep`.
        key: As for `keep`.
        what: Name of what is compiled, for the display of progress.

    Raises:
        InputError: The cache cannot be written, or other users can write to it.
    """
    with activity(f"compiling {what}"), lock_folder(private_folder(kind, key), wait=True):
        yield


def private_folder(*names: str) -> Path:
    """Return a folder of the cache, such as kind/key, which exists and in which only this user can write.

    Raises:
        InputError: The cache cannot be written, or other users can write to it.
    """
    place = folder().joinpath(*names)
    try:
        folder().parent.mkdir(parents=True, exist_ok=True)
        for above in _down_to(place):
            above.mkdir(mode=0o700, exist_ok=True)
            _require_private(above)
    except OSError as error:
        raise _cannot_write(place, error) from error
    return place


def prune(root: Path) -> None:
    """Remove the files with the oldest last use from a cache, until its size does not exceed `LARGEST`."""
    now = time.time()
    files = [(file.lstat(), file) for file in root.glob("*/*/*/*") if not file.is_symlink()]
    size = sum(status.st_size for status, _ in files)
    # A last use in the future was before the clock was put back.
    for status, file in sorted(files, key=lambda entry: -abs(now - entry[0].st_mtime)):
        if size <= LARGEST or abs(now - status.st_mtime) < _IN_USE:
            return
        size -= status.st_size
        file.unlink(missing_ok=True)
        with suppress(OSError):  # the folder has other files
            file.parent.rmdir()
            file.parents[1].rmdir()


@once
def _prune_once(root: Path) -> None:
    # Once per process, because pruning reads the status of every file.
    with suppress(OSError):  # another process may prune at the same time
        prune(root)


def _cannot_write(place: Path, error: OSError) -> InputError:
    return InputError(
        f"{place}: the cache cannot be written ({error.strerror}); make room or name another folder in {VARIABLE}."
    )


def _down_to(place: Path) -> tuple[Path, ...]:
    depth = len(place.relative_to(folder()).parts)
    return (*reversed(place.parents[:depth]), place)


def _require_private(place: Path) -> None:
    if not _is_private(place, stat.S_ISDIR):
        raise InputError(
            f"{place}: compiled code is kept here, but the folder is not yours or others can write in it; "
            f"remove it, or name another folder in {VARIABLE}."
        )


def _is_private(place: Path, of_kind: Callable[[int], bool]) -> bool:
    status = place.lstat()
    if not of_kind(status.st_mode):
        return False
    # Windows protects a user's cache folder by other means.
    return os.name != "posix" or (status.st_uid == os.geteuid() and not status.st_mode & _OTHERS_WRITE)


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
