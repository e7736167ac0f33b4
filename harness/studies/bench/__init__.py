"""Durations, as medians and ratios of alternating runs, in which a busy machine slows both sides equally."""

import os
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter

Row = tuple[str, str, str]
"""A measurement: its subject, the figure with its unit, and its target, if there is one."""


def microseconds(
    call: Callable[[], object], *, count: int = 1, rounds: int = 9, clock: Callable[[], float] = perf_counter
) -> float:
    """Return the time of a call that is made `count` times in a row [µs], the median over rounds."""
    durations: list[float] = []
    for _ in range(rounds):
        begin = clock()
        for _ in range(count):
            call()
        durations.append((clock() - begin) / count * 1e6)
    return median(durations)


def machine() -> str:
    """Return processor, number of cores and load, which are required to interpret times."""
    name = "unknown processor"
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        models = [
            line.partition(":")[2].strip()
            for line in cpuinfo.read_text(encoding="utf-8").splitlines()
            if "model name" in line
        ]
        name = models[0] if models else name
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return f"{name}, {os.cpu_count()} cores{load}"
