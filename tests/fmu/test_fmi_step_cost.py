"""Step costs compare ways that do the same work, and say so when they do not."""

from pathlib import Path

import numpy as np
import pytest
from tiny_fmu import tiny

from railgrip.bench import fmi


def test_four_ways_over_the_boundary_end_on_the_same_outputs(foundry: Path):
    cost = fmi.step_cost(tiny(foundry), count=20, rounds=1)
    assert (cost.file, cost.inputs, cost.outputs) == ("well.fmu", 1, 2)
    assert cost.ours_over_c == pytest.approx(cost.ours / cost.c)
    assert cost.fmpy_over_ours == pytest.approx(cost.fmpy / cost.ours)


def test_ways_that_disagree_are_not_compared(foundry: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(fmi, "seconds_of_fmpy", lambda *_, **__: (1.0, np.zeros(2)))
    with pytest.raises(AssertionError, match=r"well\.fmu: fmpy and ours end on different outputs"):
        fmi.step_cost(tiny(foundry), count=20, rounds=1)
