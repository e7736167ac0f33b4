"""Memory growth of a process that simulates stop after stop."""

import subprocess
import sys

import pytest

STOPS = 80
MOST = 20e3
"""Bytes per stop: a retained scenario has some 50 kB, a trace megabytes; 10 000 stops end within 200 MB."""

MANY = """
import sys
from pathlib import Path
import railgrip.scenario
from railgrip.campaign.one_stop import run
from railgrip.scenario.load import load
from railgrip.simulate.run import run_stop

def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

plain = Path(railgrip.scenario.__file__).parent / "library" / "plain.toml"
out, first, stops = Path(sys.argv[1]), 150, int(sys.argv[2])
for lot in range(first + stops):
    if lot == first:  # until then caches of the interpreter and of the allocator fill
        before = resident()
    run(load(plain, ["start.speed=2 km/h", f"seed={lot}"]), out, run_stop, keep_trace=False)
print(resident() - before)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="what a process has is read from /proc")
def test_many_stops_need_no_more_memory_than_a_few(tmp_path):
    """Over 9000 stops it was 0.9 kB per stop. In a process of its own, which no other test makes grow."""
    command = [sys.executable, "-c", MANY, str(tmp_path), str(STOPS)]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    assert int(result.stdout) < STOPS * MOST
