"""Results of tasks by a pool of processes, kept in the user's cache by content: a study goes on where it stopped."""

import ast
import hashlib
import json
import pickle
import zlib
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import asdict
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from railgrip import cache
from railgrip.campaign.workers import ended
from railgrip.errors import RailgripError

T = TypeVar("T")

_NAME = "result"


def digest_of(*parts: ModuleType | Path | bytes) -> str:
    """Return a digest of what results rest on.

    Args:
        parts: Modules, for what they do and not how they are laid out or commented; files; folders, for all of Python
            and C in them; anything else as bytes.
    """
    digest = hashlib.sha256()
    for part in parts:
        if isinstance(part, ModuleType):
            part = ast.dump(ast.parse(Path(part.__file__ or "").read_text(encoding="utf-8"))).encode()
        elif isinstance(part, Path):
            files = [part] if part.is_file() else sorted(f for f in part.rglob("*") if f.suffix in {".py", ".c", ".h"})
            part = b"\0".join(file.read_bytes() for file in files)
        digest.update(part + b"\0")
    return digest.hexdigest()


def results_of(
    kind: str,
    tasks: Sequence[T],
    make: Callable[[T], Any],
    pool: Executor,
    ground: str,
    tell: Callable[[T, bool], None] = lambda task, was_there: None,
    content: Callable[[T], object] = asdict,
) -> list[Any]:
    """Return the result of each task; those that are not in the cache are made, in their order.

    Args:
        kind: Shelf of the cache.
        make: Returns the result of a task; called in a process of the pool.
        ground: Digest of all else that decides a result, the code that makes it among it.
        tell: Told each task as its result is there, and whether it was there before.
        content: Returns what tells a task from others, as JSON has it.

    Raises:
        RailgripError: The first that a task ends with; results before it are kept.
    """
    keys = [hashlib.sha256((ground + json.dumps(content(one), sort_keys=True)).encode()).hexdigest() for one in tasks]
    task_of = dict(zip(keys, tasks, strict=True))
    files = {key: cache.find(kind, key, _NAME) for key in task_of}
    # The cache holds what this user's own processes wrote, or nothing: what is loaded into a process lies there, too.
    results = {key: pickle.loads(zlib.decompress(file.read_bytes())) for key, file in files.items() if file}
    for key in results:
        tell(task_of[key], True)
    running = {pool.submit(make, task): key for key, task in task_of.items() if key not in results}
    for key, result in ended(running):
        if isinstance(result, RailgripError):
            raise result
        cache.keep(kind, key, _NAME, zlib.compress(pickle.dumps(result)))
        results[key] = result
        tell(task_of[key], False)
    return [results[key] for key in keys]
