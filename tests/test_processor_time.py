"""`make test` prints the processor time of everything that it has started."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

BURN = """
import subprocess, sys, time
while time.process_time() < 0.5:
    pass
if len(sys.argv) == 2:
    subprocess.run([sys.executable, "-c", sys.argv[1]])
sys.exit(3)
"""


@pytest.mark.skipif(os.name != "posix", reason="Windows does not count the time of child processes")
def test_the_time_includes_child_processes_and_the_exit_code_is_that_of_the_command():
    """Two processes use half a second each, one started by the other; this process measures the same from outside."""
    program = Path(__file__).with_name("processor_time.py")
    before = os.times()
    done = subprocess.run(
        [sys.executable, program, sys.executable, "-c", BURN, BURN], capture_output=True, text=True, check=False
    )
    assert done.returncode == 3
    found = re.fullmatch(r"processor time: (\d+) s \(user \d+ s, system \d+ s\)\n", done.stdout)
    assert found, done
    after = os.times()
    both = [time.children_user + time.children_system for time in (before, after)]
    assert 1 <= int(found[1]) <= both[1] - both[0] + 0.5
