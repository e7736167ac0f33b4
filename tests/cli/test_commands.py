"""Global options and completion work everywhere, and commands print as much as requested."""

import logging
import os
import subprocess
import sys
import threading

import pytest
from test_console import HEAVY

from railgrip.report import console


@pytest.fixture(autouse=True)
def _as_before():
    """A command sets the level of the messages for the whole process."""
    log = logging.getLogger("railgrip")
    level = log.level
    yield
    log.setLevel(level)


@pytest.mark.parametrize("place", [0, 1, 2, 3], ids=str)
@pytest.mark.parametrize(("option", "level"), [("-q", logging.WARNING), ("--verbose", logging.DEBUG)])
def test_global_options_work_before_and_after_a_command(option, level, place, command):
    words = ["train", "check", "emu387"]
    words.insert(place, option)
    assert command(*words).code == 0
    assert logging.getLogger("railgrip").level == level


COMPLETE = """
import sys
from railgrip.__main__ import main
sys.argv = ["railgrip"]
try: main()
finally: print(*sys.modules, file=sys.stderr)
"""


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["railgrip", "camp"], "campaign"),
        (["railgrip", "run", "trap"], "trapezoid"),
        (["railgrip", "train", "show", "em"], "emu387"),
        (["railgrip", "maintain", "reg"], "regress"),
    ],
    ids=str,
)
def test_the_shell_completes_commands_and_names_of_the_library(words, expected):
    """With the environment variables that bash sets."""
    variables = {
        "_RAILGRIP_COMPLETE": "complete_bash",
        "COMP_WORDS": " ".join(words),
        "COMP_CWORD": str(len(words) - 1),
    }
    command = [sys.executable, "-c", COMPLETE]
    done = subprocess.run(command, env=os.environ | variables, capture_output=True, text=True, check=False)
    assert done.stdout.split() == [expected], done.stderr
    if words == ["railgrip", "camp"]:  # completion of the program's own commands imports none of them
        assert HEAVY.isdisjoint(done.stderr.split())


@pytest.mark.skipif(sys.platform == "win32", reason="runs bash")
@pytest.mark.parametrize(
    ("option", "text"),
    [("--show-completion", "_RAILGRIP_COMPLETE"), ("--install-completion", "bash completion installed")],
)
def test_bash_gets_its_completion(option, text, tmp_path):
    shell = ["bash", "-c", f"{sys.executable} -m railgrip {option}; exit $?"]
    done = subprocess.run(
        shell, cwd=tmp_path, env=os.environ | {"HOME": str(tmp_path)}, capture_output=True, text=True, check=False
    )
    assert (done.returncode, text in done.stdout) == (0, True), done.stderr


@pytest.mark.parametrize(("option", "quiet"), [((), False), (("--quiet",), True)])
def test_quiet_prints_results_and_errors_only(railgrip, capfd, option, quiet):
    result = railgrip(*option, "run", "wet.toml", "--set", "description=slide", "--out", "here")
    assert "wet: horizon" in result.out
    assert "no braking distance" in result.err
    before = set(threading.enumerate())
    with console.progress("a stop", "running"):  # without a terminal, a thread prints it
        assert bool(set(threading.enumerate()) - before) is not quiet
    console.remark("a remark")
    assert ("a remark" in capfd.readouterr().err) is not quiet


@pytest.mark.parametrize(("option", "printed"), [((), False), (("-v",), True), (("--quiet",), False)])
def test_verbose_prints_debugging_messages(railgrip, capfd, option, printed):
    railgrip(*option, "report", "nowhere")
    logging.getLogger("railgrip.fmus").debug("a message")
    assert ("a message" in capfd.readouterr().err) is printed
