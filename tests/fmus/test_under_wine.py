"""Libraries for Windows, stepped by Wine, compared with those for this machine.

Wine comes from the system's packages; linking for Windows compiles the C library of MinGW first. The tests therefore
belong to `make portable`, where Wine is installed, and not to `make test`.
"""

import os
import shutil
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import fmpy
import numpy as np
import pytest

from railgrip.fmus.native.toolchain import compiler

WINE = shutil.which("wine64") or shutil.which("wine") or shutil.which("/usr/lib/wine/wine64")
DRIVER = Path(__file__).with_name("step_fmu.c")
HEADERS = Path(find_spec("fmpy").origin).parent / "c-code"
PERIOD, STEPS = 1e-3, 3000
HELD = {
    "pressure_command": 2e5, "mu0": 0.08, "reading_speed": 20.0, "reading_wheelset_speed": 50.0,
    "reading_deflection": 3e-3, "reading_acceleration": -0.5, "reading_cylinder_pressure": 1.5e5, "driver_demand": 3e5,
}  # fmt: skip
"""Inputs of a train that slides under a service braking; the others stay at their start values."""

pytestmark = [
    pytest.mark.skipif("RAILGRIP_LINK_WINDOWS" not in os.environ, reason="only `make portable` links for Windows"),
    pytest.mark.skipif(WINE is None, reason="Wine is not installed"),
]


def stepped(program: list[str], file: Path, library: str, folder: Path, environment: dict[str, str]) -> np.ndarray:
    """Return the outputs of an FMU after each step, shape (steps, outputs), by a library in it."""
    with zipfile.ZipFile(file) as archive:
        (member,) = [name for name in archive.namelist() if name.startswith(f"binaries/{library}/")]
        archive.extract(member, folder)
    description = fmpy.read_model_description(str(file))
    real = [variable for variable in description.modelVariables if variable.type == "Real"]
    inputs = [
        f"{v.valueReference}={HELD.get(v.name.partition('[')[0], float(v.start))!r}"
        for v in real
        if v.causality == "input"
    ]
    outputs = [str(v.valueReference) for v in real if v.causality == "output"]
    arguments = [member, description.guid, repr(PERIOD), str(STEPS), *inputs, *outputs]
    result = subprocess.run(
        [*program, *arguments], cwd=folder, env=os.environ | environment, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    return np.array([[float(number) for number in line.split()] for line in result.stdout.splitlines()])


@pytest.mark.parametrize(("part", "tolerance"), [("onboard", 0.0), ("plant", 1e-12)])
def test_the_library_for_windows_gives_the_results_of_the_one_for_linux(command, tmp_path, part, tolerance):
    """The plant uses powers and logarithms of the C library, of which MinGW has another: the last digits differ.

    By 1e-15 of the greatest output after 3 s; 1e-12 leaves a margin for the last digits of other C libraries.
    """
    file = tmp_path / "exported.fmu"
    platforms = ["--platforms", "x86_64-linux", "--platforms", "x86_64-windows"]
    assert command("export", "plain", "--part", part, "--out", str(file), *platforms).code == 0
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu"]
    for cc, program, more in ((compiler().command, "here", ["-ldl"]), (zig, "there.exe", [])):
        subprocess.run([*cc, f"-I{HEADERS}", str(DRIVER), "-o", str(tmp_path / program), *more], check=True)
    here = stepped([str(tmp_path / "here")], file, "linux64", tmp_path, {})
    prefix = {"WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"}
    there = stepped([WINE, str(tmp_path / "there.exe")], file, "win64", tmp_path, prefix)
    assert here.shape == there.shape == (STEPS, here.shape[1])
    assert np.ptp(here, axis=0).max() > 0.0
    assert np.abs(there - here).max() <= tolerance * np.abs(here).max()
