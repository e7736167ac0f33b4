"""The onboard part as a C library: a program linked with it decides like the FMU."""

import csv
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from command_line import exit_code
from slave import Slave
from synthetic import LIBRARY
from target_build import TargetBuild, missing_programs

from railgrip.base.errors import BuildFailed
from railgrip.fmus.native.package import pack
from railgrip.fmus.native.toolchain import compiler
from railgrip.scenario.load import load
from railgrip.simulate.export.c_parts import part_fmu, write_library

PERIOD = 1e-3
SHORT = ("--set", "estimator.kind=none", "--set", "controller.kind=slip_two_state", "--set", "start.speed=10 km/h")
PROGRAM = """
#include <stdio.h>
#include <string.h>
#include "plain_onboard.h"
int main(void) {
    static plain_onboard_State moved, state;
    plain_onboard_Inputs in;
    plain_onboard_Outputs out;
    double row[sizeof in / sizeof(double)];
    plain_onboard_start(&moved);
    memcpy(&state, &moved, sizeof state); /* a state may be copied */
    while (fread(row, sizeof row, 1, stdin)) {
        memcpy(&in, row, sizeof row);
        if (plain_onboard_step(&state, &in, &out)) return 1;
        fwrite(&out, sizeof out, 1, stdout);
    }
    return 0;
}
"""


@pytest.fixture(scope="module")
def scenario():
    """Valves and an estimator, from 30 km/h: every part that can be on board."""
    pneumatic = ("vehicle.plant=TwoPartTrainPneumatic", "actuation.kind=pneumatic")
    return load(LIBRARY / "plain.toml", ["estimator.kind=compiled", "start.speed=30 km/h", *pneumatic])


@pytest.fixture(scope="module")
def library(scenario, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("library")
    files = [*write_library(scenario, folder)]
    assert all(file.is_file() for file in files)
    return folder


def readings(library: Path) -> np.ndarray:
    return np.loadtxt(library / "readings.csv", delimiter=",", skiprows=1)


def compiled(program: Path, library: Path, *more: str) -> Path:
    binary = program.with_suffix("")
    here = [f"-I{library}", str(program), str(library / "libplain_onboard.a"), "-lm", *more, "-o", str(binary)]
    subprocess.run([*compiler().command, "-Wall", "-Werror", *here], check=True)
    return binary


def by_fmu(scenario, folder: Path, rows: np.ndarray) -> np.ndarray:
    """Return the outputs of the onboard FMU at the end of each step."""
    outputs = []
    with Slave(pack(part_fmu(scenario, "onboard"), folder / "onboard.fmu")) as fmu:
        for k, row in enumerate(rows):
            fmu.step(k, PERIOD, **dict(zip(fmu.of["input"], row.tolist(), strict=True)))
            outputs.append(fmu.get(*fmu.of["output"]))
    return np.array(outputs)


def test_a_program_with_the_library_decides_like_the_fmu(scenario, library: Path, tmp_path: Path):
    rows = readings(library)
    assert len(rows) > 3000, "a stop"
    (tmp_path / "program.c").write_text(PROGRAM)
    binary = compiled(tmp_path / "program.c", library)
    run = subprocess.run([str(binary)], input=rows.tobytes(), stdout=subprocess.PIPE, check=True)
    expected = by_fmu(scenario, tmp_path, rows)
    # The same C by the same compiler: bit-identical.
    np.testing.assert_array_equal(np.frombuffer(run.stdout).reshape(expected.shape), expected)
    assert len(np.unique(expected[:, :4])) > 1, "the valves move"


def test_the_library_allocates_nothing_and_exports_only_its_own_names(library: Path):
    nm = shutil.which("nm")
    if nm is None:
        pytest.skip("nm, of binutils, lists the symbols")
    text = subprocess.run([nm, str(library / "libplain_onboard.a")], capture_output=True, text=True, check=True).stdout
    symbols = re.findall(r"^[0-9a-f ]* ([A-Za-z]) (\w+)$", text, re.MULTILINE)
    used = {name for kind, name in symbols if kind == "U" and not name.startswith("plain_onboard_")}
    assert used <= {"exp", "log", "sqrt", "sin", "cos", "tan", "atan", "tanh", "pow", "fabs", "fmax", "fmin", "fmod",
                      "floor", "memcpy", "memset", "memmove", "_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail"}  # fmt: skip
    assert all(name.startswith("plain_onboard_") for kind, name in symbols if kind.isupper() and kind != "U")
    assert not {kind for kind, _ in symbols} & set("BbCD"), "no variable is shared by the states"


def test_the_program_next_to_it_measures_a_stop(library: Path, tmp_path: Path):
    shutil.copy(library / "worst_case.c", tmp_path)
    binary = compiled(tmp_path / "worst_case.c", library, "-lpthread")
    text = subprocess.run(
        [str(binary), str(library / "readings.csv")], capture_output=True, text=True, check=True
    ).stdout
    median, worst, longest = (float(x) for x in re.findall(r"([\d.]+) us", text))
    state, stack = (int(x) for x in re.findall(r"(\d+) bytes", text))
    assert 0 < median <= worst <= longest
    assert 0 < stack < 1 << 20
    declared = re.search(r"memory\[(\d+)\]", (library / "plain_onboard.h").read_text())
    assert declared is not None
    assert state > 8 * int(declared[1])


def test_the_command_writes_the_library(tmp_path: Path):
    """Without estimator and valves it is smaller, and consists of one unit."""
    assert exit_code("export", LIBRARY / "plain.toml", "--library", "--out", tmp_path, *SHORT) == 0
    assert (tmp_path / "libplain_onboard.a").is_file()
    assert not (tmp_path / "sources" / "plain.c").exists()
    shutil.copy(tmp_path / "worst_case.c", tmp_path / "program.c")
    compiled(tmp_path / "program.c", tmp_path, "-lpthread")


@pytest.mark.skipif(bool(missing_programs()), reason=f"not on the PATH: {', '.join(missing_programs())}")
def test_the_onboard_part_decides_on_a_microcontroller_as_here(tmp_path: Path, capsys):
    """The quick form of `make target`, by the command `tools target`."""
    assert exit_code("tools", "target", "--quick", "--out", tmp_path) == 0
    assert "is counted as 200,000." in capsys.readouterr().out
    rows = [*csv.DictReader((tmp_path / "target.csv").open())]
    difference = {row["arithmetic"]: float(row["largest difference"]) for row in rows}
    assert difference["double"] == 0.0 < difference["single"] < 0.01
    for row in rows:
        assert 0 < float(row["stack, painted [kB]"]) <= float(row["stack, computed [kB]"])
        assert 10_000 < float(row["instructions a step, median"]) <= float(row["worst"])
    build = TargetBuild(load(str(LIBRARY / "plain.toml"), [*SHORT[1::2]], []), tmp_path, rows=2)
    (tmp_path / "outputs.bin").symlink_to("/dev/full")
    program = (tmp_path / "target.c").read_text(encoding="utf-8")
    for text, sentence in (
        (program, "cannot write outputs.bin"),
        (program.replace("*CPACR |=", "*CPACR &= ~"), "An exception of the processor"),
    ):
        (tmp_path / "target.c").write_text(text, encoding="utf-8")
        build.compile()
        with pytest.raises(BuildFailed, match=sentence):
            build.run()
