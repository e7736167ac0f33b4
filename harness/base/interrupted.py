"""Ctrl-C and SIGTERM end the program by an exception, so that open resources are closed."""

import os
import signal
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager
from types import FrameType

_MEANINGS = {signal.SIGINT: "Interrupted", signal.SIGTERM: "Terminated"}


class Interrupted(BaseException):
    """The user or the system requests the end of the program.

    It is not an `Exception`, which user code may catch, and not a `KeyboardInterrupt`, which typer handles silently.
    """

    def __init__(self, number: int) -> None:
        super().__init__(_MEANINGS[signal.Signals(number)])
        self.code = 128 + number
        """Exit code by the convention of shells."""
        self.kept = "what had finished is kept"
        """Clause for the user about results."""


def listen() -> None:
    """Raise `Interrupted` in the main thread at a signal; called in the main thread."""
    for number in _MEANINGS:
        signal.signal(number, _interrupt)


def stop_listening() -> None:
    """Restore the default action, by which a signal ends the program at once and silently.

    It is called shortly before the end of the program.
    """
    for number in _MEANINGS:
        signal.signal(number, signal.SIG_DFL)


_handled = 0.0
"""Time at which Python last handled a signal; `time.monotonic`."""
_PATIENCE = 0.8  # s


@contextmanager
def end_if_stuck(what: str) -> Generator[None]:
    """End the program when code from outside does not return after a signal, as Python cannot raise `Interrupted` then.

    Args:
        what: Name of the code that is loaded into this process, for the message.
    """
    if os.name != "posix" or threading.current_thread() is not threading.main_thread() or not _is_listening():
        yield
        return
    source, wake = os.pipe()
    os.set_blocking(wake, False)

    def watch() -> None:
        while number := os.read(source, 1):
            received = time.monotonic()
            time.sleep(_PATIENCE)
            if number[0] in list(_MEANINGS) and _handled < received - _PATIENCE:
                meaning = _MEANINGS[signal.Signals(number[0])]
                os.write(2, f"{meaning}: {what} does not return, so the program ends at once.\n".encode())
                os._exit(128 + number[0])

    before = signal.set_wakeup_fd(wake, warn_on_full_buffer=False)
    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(wake)
        watcher.join(2 * _PATIENCE)
        os.close(source)


def _is_listening() -> bool:
    return all(signal.getsignal(number) is _interrupt for number in _MEANINGS)


_queues: list[list[int]] = []
"""Signals received in each open `postpone_interrupts` block, the innermost last."""


def _interrupt(number: int, frame: FrameType | None) -> None:
    global _handled
    _handled = time.monotonic()
    if _queues:
        _queues[-1].append(number)
    else:
        raise Interrupted(number)


@contextmanager
def ignore_sigint() -> Generator[None]:
    """Start processes and threads in the block with Ctrl-C blocked; a terminal sends it to all processes.

    The process that started them ends them. A signal mask, unlike a handler, is inherited, so it holds from their first
    instruction on. A signal to this process is handled after the block: a process that is interrupted while it starts
    would report a broken pipe.
    """
    if os.name != "posix":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    with postpone_interrupts():
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def postpone_interrupts() -> Generator[None]:
    """Delay `Interrupted` to the end of the block, because some libraries catch every exception."""
    numbers: list[int] = []
    is_main = threading.current_thread() is threading.main_thread()  # Python runs handlers only there
    if is_main:
        _queues.append(numbers)
    try:
        yield
    finally:
        if is_main:
            _queues.pop()
        for number in numbers[:1]:
            _interrupt(number, None)
