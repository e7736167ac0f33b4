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

AIR = [
    "PipeFriction", "PipeWave", "DistributorTimes", "TwoStages", "AcceleratedPipe", "CommandDelay", "CompressorCycle",
    # test_brake_pipe_grid.py compares its front with an independent solver.
    *(["PipeFront"] if FUZZ else []),
]  # fmt: skip


@pytest.mark.parametrize("name", AIR)
def test_the_built_in_compiler_finds_the_answer(name: str, tmp_path: Path) -> None:
    """An assertion that fails raises."""
    text = (LIBRARY / "Validation" / f"{name}.mo").read_text()
    until = float(re.search(r"StopTime=([\d.]+)", text)[1])
    source, _ = translate(Recipe.of_class(f"RailBraking.Validation.{name}", "cs"))
    # Not optimised: compilation would take longer than simulating a second of air.
    file = pack(source, tmp_path / "class.fmu", flags=("-O0",))
    error = fmpy.simulate_fmu(str(file), stop_time=until, output_interval=0.01, output=["error"])["error"]
    assert len(error) > 100
    assert np.isfinite(error).all()
