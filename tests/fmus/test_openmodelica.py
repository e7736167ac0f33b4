"""The OpenModelica side: script and answers with a stand-in, and the real one where it is installed."""

import shutil
import stat
from pathlib import Path

import fmpy
import numpy as np
import pytest

from fmus import openmodelica
from fmus.build import build_one
from fmus.errors import BuildFailed, CompilerMissing
from fmus.recipe import Recipe, read_recipes

RECIPE = Recipe.model_validate(
    {"class": "Lib.FMUs.Plant", "interfaces": ["cs"], "solver": "rodas3", "tolerance": 1e-5, "step": 1e-3}
)


@pytest.fixture
def omc(tmp_path, monkeypatch):
    """Return a function that puts an `omc` on the PATH which runs the given shell lines."""
    folder = tmp_path / "bin"
    folder.mkdir()

    def stand_in(*lines: str) -> Path:
        file = folder / "omc"
        file.write_text("\n".join(["#!/bin/sh", *lines, ""]))
        file.chmod(file.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv("PATH", f"{folder}:/bin:/usr/bin")
        openmodelica.version_line.cache_clear()
        return file

    yield stand_in
    openmodelica.version_line.cache_clear()


def test_the_script_loads_the_package_as_a_user_would(tmp_path):
    library = tmp_path / "Lib"
    library.mkdir()
    lines = openmodelica.script(RECIPE, library).splitlines()
    assert lines[0] == 'setCommandLineOptions("--fmiFlags=s:cvode");'
    assert f'loadFile("{library / "package.mo"}");' in lines
    (build,) = [line for line in lines if line.startswith("buildModelFMU")]
    assert build.startswith('buildModelFMU(Lib.FMUs.Plant, version="2.0", fmuType="cs"')
    assert lines.count("getErrorString();") == 3


def test_model_exchange_asks_for_no_solver(tmp_path):
    both = openmodelica.script(RECIPE.model_copy(update={"interfaces": ("me", "cs")}), tmp_path)
    me = openmodelica.script(RECIPE.model_copy(update={"interfaces": ("me",)}), tmp_path)
    assert 'fmuType="me_cs"' in both
    assert 'fmuType="me"' in me
    assert "cvode" not in me


def test_errors_are_told_from_warnings():
    printed = '''true
"Notification: Automatically loaded package Complex.
"
"[/lib/A.mo:3:5-3:20:writable] Error: Variable k not found in scope Lib.A.
[/lib/A.mo:9:1-9:2:writable] Warning: Something is odd
 on two lines.
Error: Error occurred while flattening model Lib.A
"
""'''
    assert openmodelica.errors(printed) == [
        "[/lib/A.mo:3:5-3:20:writable] Error: Variable k not found in scope Lib.A.",
        "Error: Error occurred while flattening model Lib.A",
    ]


def test_the_fmu_it_made_is_put_in_place(omc, tmp_path):
    omc("printf 'an fmu' > Lib_FMUs_Plant.fmu", 'echo true; echo "\\"Lib_FMUs_Plant.fmu\\""')
    made = openmodelica.export(RECIPE, tmp_path, tmp_path / "out" / "Plant.fmu")
    assert made.read_text() == "an fmu"


def test_its_error_is_passed_on(omc, tmp_path):
    omc("echo '\"[/lib/A.mo:3:5-3:20:writable] Error: Variable k not found in scope Lib.A.'", "echo '\"'")
    with pytest.raises(BuildFailed, match=r"could not build Lib\.FMUs\.Plant:\n.*Variable k not found"):
        openmodelica.export(RECIPE, tmp_path, tmp_path / "Plant.fmu")


def test_silence_without_an_fmu_is_an_error_too(omc, tmp_path):
    omc("exit 0")
    with pytest.raises(BuildFailed, match="omc ended with 0"):
        openmodelica.export(RECIPE, tmp_path, tmp_path / "Plant.fmu")


def test_no_omc_is_said(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CompilerMissing, match="omc is not on the PATH"):
        openmodelica.export(RECIPE, tmp_path, tmp_path / "Plant.fmu")


needs_omc = pytest.mark.skipif(shutil.which("omc") is None, reason="OpenModelica's omc is not on the PATH")


@pytest.mark.omc
@needs_omc
@pytest.mark.parametrize("name", [n for n in read_recipes().recipes if n != "ContactPoint"])
def test_both_compilers_give_the_same_trajectory(name, tmp_path):
    """Three seconds of braking, every output within 1e-4 of its largest value: two solvers, 1e-6 or less."""
    from test_train_fmus import held

    recipe = read_recipes()[name]
    kind = "CoSimulation" if "cs" in recipe.interfaces else "ModelExchange"
    found = []
    for compiler in ("native", "openmodelica"):
        path = build_one(name, compiler, tmp_path / compiler).path
        description = fmpy.read_model_description(str(path), validate=False)
        inputs = [v.name for v in description.modelVariables if v.causality == "input"]
        outputs = sorted(v.name for v in description.modelVariables if v.causality == "output")
        signals = np.array(
            [(t, *map(held, inputs)) for t in (0.0, 3.0)],
            dtype=[("time", float), *((n, float) for n in inputs)],
        )
        settings = {"start_values": {"_tolerance": 1e-7}} if (compiler, kind) == ("native", "CoSimulation") else {}
        result = fmpy.simulate_fmu(
            str(path), stop_time=3.0, input=signals, output=outputs, output_interval=0.015, fmi_type=kind,
            relative_tolerance=1e-7, **settings,
        )  # fmt: skip
        found.append((inputs, outputs, result))
    (inputs, outputs, native), (other_inputs, other_outputs, other) = found
    assert sorted(inputs) == sorted(other_inputs)
    assert outputs == other_outputs
    for n in outputs:
        a, b = native[n].astype(float), np.interp(native["time"], other["time"], other[n].astype(float))
        assert np.max(np.abs(a - b)) <= 1e-4 * np.max(np.abs(a)) + 1e-9, n
