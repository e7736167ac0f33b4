"""The list of tests that `make test` leaves out names only tests that exist, and none that notices mutants."""

import re
import tomllib

import pytest
from floors import required
from project_files import ROOT

LEFT_OUT = tomllib.loads((ROOT / "tests/left_out.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("file", LEFT_OUT)
def test_each_test_left_out_exists(file):
    text = (ROOT / file).read_text(encoding="utf-8") if (ROOT / file).exists() else ""
    found = set(re.findall(r"^def (test_\w+)", text, re.MULTILINE))
    gone = sorted({test.partition("[")[0] for test in LEFT_OUT[file]} - found)
    assert not gone, f"tests/left_out.toml: remove {', '.join(gone)}, or write the file anew with `make floors`"


def test_all_tests_that_notice_mutants_decide():
    left_out = [f"{file}::{test}" for file, tests in LEFT_OUT.items() for test in tests if required(f"{file}::{test}")]
    assert not left_out, "tests/left_out.toml: `make mutants` counts on these, so that `make test` must run them"
