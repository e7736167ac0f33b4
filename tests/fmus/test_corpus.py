"""The built-in compiler gives every class of the corpus its right values, or refuses it with file and line.

The corpus (tests/fmus/corpus) has the rules of the language by chapter and the combinations of features and contexts.
Here are all rules and a sample of the combinations, in which each feature and each context occurs; with RAILGRIP_FUZZ
it is all of them, and the classes that are known to be refused. Where OpenModelica is installed, it compiles the rules
too, which checks the expected values themselves.
"""

import multiprocessing
import os
import shutil
from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase

import pebble
import pytest
from corpus.case import Case
from corpus.combine import combinations, sample
from corpus.contexts import CONTEXTS
from corpus.exceptions import REFUSED
from corpus.features import FEATURES
from corpus.rules import RULES
from corpus.verdict import INTERFACES, Simulate, Values, judge, run, simulate
from waiting import LONGEST

from railgrip.base.errors import BuildFailed
from railgrip.fmus.openmodelica import export
from railgrip.fmus.recipe import Recipe

ALL = "RAILGRIP_FUZZ" in os.environ
EVERY = combinations()
COMBINATIONS = EVERY if ALL else sample()
CHAPTERS = ["2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12", "13"]
FAULTS_OF_OPENMODELICA = {
    "3.7.5 change of a Boolean": "change() of a Boolean equation: 0 instead of 1 at some events",
    "8 a linear system whose matrix varies": "tearing divides by an entry of the matrix that is 0 at the start",
}
"""Case → construct with which OpenModelica gives other values than the specification.

The values of the built-in compiler are checked for these cases as for all others.
"""

SIZE = 60
"""Number of cases in one FMU, which saves most of the time of the C compiler."""


def batches(cases: Sequence[Case]) -> list[list[Case]]:
    right = [case for case in cases if not case.may_be_refused]
    return [right[k : k + SIZE] for k in range(0, len(right), SIZE)]


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


@pytest.mark.omc
@pytest.mark.skipif(shutil.which("omc") is None, reason="OpenModelica's omc is not on the PATH")
@pytest.mark.parametrize("cases", [[c for c in RULES if c.name.startswith(k)] for k in CHAPTERS], ids=CHAPTERS)
def test_openmodelica_gives_no_other_values(tmp_path, cases):
    """It may refuse a class. A fault may be mended in its next release."""

    def simulate(text: str, names: Sequence[str]) -> dict[str, Values] | str:
        file = tmp_path / "Corpus.mo"
        file.write_text(text)
        try:
            fmu = export(Recipe.of_class("Corpus.All", "me"), file, tmp_path / "All.fmu")
        except BuildFailed as refusal:
            return f"refused: {refusal}"
        return {"ModelExchange": run(fmu, names, "ModelExchange")}

    wrong = {name: verdict for name, verdict in judge(cases, simulate).items() if verdict.startswith("wrong")}
    assert {name: verdict for name, verdict in wrong.items() if name not in FAULTS_OF_OPENMODELICA} == {}


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
    assert {case.name for case in RULES if not case.may_be_refused} >= FAULTS_OF_OPENMODELICA.keys()


def test_names_are_unique_and_exceptions_exist():
    names = [case.name for case in [*RULES, *EVERY]]
    assert len(set(names)) == len(names)
    patterns = [f"{feature} | {context}" for context in REFUSED for feature in REFUSED[context]]
    assert [p for p in patterns if not any(fnmatchcase(name, p) for name in names)] == []
