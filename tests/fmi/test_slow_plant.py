"""A plant that takes too long for a stop is found by its short run."""

import numpy as np
import pytest
from synthetic import LAYOUT

from railgrip.base.errors import PlantFailed
from railgrip.simulate import trial


class Slow:
    """A plant whose clock advances by a second of real time at each step."""

    def __init__(self, monkeypatch):
        self.clock = 0.0
        monkeypatch.setattr(trial.time, "monotonic", lambda: self.clock)

    def start(self, inputs):
        return np.ones(LAYOUT.outputs)

    def step(self, inputs):
        self.clock += 1.0
        return np.ones(LAYOUT.outputs)


def test_a_short_run_ends_after_a_minute(monkeypatch):
    plant = Slow(monkeypatch)
    with pytest.raises(PlantFailed, match=r"took more than 60 s of real time for 0\.\d+ s of its short run"):
        trial.tried(LAYOUT, plant, period=1e-3, release=(0.0,), brake=(1e5,))
    assert plant.clock < 63.0
