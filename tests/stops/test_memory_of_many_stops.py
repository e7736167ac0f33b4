"""Memory growth of a process that simulates stop after stop."""

import ctypes
import os
import subprocess
import sys

import pytest
from sampling import FUZZ

FIRST, STOPS = (150, 80) if FUZZ else (60, 40)
MOST = 20e3
"""Bytes per stop: a trace has megabytes, and with 20 kB 10 000 stops end within 200 MB; `OBJECTS` limits the rest."""
OBJECTS = 2
"""Objects with references that a stop may leave behind: a retained scenario has some thirty."""

MANY = """
import collections
import ctypes
import gc
import sys
from pathlib import Path
import railgrip.scenario
from railgrip.campaign.run import run
from railgrip.fmus.build import fmu
from railgrip.scenario.load import load
from railgrip.simulate.run import run_stop

class Allocated(ctypes.Structure):
    _fields_ = [(name, ctypes.c_size_t) for name in "_1 _2 _3 _4 mapped _5 _6 of_heap _7 _8".split()]  # malloc.h

allocated = ctypes.CDLL(None).mallinfo2
allocated.restype = Allocated
plain = Path(railgrip.scenario.__file__).parent / "library" / "plain.toml"

def held():
    gc.collect()
    memory = allocated()
    return memory.mapped + memory.of_heap, collections.Counter(type(item).__name__ for item in gc.get_objects())

out, first, stops = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
for lot in range(first + stops):
    if lot == first:  # until then caches of the interpreter fill
        held()  # and the caches that counting needs
        before, kinds = held()
    for name in ("TwoPartTrain", "TrainPrediction"):  # as other processes do, which use the same FMUs
        fmu(name)
    run(load(plain, ["start.speed=2 km/h", f"seed={lot}"]), out, run_stop, keep_trace=False)
after, kinds_after = held()
more = kinds_after - kinds
print(after - before, more.total(), more.most_common(5))
"""


@pytest.mark.skipif(
    sys.platform != "linux" or not hasattr(ctypes.CDLL(None), "mallinfo2"), reason="glibc counts what is allocated"
)
def test_many_stops_need_no_more_memory_than_a_few(tmp_path):
    """In a process of its own, which no other test makes grow, by what is allocated.

    What is resident depends on what else the machine does.
    """
    command = [sys.executable, "-c", MANY, str(tmp_path), str(FIRST), str(STOPS)]
    environment = os.environ | {"PYTHONMALLOC": "malloc"}  # Python's own allocator is not counted
    result = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    memory, objects, _ = result.stdout.split(maxsplit=2)
    assert int(memory) < STOPS * MOST, result.stdout
    assert int(objects) < STOPS * OBJECTS, result.stdout
