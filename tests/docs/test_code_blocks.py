"""The Python code of the tutorials, of the README and of other pages runs as printed; of one also the commands."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import done
from project_files import ROOT
from sybil import Example, Sybil
from sybil.parsers.markdown import CodeBlockParser, PythonCodeBlockParser

PAGES = [
    ROOT / "README.md",
    ROOT / "docs/how_to/driver_demand.md",
    ROOT / "docs/how_to/regression.md",
    ROOT / "docs/how_to/type_test.md",
    ROOT / "docs/wheel_flats.md",
    *sorted((ROOT / "docs/tutorials").glob("*.md")),
]
COMMANDS = {ROOT / "docs/how_to/regression.md"}
"""Pages whose commands run, too."""


@pytest.fixture
def commands_in_this_process(
    in_process: None, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Run the commands of railgrip that a page starts in this process, as the pages do not depend on processes.

    A command with its workers would import everything three times.
    """
    start = subprocess.run

    def run(command, **options):
        if list(command[:3]) != [sys.executable, "-m", "railgrip"]:
            return start(command, **options)
        result = done(capfd, *command[3:])
        completed = subprocess.CompletedProcess(command, result.code, result.out, result.err)
        if options.get("check"):
            completed.check_returncode()
        return completed

    monkeypatch.setattr(subprocess, "run", run)


def run_commands(example: Example) -> None:
    """Run the commands of a block; a comment gives the exit code of one that does not succeed."""
    for line in example.parsed.splitlines():
        code = re.search(r"# exit code (\d)", line)
        command = [sys.executable, "-m", *shlex.split(line, comments=True)]
        assert subprocess.run(command, check=False).returncode == int(code[1] if code else 0), line


@pytest.mark.usefixtures("commands_in_this_process")
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_code_blocks_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    # A page may add "." to the path; Python caches the folder of the first import.
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys, "path_importer_cache", {})
    parsers = [PythonCodeBlockParser(), *([CodeBlockParser("sh", run_commands)] if page in COMMANDS else [])]
    examples = list(Sybil(parsers=parsers).parse(page).examples())
    assert examples
    for example in examples:
        example.evaluate()
