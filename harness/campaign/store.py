"""Results of tasks by a pool of processes, kept in the user's cache by content: a study goes on where it stopped."""

import pickle
import zlib
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from typing import Any, TypeVar

from railgrip import cache
from railgrip.campaign.workers import ended
from railgrip.errors import RailgripError

T = TypeVar("T")

_NAME = "result"


def results_of(
    kind: str,
    tasks: Mapping[str, T],
    make: Callable[[T], Any],
    pool: Executor,
    tell: Callable[[T, bool], None] = lambda task, was_there: None,
) -> dict[str, Any]:
    """Return the result of each task by its key; those that are not in the cache are made, in their order.

    Args:
        kind: Shelf of the cache.
        tasks: Digest of everything that decides a result, the code that makes it among it → task.
        make: Returns the result of a task; called in a process of the pool.
        pool: Of processes.
        tell: Told each task as its result is there, and whether it was there before.

    Raises:
        RailgripError: The first that a task ends with; results before it are kept.
    """
    files = {key: cache.find(kind, key, _NAME) for key in tasks}
    # The cache holds what this user's own processes wrote, or nothing: what is loaded into a process lies there, too.
    results = {key: pickle.loads(zlib.decompress(file.read_bytes())) for key, file in files.items() if file}
    for key in results:
        tell(tasks[key], True)
    running = {pool.submit(make, task): key for key, task in tasks.items() if key not in results}
    for key, result in ended(running):
        if isinstance(result, RailgripError):
            raise result
        cache.keep(kind, key, _NAME, zlib.compress(pickle.dumps(result)))
        results[key] = result
        tell(tasks[key], False)
    return results
