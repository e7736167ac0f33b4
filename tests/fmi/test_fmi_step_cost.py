"""The benchmark of step costs compares implementations only if they do the same work."""

from pathlib import Path

import numpy as np
import pytest
from tiny_fmu import tiny

from railgrip.studies import bench


def test_three_ways_across_the_interface_give_the_same_outputs(foundry: Path):
    times = bench.step_times(tiny(foundry), count=20, rounds=2)
    assert list(times) == ["ours", "fmpy", "c"]
    assert (times > 0.0).sum().tolist() == [2, 2, 2]


def test_ways_that_disagree_are_not_compared(foundry: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(bench, "seconds_of_fmpy", lambda *_, **__: (1.0, np.zeros(2)))
    with pytest.raises(AssertionError, match=r"well\.fmu: fmpy and ours end on different outputs"):
        bench.step_times(tiny(foundry), count=20, rounds=1)
