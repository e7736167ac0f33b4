"""Worker processes of a pool end together with the process that started the pool."""

import os
import sys
import tempfile
from pathlib import Path

import pytest
from waiting import LONGEST, is_running, until

from railgrip.base.files import _remove_stale, scratch
from railgrip.campaign.workers import pool, shared_pool, workers

PROGRAM = """
import os
import tempfile
import time

from railgrip.base.files import scratch
from railgrip.campaign.workers import workers


def number(_):
    time.sleep(0.1)
    return os.getpid()


def work():
    with tempfile.TemporaryDirectory(dir="kept"):
        time.sleep(600)


if __name__ == "__main__":
    with workers(2) as pool, scratch("build"), scratch("study"):
        print(*set(pool.map(number, range(8))), flush=True)
        pool.submit(work).result()
"""


@pytest.mark.skipif(not Path("/proc").exists(), reason="looks processes up in /proc")
def test_workers_end_when_their_parent_is_killed(program, tmp_path, monkeypatch):
    """Whether busy or idle, they remove the files that they unpacked, and nothing is printed.

    Python's tracker of semaphores prints nothing either. The next start removes the folders of the parent.
    """
    (tmp_path / "program.py").write_text(PROGRAM, encoding="utf-8")
    kept, temporary = tmp_path / "kept", tmp_path / "temporary"
    kept.mkdir()
    temporary.mkdir()
    parent = program(tmp_path, "program.py", TMPDIR=str(temporary))
    children = [int(process) for process in parent.stdout.readline().split()]
    assert children
    assert all(map(is_running, children))
    until(lambda: list(kept.iterdir()))
    parent.kill()
    _, err = parent.communicate(timeout=LONGEST)  # until the last worker has closed it
    assert err == ""
    until(lambda: not any(map(is_running, children)) and list(kept.iterdir()) == [])
    assert len(list(temporary.iterdir())) == 3
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    _remove_stale.cache_clear()
    with scratch("fmu") as mine:
        assert list(temporary.iterdir()) == [mine]


@pytest.fixture
def ended(program, tmp_path):
    """Return a function that runs a program until it ends, and returns its exit code, output and errors."""

    def run(text):
        (tmp_path / "program.py").write_text(text, encoding="utf-8")
        process = program(tmp_path, "program.py")
        out, err = process.communicate(timeout=LONGEST)
        return process.returncode, out, err

    return run


SLOW_START = """
import os
import signal
import sys
import time
from pathlib import Path

stopping, second = Path("stopping"), Path("second")


def hold(number, frame):
    # The pool has dropped its locks by the time it ends its workers, one after the other.
    stopping.touch()
    time.sleep(1.5)
    os._exit(0)


def busy():
    signal.signal(signal.SIGTERM, hold)
    Path("busy").touch()
    time.sleep(600)


if __name__ == "__main__":
    from railgrip.campaign.workers import workers

    try:
        with workers(2) as pool:
            pool.submit(busy)
            while not (Path("busy").exists() and second.exists()):
                time.sleep(0.01)
            raise KeyboardInterrupt
    except KeyboardInterrupt:
        sys.exit(130)
else:
    try:
        os.close(os.open("first", os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        # A worker whose imports take until the pool is ended; it opens its locks after them.
        second.touch()
        while not stopping.exists():
            time.sleep(0.01)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals are POSIX")
def test_a_worker_still_starting_when_its_pool_ends_prints_nothing(ended):
    assert ended(SLOW_START)[::2] == (130, "")


SLOW_LIBRARY = """
import pebble

from railgrip.campaign.workers import workers

pebble.CONSTS.channel_lock_timeout = 0.5

if __name__ == "__main__":
    from slow_library import number

    with workers(2) as pool:
        print(sorted(pool.map(number, range(4))))
"""


def test_workers_wait_while_one_of_them_loads_the_library_of_its_task(ended, tmp_path):
    """On a busy machine it takes longer than the minute that a worker waits for the pipe of the tasks."""
    text = "import time\ntime.sleep(2.0)\ndef number(n):\n    return n\n"
    (tmp_path / "slow_library.py").write_text(text, encoding="utf-8")
    assert ended(SLOW_LIBRARY) == (0, "[0, 1, 2, 3]\n", "")


IN_A_THREAD = """
import signal
import threading

from railgrip.campaign.workers import workers


def blocked():
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())


def run():
    with workers(1) as pool:
        print(pool.submit(blocked).result(), blocked(), flush=True)


if __name__ == "__main__":
    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    run()
"""


@pytest.mark.skipif(os.name != "posix", reason="signals are POSIX")
def test_workers_ignore_ctrl_c_whichever_thread_starts_them(ended):
    """From their first instruction: the signal mask is inherited, so no handler must be installed first."""
    code, out, _ = ended(IN_A_THREAD)
    assert (code, out.split()) == (0, ["True", "False"] * 2)


def test_a_pool_within_a_shared_pool_uses_its_process():
    with shared_pool(1):
        processes = set()
        for _ in range(2):
            with pool(2, None) as (executor, _):
                processes |= {executor.submit(os.getpid).result() for _ in range(2)}
    assert len(processes - {os.getpid()}) == 1


def test_a_script_is_hidden_from_processes_that_must_not_run_it_again(monkeypatch):
    main = sys.modules["__main__"]
    monkeypatch.setattr(main, "__file__", "script.py", raising=False)
    with workers(1, main=False):
        assert not hasattr(main, "__file__")
        assert main.__spec__ is None
    assert main.__file__ == "script.py"
