"""Processes of a pool do not outlive the one that wanted them."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

PROGRAM = """
import os
import tempfile
import time

from railgrip.campaign.workers import workers


def number(_):
    time.sleep(0.1)
    return os.getpid()


def work(place):
    with tempfile.TemporaryDirectory(dir=place):
        time.sleep(600)


if __name__ == "__main__":
    with workers(2) as pool:
        print(*set(pool.map(number, range(8))), flush=True)
        list(pool.map(work, ["kept"] * 8))
"""


def is_running(process: int) -> bool:
    status = Path(f"/proc/{process}/stat")
    # A process that has ended stays in the table until somebody asks how.
    return status.exists() and status.read_text().rpartition(")")[2].split()[0] != "Z"


@pytest.mark.skipif(not Path("/proc").exists(), reason="looks processes up in /proc")
def test_workers_end_with_a_parent_that_was_killed(tmp_path):
    """And take with them what they had unpacked."""
    (tmp_path / "program.py").write_text(PROGRAM, encoding="utf-8")
    folder = tmp_path / "kept"
    folder.mkdir()
    here = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[2]), *sys.path])}
    with subprocess.Popen(
        [sys.executable, "program.py"], cwd=tmp_path, env=here, stdout=subprocess.PIPE, text=True
    ) as parent:
        assert parent.stdout is not None
        children = [int(process) for process in parent.stdout.readline().split()]
        assert children
        assert all(map(is_running, children))
        until(lambda: len(list(folder.iterdir())) == 2)
        parent.send_signal(signal.SIGKILL)
    until(lambda: not any(map(is_running, children)))
    assert list(folder.iterdir()) == []


def until(state):
    """Wait for a state, ten seconds at most: far more than a thread needs to wake up and a process to end."""
    for _ in range(200):
        if state():
            return
        time.sleep(0.05)
    raise AssertionError("it did not come to that")
