"""Memory growth of a process that simulates stop after stop."""

import sys
from pathlib import Path

import pytest
from synthetic import LIBRARY

from railgrip.campaign.one_stop import run
from railgrip.scenario.load import load
from railgrip.simulate.run import run_stop

FIRST, STOPS = 20, 80
MOST = 20e3
"""Bytes per stop: a retained scenario has some 50 kB, a trace megabytes; 10 000 stops end within 200 MB."""


def resident() -> float:
    """Memory of this process [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096.0


@pytest.mark.skipif(sys.platform != "linux", reason="what a process has is read from /proc")
def test_many_stops_need_no_more_memory_than_a_few(tmp_path):
    """After the first stops, which create shared objects; over 9000 of them it was 0.9 kB per stop."""
    before = resident()
    for lot in range(FIRST + STOPS):
        if lot == FIRST:
            before = resident()
        run(load(LIBRARY / "plain.toml", ["start.speed=2 km/h", f"seed={lot}"]), tmp_path, run_stop, keep_trace=False)
    assert resident() - before < STOPS * MOST
