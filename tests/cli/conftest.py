"""Small projects, and the command line with a runner that needs no FMU."""

import os
import signal
import subprocess
import sys

import pytest
import synthetic_runner
from project_files import ROOT
from synthetic import LIBRARY

from railgrip.simulate import run

# Like `python -m railgrip`, except that stops come from tests/synthetic_runner.py.
PROGRAM = """
import sys, synthetic_runner
sys.modules["railgrip.simulate.run"] = synthetic_runner
from railgrip.__main__ import main
if __name__ == "__main__":
    main()
"""

CAMPAIGN = """
name = "pair"
scenarios = ["{scenario}"]

[axes.controller.sbc]
controller.kind = "slip_two_state"

[axes.controller.abc]
controller.kind = "adhesion_based"
"""


@pytest.fixture
def project(tmp_path):
    """A folder with wet.toml (coarse and quick) and pair.toml."""
    text = (LIBRARY / "trapezoid.toml").read_text(encoding="utf-8")
    text = text.replace('name = "trapezoid"', 'name = "wet"').replace('"1 ms"', '"10 ms"')
    (tmp_path / "wet.toml").write_text(text, encoding="utf-8")
    (tmp_path / "pair.toml").write_text(CAMPAIGN.format(scenario="wet.toml"), encoding="utf-8")
    (tmp_path / "program.py").write_text(PROGRAM, encoding="utf-8")
    return tmp_path


@pytest.fixture
def railgrip(project, monkeypatch, command):
    """Run a command in the project, in this process; campaigns still start worker processes."""
    monkeypatch.chdir(project)
    own = run.run_stop
    monkeypatch.setattr("railgrip.simulate.run.run_stop", synthetic_runner.run_stop)
    yield command
    # A module that a command has imported just now would keep the replacement.
    for name, module in list(sys.modules.items()):
        if name.startswith("railgrip.") and getattr(module, "run_stop", None) is synthetic_runner.run_stop:
            module.run_stop = own


@pytest.fixture
def program():
    """Return a function that starts Python in a folder as a separate process group, as a shell does."""
    processes = []

    def start(folder, *arguments, **variables):
        process = subprocess.Popen(
            [sys.executable, *arguments],
            cwd=folder,
            env=os.environ | {"PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests'}", "COLUMNS": "200"} | variables,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,  # so that a Ctrl-C sent by the test also reaches the workers, as in a terminal
        )
        processes.append(process)
        return process

    yield start
    for process in processes:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
