"""The number of calls that a task takes: unlike seconds it does not depend on the machine."""

import cProfile
import pstats
from collections.abc import Callable, Iterable


def calls_of(task: Callable[[], object]) -> int:
    """Return the number of calls of functions in Python and in C."""
    with cProfile.Profile() as profile:
        task()
    return pstats.Stats(profile).total_calls


def assert_linear(tasks: Iterable[Callable[[], object]]) -> None:
    """Check that of three tasks, whose sizes grow by equal amounts, the last takes no more additional calls."""
    few, more, most = (calls_of(task) for task in tasks)
    assert most - more <= 1.05 * (more - few), (few, more, most)
