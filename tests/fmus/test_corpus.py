"""The built-in compiler gives every class of the corpus its right values, or refuses it with file and line.

The corpus (tests/fmus/corpus) has the rules of the language by chapter and the combinations of features and contexts.
Here are all rules and a sample of the combinations, in which each feature and each context occurs; with RAILGRIP_FUZZ
it is all of them, and the classes that are known to be refused. Where OpenModelica is installed, it compiles the same
cases, which checks the expected values themselves.
"""

import multiprocessing
import os
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase

import numpy as np
import pebble
import pytest
from corpus.case import Case
from corpus.combine import combinations, sample
from corpus.contexts import CONTEXTS
from corpus.exceptions import REFUSED
from corpus.features import FEATURES
from corpus.rules import RULES
from corpus.verdict import INTERFACES, STEP, STOP, Simulate, Values, judge, simulate
from scipy.io import loadmat
from waiting import LONGEST

ALL = "RAILGRIP_FUZZ" in os.environ
EVERY = combinations()
COMBINATIONS = EVERY if ALL else sample()
FAULTS_OF_OPENMODELICA = {
    "8 a linear system whose matrix varies": "tearing divides by an entry of the matrix that is 0 at the start",
    "first result of several | equation the other way round": "several results on the left-hand side of an equation",
    "10.3.4 extremes of an iterator without values": "a 2048th of the largest and the smallest Real",
    "10.5 an assignment at an index that changes": "nothing is assigned at an index that a function computes",
    "11.2.1 elements of an array": "elements of an array that an algorithm assigns at computed indices",
    "semiLinear | constant": "semiLinear in a constant",
    "homotopy | constant": "homotopy in a constant",
    **dict.fromkeys(
        (f"homotopy | {place}" for place in
         ("function body", "protected variable of a function", "loop of a function", "redeclared function")),
        "homotopy in a function",
    ),
}  # fmt: skip
"""Case → construct with which OpenModelica gives other values than the specification, or that it refuses.

The values of the built-in compiler are checked for these cases as for all others.
"""

SIZE = 60
"""Number of cases in one FMU, which saves most of the time of the C compiler."""


def batches(cases: Sequence[Case], size: int = SIZE) -> list[list[Case]]:
    right = [case for case in cases if not case.may_be_refused]
    return [right[k : k + size] for k in range(0, len(right), size)]


@pytest.fixture(scope="module")
def pool() -> Iterator[pebble.ProcessPool]:
    """Return a process that may hang or crash."""
    with pebble.ProcessPool(1, context=multiprocessing.get_context("spawn")) as pool:
        yield pool
        pool.stop()


def apart(pool: pebble.ProcessPool, *interfaces: str) -> Simulate:
    """Return `simulate` of some interfaces in that process."""
    return lambda text, names: pool.schedule(simulate, args=[text, names, interfaces], timeout=LONGEST).result()


@pytest.mark.parametrize(("number", "cases"), [*enumerate(batches([*RULES, *COMBINATIONS]))])
def test_the_values_are_right(pool, number, cases):
    """By one interface in turn; they share the code of equations and events, and other tests compare them."""
    interfaces = INTERFACES if ALL else (INTERFACES[number % 2],)
    assert judge(cases, apart(pool, *interfaces)) == {}


@pytest.fixture
def linkable(tmp_path, monkeypatch):
    """Omc names LAPACK and BLAS when it links; its runtime library has loaded them, also without files to link with."""
    for name in ("lapack", "blas"):
        if subprocess.run(["cc", "-shared", "-o", str(tmp_path / "linked"), f"-l{name}"], check=False).returncode:
            (tmp_path / f"lib{name}.so").write_text("/* a script of the linker that adds nothing */")
    monkeypatch.setenv("LIBRARY_PATH", str(tmp_path))


@pytest.mark.omc
@pytest.mark.skipif(shutil.which("omc") is None, reason="OpenModelica's omc is not on the PATH")
@pytest.mark.parametrize(
    "cases", batches([case for case in [*RULES, *COMBINATIONS] if case.name not in FAULTS_OF_OPENMODELICA], 120)
)
@pytest.mark.usefixtures("linkable")
def test_openmodelica_gives_the_same_values(tmp_path, cases):
    """By its own simulation, which compiles no runtime; when an importer finds the events of its FMUs is not judged."""

    def simulate(text: str, names: Sequence[str]) -> dict[str, Values] | str:
        (tmp_path / "Corpus.mo").write_text(text)
        (tmp_path / "run.mos").write_text(
            'loadFile("Corpus.mo"); getErrorString();\n'
            f"simulate(Corpus.All, stopTime={STOP}, numberOfIntervals={round(STOP / STEP)}, tolerance=1e-9, "
            'outputFormat="mat", cflags="-O0", simflags="-noEventEmit"); getErrorString();\n'
        )
        result = tmp_path / "Corpus.All_res.mat"
        result.unlink(missing_ok=True)
        ran = subprocess.run(["omc", "-n=2", "run.mos"], cwd=tmp_path, capture_output=True, text=True, check=False)
        if not result.exists():
            return f"refused: {ran.stdout}"
        found = loadmat(result, chars_as_strings=False)
        # A variable is a row of the constants or of the trajectories, of which the first is time; the row is negative
        # for an alias with the other sign.
        place = {"".join(name).rstrip("\0 "): k for k, name in enumerate(found["name"].T)}
        # Of the values before and after the events at the start, the last are those of the start.
        begin = np.flatnonzero(found["data_2"][0] == 0.0)[-1]
        length = found["data_2"].shape[1] - begin

        def values(name: str) -> np.ndarray:
            table, row = found["dataInfo"][:2, place[name]]
            rows = found[f"data_{max(table, 1)}"]
            return np.sign(row) * np.resize(rows[abs(row) - 1][begin if table != 1 else 0 :], length)

        return {"simulation": {"time": found["data_2"][0][begin:], **{name: values(name) for name in names}}}

    assert judge(cases, simulate) == {}


@pytest.mark.parametrize(
    "case",
    [c for c in [*RULES, *COMBINATIONS] if c.may_be_refused],
    ids=lambda case: case.name,
)
@pytest.mark.skipif(not ALL, reason="only with RAILGRIP_FUZZ")
def test_what_need_not_be_supported_is_right_or_refused(pool, case):
    verdict = judge([case], apart(pool, *INTERFACES)).get(case.name, "right")
    assert verdict == "right" or verdict.startswith("refused: ")


def test_every_feature_and_context_is_in_the_sample():
    pairs = [case.name.split(" | ") for case in sample()]
    assert {feature for feature, _ in pairs} == FEATURES.keys()
    assert {context for _, context in pairs} == CONTEXTS.keys()


def test_faults_of_openmodelica_are_cases_that_the_built_in_compiler_must_get_right():
    assert {case.name for case in [*RULES, *EVERY] if not case.may_be_refused} >= FAULTS_OF_OPENMODELICA.keys()


def test_names_are_unique_and_exceptions_exist():
    names = [case.name for case in [*RULES, *EVERY]]
    assert len(set(names)) == len(names)
    patterns = [f"{feature} | {context}" for context in REFUSED for feature in REFUSED[context]]
    assert [p for p in patterns if not any(fnmatchcase(name, p) for name in names)] == []
