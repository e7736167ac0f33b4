"""A pool without processes, for tests that do not depend on processes; tests/cli tests the processes."""

from collections.abc import Generator
from concurrent.futures import Executor, Future
from contextlib import contextmanager

import pytest


class Here(Executor):
    """Runs each task at once in this process; a new process would need two seconds for its imports."""

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as problem:
            future.set_exception(problem)
        return future


@contextmanager
def one_process() -> Generator[None]:
    """Replace all worker processes by this process."""

    @contextmanager
    def here(count: int, *, main: bool = True) -> Generator[Executor]:
        yield Here()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("railgrip.campaign.workers.workers", here)
        yield
