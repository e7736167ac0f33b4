"""The delay line of the valves, compared with its definition: an array, shifted and interpolated."""

from collections.abc import Iterator

import numpy as np
import pytest
from slave import Slave

from railgrip.fmus.native import package
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.system import explicit

PERIOD = 0.002


@pytest.fixture(scope="module")
def delay(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Slave]:
    source = package.sources(explicit(read("RailBraking.Pneumatics.ValveDelay")), interfaces=("cs",))
    with Slave(package.pack(source, tmp_path_factory.mktemp("delay") / "ValveDelay.fmu")) as slave:
        yield slave


def begin(delay: Slave, command: float, dead_fill: float, dead_vent: float) -> None:
    """Initialise the delay again."""
    delay.fmu.reset()
    delay.start = {"dead_fill": dead_fill, "dead_vent": dead_vent, "command": command}
    delay.initialise()


def run(delay: Slave, commands: np.ndarray, dead_fill: float, dead_vent: float) -> np.ndarray:
    """Hold each command over a step of one period, with one sample in it; return filling and venting, shape (n, 2)."""
    begin(delay, commands[0], dead_fill, dead_vent)
    seen: list[list[float]] = []
    for k, command in enumerate(commands):
        delay.step(k, PERIOD, command=command)
        seen.append(delay.get("filling", "venting"))
    return np.array(seen)


def wanted(commands: np.ndarray, dead_fill: float, dead_vent: float) -> np.ndarray:
    line, out = np.zeros(64), []
    for command in commands:
        line = np.roll(line, 1)
        line[0] = np.sign(command) * (abs(command) >= 0.5)
        fill, vent = (np.interp(dead / PERIOD, np.arange(64), line) for dead in (dead_fill, dead_vent))
        out.append((fill >= 0.5, vent <= -0.5))
    return np.array(out, dtype=float)


@pytest.mark.parametrize(
    ("dead_fill", "dead_vent"),
    [(0.0, 0.126), (0.126, 0.0), (0.05, 0.04), (0.062, 0.064), (0.0637, 0.0633), (0.0755, 0.0612), (0.1253, 0.0007)],
)
def test_valves_follow_the_command_after_their_dead_times(delay: Slave, dead_fill: float, dead_vent: float) -> None:
    """Ends of the range, whole and fractional periods, and the boundary between the two numbers that store the line."""
    rng = np.random.default_rng(7)
    commands = np.repeat(rng.choice([-1.0, -0.3, 0.0, 0.49, 0.5, 1.0], 120), rng.integers(1, 12, 120))
    np.testing.assert_array_equal(run(delay, commands, dead_fill, dead_vent), wanted(commands, dead_fill, dead_vent))


def test_no_sample_falls_on_a_whole_millisecond(delay: Slave) -> None:
    """Communication steps end there, so rounding would decide on the sample. It is half a step later."""
    begin(delay, 1.0, 0.0, 0.0)
    delay.fmu.doStep(0.0, 0.00049)
    assert delay.get("filling") == [0.0]
    delay.fmu.doStep(0.00049, 0.00002)
    assert delay.get("filling") == [1.0]
