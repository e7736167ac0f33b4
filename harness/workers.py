"""Processes that simulate, judge and train, each on one core."""

import os
from collections.abc import Generator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Final

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
        with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
            yield pool
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
