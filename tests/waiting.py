"""Wait for an event instead of a fixed time: a busy machine may need a hundred times as long as an idle one."""

import time
from collections.abc import Callable
from pathlib import Path

LONGEST = 600.0
"""Seconds after which a test counts as hanging."""


def until(state: Callable[[], object]) -> None:
    """Return once a state is reached."""
    end = time.monotonic() + LONGEST
    while not state():
        assert time.monotonic() < end, "it did not come to that"
        time.sleep(0.01)


def is_running(process: int) -> bool:
    """Return whether a process runs; one that has ended stays in the table until its parent reads its exit code."""
    try:
        return (Path("/proc") / str(process) / "stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False
