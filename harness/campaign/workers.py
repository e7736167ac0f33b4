"""Pools of processes that simulate, evaluate and train, each on one core."""

import logging
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from contextlib import contextmanager, nullcontext, suppress
from contextvars import ContextVar
from multiprocessing import resource_tracker
from multiprocessing.context import SpawnContext
from pathlib import Path
from types import FrameType
from typing import Any, Final, ParamSpec, TypeVar
from urllib.parse import urlsplit

import pebble

from railgrip.base.activity import FOLDER, forget_activities
from railgrip.base.errors import InputError, RailgripError, for_user
from railgrip.base.files import scratch
from railgrip.base.interrupted import Interrupted, ignore_sigint
from railgrip.base.programs import installation
from railgrip.base.units import cut
from railgrip.report.console import remark

_TRIES: Final = 30  # closing FMUs and removing folders takes milliseconds, and few tasks wait in a queue

_THREADS: Final = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")

_ANSWER: Final = 10.0  # s
_RETRIES: Final = 2
_WITHOUT_WORKERS: Final = 300.0  # s; a cluster whose queue starts workers may need minutes

P = ParamSpec("P")
T = TypeVar("T")
K = TypeVar("K")


@contextmanager
def workers(count: int, *, main: bool = True) -> Generator[Executor]:
    """Yield a pool of `count` processes; if the block ends by an exception, they are ended at once.

    A process that crashes fails its task with `pebble.ProcessExpired`, and is replaced. Linear algebra uses one thread
    per process: matrices of a few dozen columns gain nothing from more, and threads that wait for each other on a busy
    machine make it ten times slower. Temporary files are in a folder that is removed with the pool, however the
    processes ended. With `main` False a user's script is not run again in each process; tasks must then not be defined
    in it.
    """
    with (
        scratch("workers") as folder,
        # A process starts with `python -c`, which without PYTHONSAFEPATH searches the current folder for modules.
        environment(dict.fromkeys(_THREADS, "1") | {"TMPDIR": str(folder), "PYTHONSAFEPATH": "1"}),
        environment({FOLDER: str(folder / "activities")}),
        nullcontext() if main else _without_main(),
    ):
        _start_tracker()
        context = _LastingLocks()
        pool = pebble.ProcessPool(count, initializer=_start_worker, context=context)
        try:
            yield _Pool(pool)
            pool.close()
        except BaseException:
            pool.stop()
            raise
        finally:
            pool.join()
            context.locks.clear()


def require_address(scheduler: str) -> None:
    """Check that a text can be the address of a Dask scheduler, before anything is run.

    Raises:
        InputError: The text has no host or no port.
    """
    try:
        address = urlsplit(scheduler if "://" in scheduler else f"tcp://{scheduler}")
        is_address = bool(address.hostname and address.port)
    except ValueError:
        is_address = False
    if not is_address:
        raise InputError(
            f"--scheduler {cut(scheduler)}: is not an address; write tcp://HOST:PORT, as tcp://node1:8786."
        )


@contextmanager
def cluster(address: str) -> Generator[tuple[Executor, Callable[[], None]]]:
    """Yield the workers of a Dask cluster, such as "tcp://host:8786", and a check for `collect` that workers exist.

    A task of a lost worker is run again by another; a task that loses several workers fails. Workers must have one
    thread each and the same version of this program. An exception cancels all tasks.

    Raises:
        InputError: Dask is not installed, no scheduler answers at the address, or a worker has more threads.
    """
    try:
        from distributed import Client
    except ImportError as problem:
        raise InputError(f"--scheduler needs Dask; install it with {installation('cluster')}.") from problem
    try:
        client = Client(address, timeout=_ANSWER, set_as_default=False)
    except (OSError, ValueError) as problem:
        raise InputError(f"--scheduler {address}: no Dask scheduler answers there: {problem}") from problem
    # It would print a traceback for each try to reach a scheduler that has ended; `collect` reports it once per task.
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    with client:
        last_answer, warned = time.monotonic(), False

        def check() -> None:
            nonlocal last_answer, warned
            threads = [worker["nthreads"] for worker in client.scheduler_info(-1)["workers"].values()]
            if any(count > 1 for count in threads):
                raise InputError(
                    f"--scheduler {address}: a worker has {max(threads)} threads, but CasADi and FMUs need one: "
                    "start workers with `dask worker --nthreads 1`"
                )
            missing = time.monotonic() - last_answer
            if threads:
                last_answer, warned = time.monotonic(), False
            elif missing > _WITHOUT_WORKERS:
                raise RailgripError(
                    f"--scheduler {address}: has had no worker for {_WITHOUT_WORKERS:g} s; start some with "
                    f"`dask worker {address} --nthreads 1` and repeat the command, which keeps what has finished"
                )
            elif missing > _ANSWER and not warned:
                warned = True
                remark(f"--scheduler {address}: has no worker; waiting {_WITHOUT_WORKERS:g} s for one")

        check()
        # Tasks with equal arguments are separate stops: Dask would merge them.
        executor = client.get_executor(pure=False, retries=_RETRIES)
        try:
            yield executor, check
        except BaseException:
            executor.shutdown(wait=False)
            raise


_SHARED: ContextVar[Executor | None] = ContextVar("_SHARED", default=None)


@contextmanager
def shared_pool(count: int) -> Generator[None]:
    """Let every `pool` in the block use the same `count` processes, which load their libraries only once."""
    with workers(count) as here:
        before = _SHARED.set(here)
        try:
            yield
        finally:
            _SHARED.reset(before)


@contextmanager
def pool(count: int, scheduler: str | None) -> Generator[tuple[Executor, Callable[[], None]]]:
    """Yield `count` local processes, or the workers of a Dask cluster, and a check for `collect`."""
    if scheduler is not None:
        with cluster(scheduler) as far:
            yield far
    elif (here := _SHARED.get()) is not None:
        yield here, lambda: None
    else:
        with workers(count) as here:
            yield here, lambda: None


class _LastingLocks(SpawnContext):
    """Spawns processes, because CasADi has threads, and libraries read environment variables when they are loaded.

    Its locks exist until the pool has ended. Pebble drops its references before it ends the workers, and the name of a
    lock is removed with its last owner: a worker that had not opened it yet would print a traceback.
    """

    def __init__(self) -> None:
        super().__init__()
        self.locks: list[Any] = []

    def RLock(self) -> Any:  # noqa: N802, a name of multiprocessing
        self.locks.append(super().RLock())
        return self.locks[-1]


def _start_tracker() -> None:
    """Start Python's process that removes the locks of killed processes, without its warnings about them.

    Otherwise the first worker would start it, which would lift the signal mask.
    """
    with (
        suppress(OSError),
        Path(os.devnull).open("w") as silent,
        os.fdopen(os.dup(2), "w") as errors,
    ):  # 2 may be closed
        os.dup2(silent.fileno(), 2)
        try:
            resource_tracker.ensure_running()
        finally:
            os.dup2(errors.fileno(), 2)


class _Pool(Executor):
    """Pebble's pool as an executor; its processes, and the threads that start them, ignore Ctrl-C."""

    def __init__(self, pool: pebble.ProcessPool) -> None:
        self._pool = pool

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        # While a worker receives a task, the others wait, and end after a minute, and the pool with them. On a busy
        # machine the libraries of a function take longer to load, so that it is unpickled afterwards.
        task = pickle.dumps((fn, args, kwargs))
        with ignore_sigint():
            try:
                return self._pool.schedule(_call_pickled, args=(task,))
            except (BrokenExecutor, RuntimeError) as problem:
                raise RailgripError(f"worker processes cannot be started: {problem}") from problem


def _call_pickled(task: bytes) -> Any:
    function, arguments, named = pickle.loads(task)
    return function(*arguments, **named)


def collect(
    running: Mapping[Future[T], K], check: Callable[[], None] = lambda: None
) -> Iterator[tuple[K, T | RailgripError]]:
    """Yield each task and its result when it ends; an error if its process was lost.

    Args:
        check: Called each second in which no task ends; may raise an error to stop waiting.
    """
    open_ = set(running)
    while open_:
        done, open_ = wait(open_, timeout=1.0, return_when=FIRST_COMPLETED)
        if not done:
            check()
        for future in done:
            try:
                yield running[future], future.result()
            except CancelledError:
                remedy = "start it and its workers and repeat the command, which keeps what has finished"
                yield running[future], RailgripError(f"the Dask scheduler ended; {remedy}")
            except (pebble.ProcessExpired, BrokenExecutor) as problem:
                forget_activities()
                yield running[future], RailgripError(f"the process that ran it ended: {problem}")


def answer(call: Callable[[], T]) -> T | RailgripError:
    """Return the result of a call, or its error for the user; any other exception is raised."""
    try:
        return call()
    except Exception as problem:
        message = for_user(problem)
        if message is None:
            raise
        return message


@contextmanager
def _without_main() -> Generator[None]:
    """Hide the origin of the main module: a spawned process would run it, and a script without a guard endlessly."""
    main = sys.modules["__main__"]
    attributes = {name: vars(main)[name] for name in ("__spec__", "__file__") if name in vars(main)}
    main.__spec__ = None
    vars(main).pop("__file__", None)
    try:
        yield
    finally:
        vars(main).update(attributes)


@contextmanager
def environment(values: Mapping[str, str]) -> Generator[None]:
    """Set environment variables within the block."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _start_worker() -> None:
    """End this process when its parent has ended, for any reason; called in the main thread.

    Workers hold both ends of their queue, so they would not notice: they would finish the queued tasks and then wait
    forever. The present task is ended by an exception, so that no unpacked FMU remains.
    """
    parent = multiprocessing.parent_process()
    assert parent is not None, "for a process that multiprocessing started"

    def leave(number: int, frame: FrameType | None) -> None:
        raise Interrupted(signal.SIGTERM)  # SystemExit would look like a failure of a user's class

    def wait() -> None:
        parent.join()
        # Nobody reads the tracebacks of a queue that has lost its other end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        for _ in range(_TRIES if os.name == "posix" else 0):
            # The pool would treat the exception as a failed task, and take the next one from its queue.
            os.kill(os.getpid(), signal.SIGUSR1)
            time.sleep(0.1)
        os._exit(1)

    # A pool that ends its workers requires them to end at once, even in a loop in C.
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if os.name == "posix":
        signal.signal(signal.SIGUSR1, leave)
    threading.Thread(target=wait, name="leave with parent", daemon=True).start()
