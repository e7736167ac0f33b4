"""Ctrl-C and SIGTERM: both end the program as an exception does, so that what is open is closed."""

import os
import signal
import threading
from collections.abc import Generator
from contextlib import contextmanager
from types import FrameType

_MEANINGS = {signal.SIGINT: "Interrupted", signal.SIGTERM: "Terminated"}


class Interrupted(BaseException):
    """Somebody wants the program to end.

    No `Exception`, which a program may answer, and no `KeyboardInterrupt`, which typer ends without a word.
    """

    def __init__(self, number: int) -> None:
        """Say which signal it was."""
        super().__init__(_MEANINGS[signal.Signals(number)])
        self.code = 128 + number
        """Exit code, as shells have it."""


def listen() -> None:
    """Raise `Interrupted` in the main thread at a signal; called in the main thread."""
    for number in _MEANINGS:
        signal.signal(number, _interrupt)


def stop_listening() -> None:
    """Let a signal end the program at once, without a word: it is about to end."""
    for number in _MEANINGS:
        signal.signal(number, signal.SIG_DFL)


_queues: list[list[int]] = []
"""Signals of those `postponed` that are open, the innermost last."""


def _interrupt(number: int, frame: FrameType | None) -> None:
    if _queues:
        _queues[-1].append(number)
    else:
        raise Interrupted(number)


@contextmanager
def ignore_sigint() -> Generator[None]:
    """Let processes and threads that are started here never hear Ctrl-C, which a terminal sends to all.

    The process that started them ends them. A mask is inherited where a handler is not: it holds from their first
    instruction on. A signal that comes to this process meanwhile is heard afterwards: who is half started reports a
    broken pipe.
    """
    if os.name != "posix":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    with postponed():
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def postponed() -> Generator[None]:
    """Raise `Interrupted` for a signal that comes meanwhile at the end: some libraries swallow every exception."""
    numbers: list[int] = []
    is_main = threading.current_thread() is threading.main_thread()  # handlers run in no other
    if is_main:
        _queues.append(numbers)
    try:
        yield
    finally:
        if is_main:
            _queues.pop()
        for number in numbers[:1]:
            _interrupt(number, None)
