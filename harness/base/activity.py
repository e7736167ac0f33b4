"""Long activities that are under way in this process and its workers, which the display of progress names."""

import os
import threading
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

FOLDER: Final = "RAILGRIP_ACTIVITIES"
"""Environment variable with the folder in which a process and its workers have a file for each activity."""

_here: list[str] = []


@contextmanager
def activity(what: str) -> Generator[None]:
    """Name what is done in the block, such as "compiling TrainPrediction"."""
    folder = os.environ.get(FOLDER)
    file = Path(folder) / f"{os.getpid()}-{threading.get_ident()}-{len(_here)}" if folder else None
    _here.append(what)
    with suppress(OSError):  # nothing but the display depends on it
        if file is not None:
            file.parent.mkdir(exist_ok=True)
            file.write_text(what, encoding="utf-8")
    try:
        yield
    finally:
        _here.remove(what)
        if file is not None:
            file.unlink(missing_ok=True)


def activities() -> list[str]:
    """Return the activities that are under way, each once."""
    found = list(_here)
    if folder := os.environ.get(FOLDER):
        for file in sorted(Path(folder).glob("*")):
            with suppress(OSError, UnicodeDecodeError):  # it ended meanwhile
                found.append(file.read_text(encoding="utf-8"))
    return list(dict.fromkeys(filter(None, found)))


def forget_activities() -> None:
    """Forget the activities of workers, one of which was lost."""
    if folder := os.environ.get(FOLDER):
        for file in Path(folder).glob("*"):
            file.unlink(missing_ok=True)
