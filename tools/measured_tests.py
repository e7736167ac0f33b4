"""Plugin of pytest that measures what each test runs, for tools/floors.py."""

import json
import os
from collections.abc import Generator
from pathlib import Path

import coverage
import pytest


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, bool, bool]:
    """Measure a test, and the processes that it starts, under its name."""
    measured = coverage.Coverage.current()
    assert measured is not None, "started with the process"
    os.environ["COVERAGE_TEST"] = item.nodeid
    measured.switch_context(item.nodeid)
    before = sum(os.times()[:4])
    try:
        return (yield)
    finally:
        with Path(os.environ["COVERAGE_PLACE"], "seconds.jsonl").open("a", encoding="utf-8") as file:
            file.write(json.dumps([item.nodeid, sum(os.times()[:4]) - before]) + "\n")
        os.environ["COVERAGE_TEST"] = ""
        measured.switch_context("")
