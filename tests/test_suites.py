"""The runner of other people's suites, tools/suites.py, gives small suites the verdicts that they deserve."""

import csv
import math
import re
import shutil
import subprocess
import sys
from pathlib import Path

import commands
import compilers
import pytest
import suites

from railgrip.base.errors import InputError

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the runner forks a process for each class")

HEAD = "within ModelicaCompliance;\nmodel {name}\n  extends Icons.TestCase;\n"
TAIL = (
    "  annotation(__ModelicaAssociation(TestCase(shouldPass = {legal})), experiment(StopTime = 0.02));\nend {name};\n"
)
STATE = "  Real x(start=1, fixed=true);\nequation\n  der(x) = 1;\n"
CLASSES = {
    "Right": ("true", STATE + '  assert(x >= 1, "x, at least");\n  assert(time < 2, "end");\n'),
    "Idle": ("true", STATE + '  if false then\n    assert(x > 1, "never");\n  end if;\n'),
    "Wrong": ("true", STATE + '  assert(x < 1.01, "x");\n'),
    "Refused": ("true", STATE + "  Real y = unknownFunction(x);\n"),
    "Illegal": ("false", "  Real x = true;\n"),
    "Accepted": ("false", STATE),
    "Constant": ("true", 'equation\n  assert(2 > 1, "no variable");\n'),
}


def write_library(place: Path) -> None:
    """Write a compliance library with the classes into a folder."""
    folder = place / "ModelicaCompliance"
    folder.mkdir(parents=True)
    (folder / "package.mo").write_text("package ModelicaCompliance end ModelicaCompliance;")
    (folder / "Icons.mo").write_text("within ModelicaCompliance; package Icons model TestCase end TestCase; end Icons;")
    for name, (legal, text) in CLASSES.items():
        (folder / f"{name}.mo").write_text((HEAD + text + TAIL).format(name=name, legal=legal))


@pytest.fixture
def library(tmp_path: Path) -> Path:
    write_library(tmp_path)
    return tmp_path


def run(out: Path, *arguments: object) -> dict[str, dict[str, str]]:
    # In a process of its own: the threads of the front end, which other tests start, do not survive a fork.
    command = [sys.executable, "-c", "import suites, typer; typer.run(suites.suites)", *map(str, arguments)]
    subprocess.run([*command, "--out", str(out)], cwd=Path(suites.__file__).parent, check=True)
    with out.open(encoding="utf-8", newline="") as stream:
        return {row["class"].rpartition(".")[2]: row for row in csv.DictReader(stream)}


def test_verdicts_on_a_compliance_library(library: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    rows = run(tmp_path / "out.csv", "compliance", library, "--control")
    verdicts = {name: row["verdict"] for name, row in rows.items()}
    assert verdicts == {
        "Right": "right", "Idle": "right", "Wrong": "wrong", "Refused": "refused", "Illegal": "refused",
        "Accepted": "accepted", "Constant": "right",
    }  # fmt: skip
    assert {name: row["detail"] for name, row in rows.items() if row["verdict"] == "right"} == {
        "Right": "2 assertions, 0 check nothing",
        "Idle": "1 assertions, 1 check nothing",
        "Constant": "1 assertions, 0 check nothing",
    }
    assert "5 legal: 3 right, 1 refused, 1 wrong" in capfd.readouterr().out


@pytest.mark.omc
@pytest.mark.skipif(shutil.which("omc") is None, reason="OpenModelica's omc is not on the PATH")
def test_openmodelica_translates_legal_classes_only(library: Path, tmp_path: Path) -> None:
    rows = run(tmp_path / "out.csv", "compliance", library, "--compiler", "openmodelica")
    expected = dict.fromkeys(CLASSES, "translated") | dict.fromkeys(("Refused", "Illegal"), "refused")
    assert {name: row["verdict"] for name, row in rows.items()} == expected | {"Accepted": "accepted"}


def test_a_build_and_a_step_of_each_plant_are_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Here of a contact point, which is built in a second and makes a step in less than a microsecond."""
    monkeypatch.setattr(compilers, "PLANTS", ("ContactPoint", "ContactPoint"))
    monkeypatch.setattr(commands, "choose", lambda compiler: "native")
    commands.compilers(tmp_path)
    found = capfd.readouterr().out
    first, again = (
        float(*re.findall(rf"build of {which} plant, ContactPoint +([\d.]+) s of processor time", found))
        for which in ("the first", "one more")
    )
    assert first > again  # it is in the cache
    assert re.search(r"step of 1 ms, ContactPoint +\d+ µs", found)


def test_the_page_of_compilers_has_the_results_of_suites(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its durations are measured, which tests/cli/test_every_command.py does for the built-in compiler."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(compilers, "version_line", lambda: "OpenModelica 1")
    monkeypatch.setattr(compilers, "durations", lambda compiler: {"build": f"1 s with {compiler}"})
    verdicts = "True,right", "True,right", "True,refused", "False,refused", "False,refused"
    (tmp_path / "omc-native.csv").write_text("\n".join(["legal,verdict", *verdicts]))
    page = tmp_path / commands.COMPILERS
    page.parent.mkdir(parents=True)
    page.write_text("<!-- compilers: written by `python tools compilers --write` -->\n<!-- end -->\n")
    monkeypatch.setattr(commands, "choose", lambda _: "native")
    with pytest.raises(InputError, match=r"compilers\.md has both compilers, but OpenModelica's omc is not"):
        commands.compilers(tmp_path, write=True)
    monkeypatch.setattr(commands, "choose", lambda _: "openmodelica")
    commands.compilers(tmp_path, write=True)
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in page.read_text().splitlines()]
    assert ["OpenModelica's tests, 3 legal classes", "2 right, 1 refused, 0 wrong", ""] in rows
    assert ["OpenModelica's tests, 2 illegal classes", "2 refused", ""] in rows
    assert ["build", "1 s with native", "1 s with openmodelica"] in rows


def test_the_arguments_of_each_assertion_are_found() -> None:
    text = 'assert(a(1, 2), "x, y"); // assert(b, "")\n assert({b,c}[1] > 0, "assert(d)", AssertionLevel.error);'
    found = [[text[a:b] for a, b in zip([begin, *ends], ends, strict=False)] for begin, ends in suites.assertions(text)]
    assert found == [["a(1, 2)", ', "x, y"'], ["{b,c}[1] > 0", ', "assert(d)"', ", AssertionLevel.error"]]


def test_values_of_a_script_of_openmodelica(tmp_path: Path) -> None:
    (tmp_path / "Decay.mo").write_text(
        "model Decay Real x[1, 2](start={{1, 2}}, each fixed=true); equation der(x) = -x; end Decay;"
    )
    for name, value in (("good", math.exp(-1)), ("bad", 0.4)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "Decay.mo").write_text((tmp_path / "Decay.mo").read_text())
        (tmp_path / name / f"{name}.mos").write_text(
            '// status: correct\nloadFile("Decay.mo");\nsimulate(Decay, stopTime=1.0);\n'
            "val(x[1,1], 1.0);\nval(x[1,2], {0.0, 1.0});\n"
            f"// Result:\n// true\n// record SimulationResult\n// end SimulationResult;\n// {value}\n"
            f"// {{2.0,{2 * math.exp(-1)}}}\n// endResult\n"
        )
    for name, verdict in (("good", "right"), ("bad", "wrong")):
        rows = run(tmp_path / "out.csv", "omc", tmp_path / name)
        assert rows["Decay"]["verdict"] == verdict
    assert "x[1,1] at 1 s" in rows["Decay"]["detail"]


def test_reference_results_of_a_library(tmp_path: Path) -> None:
    library = tmp_path / "Lib"
    library.mkdir()
    (library / "package.mo").write_text(
        "package Lib model Fall Real v(start=0, fixed=true); Real s(start=0, fixed=true); "
        "equation der(v) = 9.81; der(s) = v; end Fall; end Lib;"
    )
    results = tmp_path / "results" / "Lib" / "Fall"
    results.mkdir(parents=True)
    (results / "comparisonSignals.txt").write_text("time\ns\n")
    for factor, verdict in ((1.0, "right"), (1.002, "wrong")):
        rows = [f"{t / 10},{t / 10 * 9.81},{factor * 9.81 / 2 * (t / 10) ** 2}" for t in range(11)]
        (results / "Fall.csv").write_text("\n".join(['"time","v","s"', *rows]) + "\n")
        rows = run(tmp_path / "out.csv", "reference", tmp_path / "results", "--library", library)
        assert rows["Fall"]["verdict"] == verdict


@pytest.mark.parametrize(("total", "verdict"), [(11, "other solution"), (11.1, "wrong")])
def test_another_solution_of_the_equations_is_not_wrong(tmp_path: Path, total: float, verdict: str) -> None:
    """Brown's almost linear function has the roots 1 and, from the same start, (0.97943, ..., 1.2057)."""
    (tmp_path / "n.mo").write_text(
        "package nonlinear_system model problem7 Real x[10](each start=1.5); equation for i in 1:9 loop"
        f" 0 = x[i] + sum(x) - {total}; end for; product(x) = 1; end problem7; end nonlinear_system;"
    )
    (tmp_path / "n.mos").write_text(
        'loadFile("n.mo");\nsimulate(nonlinear_system.problem7, stopTime=0);\n'
        + "".join(f"val(x[{i}], {{0.0}});\n" for i in range(1, 11))
        + "// Result:\n// end SimulationResult;\n"
        + "// {1.0}\n" * 10
        + "// endResult\n"
    )
    assert run(tmp_path / "out.csv", "omc", tmp_path)["problem7"]["verdict"] == verdict
