"""Ctrl-C and SIGTERM: both end the program as an exception does, so that what is open is closed."""

import os
import signal
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


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise Interrupted(number)


@contextmanager
def deaf_children() -> Generator[None]:
    """Let processes and threads that are started here never hear Ctrl-C, which a terminal sends to all.

    Whoever started them ends them. A mask is inherited where a handler is not: it holds from their first instruction
    on, and a signal that comes now is heard afterwards.
    """
    if os.name != "posix":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
