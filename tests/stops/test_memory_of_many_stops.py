"""Memory growth of a process that simulates stop after stop."""

import subprocess
import sys

import pytest
from sampling import FUZZ

STOPS = 80 if FUZZ else 40
MOST = 20e3 if FUZZ else 40e3
"""Bytes per stop: a trace has megabytes, and with 20 kB 10 000 stops end within 200 MB; `OBJECTS` limits the rest.

The allocator takes and returns memory by the megabyte, which is up to 25 kB for each of 40 stops.
"""
OBJECTS = 2
"""Objects with references that a stop may leave behind: a retained scenario has some thirty."""

MANY = """
import gc
import sys
from pathlib import Path
import railgrip.scenario
from railgrip.campaign.run import run
from railgrip.scenario.load import load
from railgrip.simulate.run import run_stop

def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

plain = Path(railgrip.scenario.__file__).parent / "library" / "plain.toml"
def held():
    gc.collect()
    return resident(), len(gc.get_objects())

out, first, stops = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
for lot in range(first + stops):
    if lot == first:  # until then caches of the interpreter and of the allocator fill
        before = held()
    run(load(plain, ["start.speed=2 km/h", f"seed={lot}"]), out, run_stop, keep_trace=False)
print(*(after - earlier for after, earlier in zip(held(), before)))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="what a process has is read from /proc")
def test_many_stops_need_no_more_memory_than_a_few(tmp_path):
    """Over 9000 stops it was 0.9 kB per stop. In a process of its own, which no other test makes grow."""
    command = [sys.executable, "-c", MANY, str(tmp_path), "150" if FUZZ else "60", str(STOPS)]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    memory, objects = map(int, result.stdout.split())
    assert memory < STOPS * MOST
    assert objects < STOPS * OBJECTS
