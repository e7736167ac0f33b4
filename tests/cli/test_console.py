"""Console output, on a terminal and without one."""

import itertools
import os
import pty
import re
import subprocess
import sys
import threading
import time

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from waiting import LONGEST

from railgrip.base.activity import FOLDER, activity
from railgrip.report import console
from railgrip.report.table import ReportTable

HEAVY = {"casadi", "h5py", "matplotlib", "numpy", "pandas", "pint", "scipy", "xarray"}


def printed_with_modules(program: str) -> list[str]:
    ask = f"import sys\n{program}\nprint(*sys.modules)"
    result = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout.splitlines()


def test_help_imports_no_heavy_library():
    """These imports take seconds, and help needs none of them."""
    program = "from railgrip.__main__ import main\ntry: main(['--help'])\nexcept SystemExit: pass"
    *printed, modules = printed_with_modules(program)
    assert "campaign" in " ".join(printed)
    assert (HEAVY | {"pydantic"}).isdisjoint(modules.split())


def test_stops_import_no_scipy_before_they_need_it():
    """Every worker process imports what stops need, and SciPy would be a third of it."""
    (modules,) = printed_with_modules("import railgrip.simulate.run")
    assert "scipy" not in modules.split()


def test_cells_of_a_table_are_printed_unchanged(capfd):
    console.show_table(ReportTable([{"a :x:": "[bold]:x:", "b": "[/]"}], title=":x: [red]t"))
    out = capfd.readouterr().out
    assert ":x: [red]t" in out
    assert "a :x:" in out
    assert "[bold]:x:  [/]" in out


@pytest.mark.parametrize("width", [180, 100, 30])
def test_a_table_wider_than_the_screen_keeps_all_columns(monkeypatch, capfd, width):
    """The numbers alone take more than 180 characters."""
    numbers = {f"change against law {i}": f"−15.8 % [−15.8 %, −15.{i} %]" for i in range(8)}
    row = {"scenario": "random", "controller": "SBC, three-state, searched"} | numbers
    monkeypatch.setattr(console, "_out", console._console(width=width))
    console.show_table(ReportTable([row, row]))
    out = capfd.readouterr().out
    for text in ("scenario", "random", "controller", "SBC,", "searched", *numbers.values()):
        assert text in out


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        ({"total": 8, "is_count": True}, "table1 :x:: drawing [a], 2 of 8, "),
        ({"total": 8}, "table1 :x:: drawing [a], 25 %, "),
        ({"total": 0, "is_count": True}, "table1 :x:: drawing [a], "),
        ({}, "table1 :x:: drawing [a], "),
    ],
)
def test_without_a_terminal_progress_is_printed_now_and_then(monkeypatch, capfd, settings, line):
    monkeypatch.setattr(console, "FIRST_LINE", 0.01)
    monkeypatch.setattr(console, "REMINDER", 0.02)
    wall = itertools.cycle([2e9, 1e9, 0.0])
    monkeypatch.setattr(time, "time", lambda: next(wall))  # a clock that is put forward and back
    before = set(threading.enumerate())
    with console.progress("table1 :x:", "running", **settings) as bar:
        bar.advance()
        bar.advance()
        bar.update(phase="drawing [a]")
        err = ""
        while line not in err:  # otherwise the test hangs, which is also a failure
            err += capfd.readouterr().err
    assert "\x1b" not in err
    assert set(re.findall(r", (\S+) s\n", err)) == {"0"}
    assert set(threading.enumerate()) <= before


def test_a_task_that_ends_before_the_first_line_prints_nothing(monkeypatch, capfd):
    monkeypatch.setattr(console, "FIRST_LINE", LONGEST)
    with console.progress("quick", "running", 1) as bar:
        bar.advance()
    assert capfd.readouterr().err == ""


ODD = st.floats() | st.sampled_from([0.0, -0.0, 5e-324, 1e308, -134.0])
UPDATE = st.fixed_dictionaries({}, optional={"amount": ODD, "total": ODD, "phase": st.sampled_from(["", "drawing"])})


@example(total=0.4, is_count=True, updates=["advance"])
@given(total=st.none() | ODD, is_count=st.booleans(), updates=st.lists(UPDATE | st.just("advance"), max_size=6))
def test_progress_names_a_phase_and_is_between_nothing_and_all(total, is_count, updates):
    shown = console.Progress("stop", "compiling", total, is_count)
    for update in updates:
        shown.advance() if update == "advance" else shown.update(**update)
        name, phase, measure = re.fullmatch(r"(\w+): (\w+)(?:, (.+))?", str(shown)).groups()
        assert (name, bool(phase)) == ("stop", True)
        if measure and is_count:
            done, all_ = map(float, measure.split(" of "))
            assert 0 <= done <= all_
            assert all_ > 0
        elif measure:
            assert 1 <= float(measure.removesuffix(" %")) <= 100


def test_compilers_of_this_process_and_its_workers_are_displayed(monkeypatch, tmp_path):
    shown = console.Progress("table1", "running stops", 2, is_count=True)
    monkeypatch.setenv(FOLDER, str(tmp_path))
    with activity("compiling A"):
        worker = "from railgrip.base.activity import *\nwith activity('compiling B'): input()"
        with subprocess.Popen([sys.executable, "-c", worker], stdin=subprocess.PIPE) as process:
            while len(list(tmp_path.iterdir())) < 2:
                assert process.poll() is None
            while "B" not in (line := str(shown)):
                assert process.poll() is None
            process.communicate(b"\n")
        assert sorted(line.split(": ")[1].split(", ")) == ["0 of 2", "compiling A", "compiling B"]
        assert str(shown) == "table1: compiling A, 0 of 2"
    assert str(shown) == "table1: running stops, 0 of 2"


WATCHED = """
from railgrip.report import console
from railgrip.report.table import ReportTable
with console.progress("stop :x:", "[red]drawing", 4, is_count=True) as shown:
    shown.advance()
with console.progress("endless", "start") as shown:
    shown.update(phase="work", total=0)
console.say("result :x:")
"""


def test_a_terminal_has_a_progress_bar():
    ours, theirs = pty.openpty()
    with subprocess.Popen(
        [sys.executable, "-c", WATCHED], stdout=theirs, stderr=theirs, env=os.environ | {"TERM": "xterm"}
    ) as process:
        os.close(theirs)
        screen = b""
        try:
            while piece := os.read(ours, 4096):
                screen += piece
        except OSError:  # the end of a terminal on Linux
            pass
        os.close(ours)
    assert process.returncode == 0, screen
    text = screen.decode()
    assert "stop :x:: [red]drawing" in text
    assert "1 of 4" in text
    assert "endless: work" in text
    assert "result :x:" in text
