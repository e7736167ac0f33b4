"""A pool without processes, for tests of what is run and not of where: tests/cli has those of processes."""

from collections.abc import Generator
from concurrent.futures import Executor, Future
from contextlib import contextmanager

import pytest


class Here(Executor):
    """Runs each task at once, in this process: a new one spends two seconds on loading what it needs."""

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as problem:
            future.set_exception(problem)
        return future


@contextmanager
def one_process() -> Generator[None]:
    """Give everybody who wants workers this process instead."""

    @contextmanager
    def here(count: int, *, main: bool = True) -> Generator[Executor]:
        yield Here()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("railgrip.campaign.workers.workers", here)
        yield
