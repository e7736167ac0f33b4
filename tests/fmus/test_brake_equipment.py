"""Air ports, pipes of cells and clocks, translated by the built-in compiler, reproduce closed forms and limits."""

import re
from pathlib import Path

import fmpy
import numpy as np
import pytest
from sampling import FUZZ

from railgrip.fmus.build import translate
from railgrip.fmus.native.library import LIBRARY
from railgrip.fmus.native.package import pack
from railgrip.fmus.recipe import Recipe


@pytest.fixture
def simulated(tmp_path: Path):
    """Simulate a class of RailBraking; an assertion that fails raises."""

    def run(name: str, *outputs: str) -> np.ndarray:
        text = (LIBRARY / (name.replace(".", "/") + ".mo")).read_text()
        until = float(re.search(r"StopTime=([\d.]+)", text)[1])
        source, _ = translate(Recipe.of_class(f"RailBraking.{name}", "cs"))
        # Not optimised: compilation would take longer than simulating a second of air.
        file = pack(source, tmp_path / "class.fmu", flags=("-O0",))
        return fmpy.simulate_fmu(str(file), stop_time=until, output_interval=0.01, output=outputs)

    return run


AIR = [
    "PipeFriction", "PipeWave", "DistributorTimes", "TwoStages", "AcceleratedPipe", "CommandDelay", "CompressorCycle",
    # test_brake_pipe_grid.py compares its front with an independent solver.
    *(["PipeFront"] if FUZZ else []),
]  # fmt: skip


@pytest.mark.parametrize("name", AIR)
def test_the_built_in_compiler_finds_the_answer(name: str, simulated) -> None:
    error = simulated(f"Validation.{name}", "error")["error"]
    assert len(error) > 100
    assert np.isfinite(error).all()


@pytest.mark.skipif(not FUZZ, reason="test_brake_pipe_grid.py has the front, test_trains_in_files.py the filling")
def test_an_emergency_brake_reaches_the_last_of_ten_coaches(simulated) -> None:
    """271 m of pipe to the middle of the last coach; its cylinder pressure starts to rise at 240 to 270 m/s.

    UIC 540 allows each distributor 3 to 5 s from then, in position P.
    """
    pressures = [f"distributor[{k}].pressure" for k in range(1, 12)]
    trace = simulated("Examples.BrakePipeOfTenCoaches", *pressures)
    since = trace["time"] - 1.0
    begins, fills = (np.array([since[np.argmax(trace[p] > level)] for p in pressures]) for level in (1e3, 0.95 * 3.8e5))
    assert 271 / 270 < begins[-1] < 271 / 240
    assert np.all(np.diff(begins) > 0)
    assert np.all((fills - begins > 3.0) & (fills - begins < 5.0))
