"""The OpenModelica side: script and answers, with a substitute for omc; test_both_compilers.py needs the real one."""

import re
import stat
import subprocess
import warnings
from pathlib import Path

import pytest

from railgrip.base.errors import BuildFailed, CompilerMissing
from railgrip.fmus import openmodelica
from railgrip.fmus.build import build_one
from railgrip.fmus.recipe import Cookbook, Recipe

RECIPE = Recipe.model_validate(
    {"class": "Lib.FMUs.Plant", "interfaces": ["cs"], "solver": "rodas3", "tolerance": 1e-5, "step": 1e-3}
)


PREDICTION = RECIPE.model_copy(update={"interfaces": ("me",)})


@pytest.fixture
def omc(tmp_path, monkeypatch):
    """Return a function that puts an `omc` on the PATH that runs the given shell lines."""
    folder = tmp_path / "bin"
    folder.mkdir()

    def stand_in(*lines: str) -> Path:
        file = folder / "omc"
        file.write_text("\n".join(["#!/bin/sh", *lines, ""]))
        file.chmod(file.stat().st_mode | stat.S_IXUSR)
        for name in ("cmake", "make", "zip"):
            (folder / name).write_text("#!/bin/sh\n")
            (folder / name).chmod(0o755)
        monkeypatch.setenv("PATH", f"{folder}:/bin:/usr/bin")
        openmodelica.version_line.cache_clear()
        return file

    yield stand_in
    openmodelica.version_line.cache_clear()


@pytest.fixture
def library(tmp_path):
    folder = tmp_path / "Lib"
    folder.mkdir()
    (folder / "package.mo").write_text("package Lib end Lib;")
    return folder


def test_the_script_loads_the_package_as_a_user_would(library):
    lines = openmodelica.script(RECIPE, library, derivatives=False).splitlines()
    assert lines[0] == 'setCommandLineOptions("--fmiFlags=s:cvode");'
    assert f'loaded1 := loadFile("{library / "package.mo"}");' in lines
    (build,) = [line for line in lines if line.startswith("buildModelFMU")]
    assert lines.index("if loaded0 and loaded1 then") < lines.index(build)
    assert build.startswith('buildModelFMU(Lib.FMUs.Plant, version="2.0", fmuType="me_cs"')
    assert lines.count("getErrorString();") == 3
    assert lines.index("addClassAnnotation(Lib.FMUs.Plant, annotate=experiment(Tolerance=1e-08));") < lines.index(build)


CVODE, DERIVATIVES, STATES = "--fmiFlags=s:cvode", "-d=-disableDirectionalDerivatives", "-d=fmuExperimental"
OPTIONS = {f'setCommandLineOptions("{option}");' for option in (CVODE, DERIVATIVES, STATES)}


@pytest.mark.parametrize(
    ("recipe", "interface", "options"),
    [
        # Never "cs" alone, OpenModelica issues 9782 and 9785: inputs count as constant in the derivatives of outputs.
        (RECIPE, "me_cs", {CVODE}),
        (RECIPE.model_copy(update={"interfaces": ("me", "cs")}), "me_cs", {CVODE}),
        (PREDICTION, "me", {DERIVATIVES}),
        (Recipe.of_class("Lib.Prediction", "me_cs"), "me_cs", {CVODE, DERIVATIVES, STATES}),
    ],
)
def test_the_script_requests_interface_solver_and_derivatives(tmp_path, recipe, interface, options):
    text = openmodelica.script(recipe, tmp_path, derivatives=DERIVATIVES in options)
    assert f'fmuType="{interface}"' in text
    assert set(text.splitlines()) & OPTIONS == {f'setCommandLineOptions("{option}");' for option in options}


def test_errors_are_distinguished_from_warnings():
    printed = '''true
"Notification: Automatically loaded package Complex.
"
"[/lib/A.mo:3:5-3:20:writable] Error: Variable k not found in scope Lib.A.
[/lib/A.mo:9:1-9:2:writable] Warning: Something is odd
 on two lines.
[/omc/A.mo:1:1-1:2:writable] Internal error: Lost the way.
Error: Error occurred while flattening model Lib.A
"
""'''
    assert openmodelica.errors(printed) == [
        "[/lib/A.mo:3:5-3:20:writable] Error: Variable k not found in scope Lib.A.",
        "[/omc/A.mo:1:1-1:2:writable] Internal error: Lost the way.",
        "Error: Error occurred while flattening model Lib.A",
    ]


UNSET = (
    "[/lib/A.mo:7:3-7:55:writable] Warning: Parameter bogie1.axle.contact.r has no value, and is fixed during "
    "initialization (fixed=true), using available start value (start=0.38) as default value."
)


def test_a_parameter_without_a_value_fails_the_build(omc, tmp_path):
    """A modifier lost in a redeclaration is otherwise invisible: FMUs stopped 19 % short without an error."""
    omc("printf 'an fmu' > Lib_FMUs_Plant.fmu", f"echo '\"Warning: Something is odd.'; echo '{UNSET}'; echo '\"'")
    with pytest.raises(BuildFailed, match=r"start values of Lib\.FMUs\.Plant .*\n.*contact\.r has no value") as failure:
        openmodelica.export(RECIPE, tmp_path, tmp_path / "Plant.fmu")
    assert "odd" not in str(failure.value)
    # A parameter of the class itself is set by the caller of the FMU.
    assert openmodelica.unset(UNSET.replace("bogie1.axle.contact.r ", "r_wheel[1] ")) == []
    assert not (tmp_path / "Plant.fmu").exists()


def test_an_error_is_reported_even_if_there_is_an_fmu(omc, tmp_path):
    omc("printf 'an fmu' > Lib_FMUs_Plant.fmu", "echo '\"Error: Internal error createFMIModelDerivatives failed'")
    with pytest.warns(UserWarning, match=r"built Lib\.FMUs\.Plant, but reports:\nError: .*createFMIModelDerivatives"):
        openmodelica.export(RECIPE, tmp_path, tmp_path / "Plant.fmu")


SULKS = (
    "if grep -q DirectionalDerivatives export.mos; then echo '\"Error: No derivatives.\"'; exit 0; fi",
    "printf 'an fmu' > Lib_FMUs_Plant.fmu",
)


def test_a_plant_is_built_without_derivatives_or_a_warning(omc, tmp_path):
    omc(*SULKS, 'echo true; echo "\\"Lib_FMUs_Plant.fmu\\""')
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = openmodelica.export(RECIPE, tmp_path, tmp_path / "out" / "Plant.fmu")
    assert result.read_text() == "an fmu"


def test_a_prediction_is_built_again_without_derivatives(omc, tmp_path):
    omc(*SULKS)
    with pytest.warns(UserWarning, match=r"built Lib\.FMUs\.Plant without directional derivatives, .*\nError: No der"):
        result = openmodelica.export(PREDICTION, tmp_path, tmp_path / "Plant.fmu")
    assert result.read_text() == "an fmu"


def test_omc_runs_again_only_after_a_change(omc, own_cache, library, tmp_path):
    """A different version line counts as a change, and so does a changed Modelica file."""
    book = Cookbook(file=tmp_path / "recipes.toml", recipes={"Plant": RECIPE})

    def action() -> str:
        return build_one("Plant", "openmodelica", tmp_path / "out", book=book, library=library).action

    def answering(version: str) -> None:
        omc(f'if [ "$1" = --version ]; then echo {version}; else printf {version} > Lib_FMUs_Plant.fmu; fi')

    answering("1.26")
    assert [action(), action()] == ["built", "current"]
    answering("1.27")
    assert [action(), action()] == ["built", "current"]
    assert (tmp_path / "out" / "Plant.fmu").read_text() == "1.27"
    (library / "package.mo").write_text('package Lib "other" end Lib;')
    assert action() == "built"


CRASH = ("echo true", "seq 1 40", "echo 'Segmentation fault (core dumped)' >&2")
"""The values of the commands before a crash, `true`, say nothing."""
TELLING = "part7.c:3:1: fatal error: 'x.h' file not found"
FAILING_MAKE = (
    "echo '\"Error: Error building simulator. Build log: cmake ..'; seq -f 'clang -O2 -c part%g.c' 150",
    f"echo \"{TELLING}\"; echo 'make: 1'; echo '\"'",
)
"""omc reports the whole log as one error."""


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["echo '\"[/lib/A.mo:3:5-3:20:writable] Error: Variable k not found.'"], r"\[.*Variable k not found\."),
        (["exit 0"], r"omc ended with 0 .*"),
        (["seq 1 200"], r"1\n190\n191\n.*\n200\nAll 200 lines are in .*Plant\.log\."),
        (FAILING_MAKE, rf"Error: .* cmake \.\.\n{re.escape(TELLING)}\nAll 153 lines are in .*Plant\.log\."),
        ([*CRASH, "exit 3"], r"omc ended with exit status 3\n.*Segmentation fault \(core dumped\)\n.*"),
        ([*CRASH, "kill -SEGV $$"], r"omc ended with signal SIGSEGV\n.*Segmentation fault \(core dumped\)\n.*"),
    ],
    ids=["an error", "nothing", "a long log", "a failing make", "an exit status", "a crash"],
)
def test_the_end_of_omc_without_an_fmu_is_passed_on(omc, tmp_path, lines, words):
    omc(*lines)
    with pytest.raises(BuildFailed) as failure:
        openmodelica.export(RECIPE, tmp_path, tmp_path / "Plant.fmu")
    assert re.fullmatch(rf"OpenModelica could not build Lib\.FMUs\.Plant:\n{words}", str(failure.value), re.DOTALL)


@pytest.mark.parametrize("copied", [True, False])
def test_the_log_named_in_a_message_exists_after_the_build(omc, own_cache, library, tmp_path, copied):
    book = Cookbook(file=tmp_path / "recipes.toml", recipes={"Plant": PREDICTION})
    # The first attempt, with directional derivatives, fails with a long log; the second yields an FMU.
    omc(
        'if [ "$1" = --version ]; then echo 1.27; exit 0; fi',
        "if grep -q DirectionalDerivatives export.mos",
        "then echo '\"Error: Build log:'; seq 1 200; echo '\"'; exit 0; fi",
        "printf 'an fmu' > Lib_FMUs_Plant.fmu",
    )
    directory = tmp_path / "out" if copied else None
    with pytest.warns(UserWarning, match=r"All 201 lines are in ") as warned:
        fmu = build_one("Plant", "openmodelica", directory, book=book, library=library).path
    log = Path(str(warned[0].message).rpartition("All 201 lines are in ")[2].rstrip("."))
    assert log.read_text().splitlines()[1:] == [str(k) for k in range(1, 201)]
    assert not copied or log.parent == fmu.parent


def test_programs_that_omc_needs_are_required_before_it_runs(omc, monkeypatch, tmp_path):
    """A build without zip would end in omc's own words after minutes, and be repeated without derivatives."""
    folder = omc(f"touch {tmp_path / 'ran'}").parent
    (folder / "cmake").unlink()
    (folder / "zip").unlink()
    monkeypatch.setenv("PATH", str(folder))
    with pytest.raises(CompilerMissing, match="its omc needs cmake and zip, which the PATH does not have; install"):
        openmodelica.export(PREDICTION, tmp_path, tmp_path / "Plant.fmu")
    assert not (tmp_path / "ran").exists()


def test_the_number_of_c_compilers_is_bounded_and_large_units_are_compiled_quickly(omc, tmp_path):
    """omc runs a compiler for each of its files at once; gcc -O3 takes minutes for tables of start values."""
    (tmp_path / "large.c").write_text("/*" + 1_000_000 * "x" + "*/")
    (tmp_path / "small.c").write_text("")
    compile_all = "for f in large small; do $launcher echo cc -O3 -c $f.c; done"
    omc(
        'test "$1" = -n=2 || exit 1; launcher=$(echo "$CMAKE_C_COMPILER_LAUNCHER" | tr ";" " ")',
        f"(cd {tmp_path}; {compile_all}) > {tmp_path / 'log'}",
        "printf 'an fmu' > Lib_FMUs_Plant.fmu",
    )
    openmodelica.export(RECIPE, tmp_path, tmp_path / "Plant.fmu")
    assert (tmp_path / "log").read_text().splitlines() == ["cc -O3 -c large.c -O1", "cc -O3 -c small.c"]


@pytest.mark.parametrize(
    ("options", "text", "compilations"),
    [("", "", 1), ("-DN=3", "", 1), ("-O2", "", 2), ("-DM=3", "", 2), ("", "int b;", 2)],
)
def test_a_unit_of_the_runtime_is_compiled_once(omc, own_cache, tmp_path, options, text, compilations):
    """In another folder, whatever its name, unless options, macros that it uses or its text are others."""
    compiler = tmp_path / "cc"
    compiler.write_text(f'#!/bin/sh\ncase "$*" in *-E*) ;; *-c*) echo >> {tmp_path / "log"} ;; esac\nexec cc "$@"\n')
    compiler.chmod(0o755)
    for build, (further, more) in enumerate([("", ""), (options, text)]):
        unit = tmp_path / f"{build}.fmutmp" / "sources" / "util" / "unit.c"
        unit.parent.mkdir(parents=True)
        unit.write_text(f"#ifdef M\nint m = M;\n#endif\nconst char *a(void) {{ return __FILE__; }}\n{more}\n")
        omc(
            'launcher=$(echo "$CMAKE_C_COMPILER_LAUNCHER" | tr ";" " ")',
            f"$launcher {compiler} {further} -MD -MF unit.d -o unit.o -c {unit} && cp unit.o Lib_FMUs_Plant.fmu",
        )
        fmu = openmodelica.export(RECIPE, tmp_path, tmp_path / f"{build}.fmu")
        alone = tmp_path / "alone.o"
        subprocess.run(["cc", *further.split(), "-o", str(alone), "-c", str(unit)], check=True)
        assert len(fmu.read_bytes()) == len(alone.read_bytes())
    assert len((tmp_path / "log").read_text().splitlines()) == compilations


def test_a_plant_for_one_or_both_interfaces_is_the_same_fmu_of_omc():
    both = RECIPE.model_copy(update={"interfaces": ("me", "cs"), "solver": "cvode", "tolerance": 1e-6})
    assert openmodelica.recipe_digest(both) == openmodelica.recipe_digest(RECIPE)
    assert openmodelica.recipe_digest(PREDICTION) != openmodelica.recipe_digest(RECIPE)


def test_a_missing_omc_is_reported(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CompilerMissing, match="omc is not on the PATH"):
        openmodelica.export(RECIPE, tmp_path, tmp_path / "Plant.fmu")
