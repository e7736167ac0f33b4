"""Processes that simulate, judge and train, each on one core."""

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Generator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from types import FrameType
from typing import Final

_TRIES: Final = 30  # to close FMUs and remove folders takes milliseconds, and few tasks wait in a queue

_THREADS: Final = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


@contextmanager
def workers(count: int) -> Generator[ProcessPoolExecutor]:
    """Yield a pool of `count` processes.

    Their linear algebra has one thread each: matrices of a few dozen columns gain nothing from more, and threads that
    wait for each other on a busy machine make it ten times slower.
    """
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        # Spawned, because CasADi holds threads, and because a library reads the variables when it is loaded.
        with ProcessPoolExecutor(count, get_context("spawn"), initializer=leave_with_parent) as pool:
            yield pool
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def leave_with_parent() -> None:
    """End this process when the one that started it is gone, however that ended; called in its main thread.

    Workers hold both ends of their own queue: they would not notice, finish what lies in it, and then wait for ever.
    What is being done is left as by an exception, so that no unpacked FMU stays behind.
    """
    parent = multiprocessing.parent_process()
    assert parent is not None, "for a process that multiprocessing started"

    orphaned = threading.Event()

    def leave(number: int, frame: FrameType | None) -> None:
        if orphaned.is_set():
            sys.exit(1)
        # A pool that ends its workers means at once, without a word.
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGTERM)

    def wait() -> None:
        parent.join()
        orphaned.set()
        for _ in range(_TRIES):  # the pool takes the exit for a failed task, and takes the next from its queue
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(0.1)
        os._exit(1)

    signal.signal(signal.SIGTERM, leave)
    threading.Thread(target=wait, name="leave with parent", daemon=True).start()
