"""FMUs for other platforms and by FMI 3: those for this machine are stepped, the bytes of the others are inspected.

Linking for Windows first compiles the C library of MinGW, a minute for each fresh clone: `make test` reads the object
file, which also names the exports, and `make portable` links.
"""

import os
import platform
import re
import zipfile
from importlib.util import find_spec
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from binaries import described
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu
from sampled_systems import sampled

from railgrip.fmus.native import toolchain
from railgrip.fmus.native.discrete import sources
from railgrip.fmus.native.package import FAST_BUILD, as_fmi_3, pack
from railgrip.fmus.native.package import HEADERS as INCLUDED
from railgrip.fmus.native.toolchain import TARGETS, binary

WINDOWS = "x86_64-windows"
LINKED = [target for target in TARGETS if target != WINDOWS or "RAILGRIP_LINK_WINDOWS" in os.environ]
HEADERS = Path(find_spec("fmpy").origin).parent / "c-code"
FOLDERS = {
    2: {"x86_64-linux": "linux64", "x86_64-windows": "win64", "x86_64-darwin": "darwin64"},
    3: {},
}
"""Folders of binaries whose names differ from those of FMI 3."""


@pytest.fixture(scope="module", params=[2, 3])
def source(request):
    """Return the version of FMI and an FMU in C: y = x, the sum of u."""
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    step = ca.Function("step", [x, u], [x + u, x + u])
    rows = ([(name, "1", 0.0)] for name in ("x", "u", "y"))
    source = sources(sampled(step, 0.1, **dict(zip(("states", "inputs", "outputs"), rows, strict=True))))
    return request.param, source if request.param == 2 else as_fmi_3(source)


@pytest.fixture(scope="module")
def packed(source, tmp_path_factory):
    """Return the version and the FMU for all platforms."""
    version, text = source
    return version, pack(text, tmp_path_factory.mktemp("platforms") / f"sum{version}.fmu", platforms=LINKED)


def functions(version):
    """Return the functions of Co-Simulation that the headers of the standard declare."""
    header = (HEADERS / f"fmi{version}Functions.h").read_text()
    if version == 2:  # without those that only Model Exchange has
        begin, end = (header.rindex(f"Functions for FMI2 for {kind}") for kind in ("Model Exchange", "Co-Simulation"))
        header = header[:begin] + header[end:]
    declared = set(re.findall(rf"^\s*FMI{version}_Export\s+\w+\s+(\w+);", header, re.MULTILINE))
    assert len(declared) > 20
    return declared


def test_each_library_exports_the_functions_of_its_standard_on_its_platform(packed):
    version, path = packed
    with zipfile.ZipFile(path) as archive:
        for target in LINKED:
            folder = FOLDERS[version].get(target, target)
            (file,) = [name for name in archive.namelist() if name.startswith(f"binaries/{folder}/")]
            found, exports = described(archive.read(file))
            assert found == target
            assert functions(version) <= exports


def test_object_files_for_windows_export_the_functions_of_their_standard(source):
    version, text = source
    flags = (*FAST_BUILD, "-c")
    content = binary(
        text.files, "sum", units=text.units, include=[INCLUDED], flags=flags, target=TARGETS[WINDOWS]
    )  # fmt: skip
    assert content[:2] == b"\x64\x86"  # COFF for x86-64
    exports = {name.decode() for name in re.findall(rb'-export:"?(\w+)', content)}
    assert functions(version) <= exports


def test_the_same_file_runs_here(packed):
    version, path = packed
    assert validate_fmu(str(path)) == []
    if platform.system() == "Linux" and platform.machine() == "x86_64":
        signal = np.array([(0.0, 2.0), (1.0, 2.0)], dtype=[("time", float), ("u", float)])
        rows = simulate_fmu(str(path), stop_time=1.0, step_size=0.1, output_interval=0.1, input=signal, output=["y"])
        assert rows["y"][-1] == pytest.approx(20.0)
    assert version in (2, 3)


def test_each_library_is_in_the_folder_of_its_platform(tmp_path, monkeypatch, source):
    """The compiler for other platforms is started here, but compiles nothing, which takes ten seconds."""
    version, text = source
    compilers = {}

    def library(files, name, *, target, **options):
        compilers[target.zig] = toolchain._compiler_for(target).command
        return target.zig.encode()

    monkeypatch.setattr("railgrip.fmus.native.package.binary", library)
    file = pack(text, tmp_path / "sum.fmu", platforms=[*TARGETS])
    with zipfile.ZipFile(file) as archive:
        for key, target in TARGETS.items():
            place = f"binaries/{FOLDERS[version].get(key, key)}/{text.identifier}{target.suffix}"
            assert archive.read(place) == target.zig.encode()
            assert compilers[target.zig][-2:] == ("-target", target.zig)
