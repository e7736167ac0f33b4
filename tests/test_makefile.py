"""The Makefile names existing paths, and installs only into environments that it created."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TARGETS = sorted(set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)))
FOLDERS = "harness|tests|docs|controllers|estimators|fmus|modelica"

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="stands in for Python by a shell script")


@pytest.mark.parametrize("target", TARGETS)
def test_paths_in_the_commands_of_a_target_exist(target: str) -> None:
    done = subprocess.run(
        ["make", "--dry-run", "--always-make", target], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    commands = done.stdout.replace("\\\n", " ").splitlines()
    assert commands
    words = [word for command in commands for word in shlex.split(command, comments=True)]
    paths = {word.rpartition("=")[2] for word in words if re.fullmatch(rf"(\S+=)?({FOLDERS})(/\S*)?", word)}
    missing = [path for path in paths if not any(ROOT.glob(path.rstrip("/")))]
    assert not missing


PYTHON = """#!/bin/sh
case "$*" in
  "-m venv "*) mkdir -p "$3/bin"; cp "$0" "$3/bin/python"; chmod +x "$3/bin/python"; touch "$3/pyvenv.cfg" ;;
  "-m pip "*) echo "$0 $*" >> pip.log ;;
esac
"""


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A folder with the Makefile, in which Python creates environments and records the calls of pip."""
    for name in ("Makefile", "pyproject.toml"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    python = tmp_path / "python3"
    python.write_text(PYTHON)
    python.chmod(0o755)
    return tmp_path


def install(clone: Path, *settings: str) -> tuple[int, str, set[str]]:
    """Run `make install`; return exit code, output and the environments that pip installed into."""
    (clone / "pip.log").unlink(missing_ok=True)
    command = ["make", "install", f"PYTHON={clone / 'python3'}", *settings]
    environment = {"PATH": "/usr/bin:/bin"}
    done = subprocess.run(command, cwd=clone, env=environment, capture_output=True, text=True, check=False)
    log = (clone / "pip.log").read_text() if (clone / "pip.log").exists() else ""
    return done.returncode, done.stdout + done.stderr, {line.split("/bin/")[0] for line in log.splitlines()}


def own_environment(folder: Path) -> dict[Path, bytes]:
    """Create an environment like `python3 -m venv`, and return its files."""
    (folder / "bin").mkdir(parents=True)
    (folder / "bin" / "python").write_text("#!/bin/sh\necho touched >> pip.log\n")
    (folder / "pyvenv.cfg").write_text("home = /usr/bin\n")
    return contents(folder)


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_make_creates_venv_once_if_it_is_missing(clone: Path) -> None:
    assert install(clone)[::2] == (0, {".venv"})
    assert install(clone)[::2] == (0, set())


@pytest.mark.parametrize("left", [".made-by-make", ".ready"])
def test_make_continues_with_its_own_environment(clone: Path, left: str) -> None:
    """An interrupted installation and one of an earlier release count as its own."""
    own_environment(clone / ".venv")
    (clone / ".venv" / left).touch()
    os.utime(clone / ".venv" / left, (0, 0))  # pyproject.toml has changed since
    assert install(clone)[::2] == (0, {".venv"})


def test_make_does_not_change_the_venv_of_a_user(clone: Path) -> None:
    before = own_environment(clone / ".venv")
    code, output, used = install(clone)
    assert (code, used) == (0, {".venv-dev"})
    assert "make leaves .venv" in output
    assert install(clone)[::2] == (0, set())
    assert contents(clone / ".venv") == before


def test_make_refuses_a_named_environment_that_it_did_not_create(clone: Path) -> None:
    before = own_environment(clone / "mine")
    code, output, used = install(clone, "VENV=mine")
    assert (code, used) == (2, set())
    assert "mine: make did not create this environment" in output
    assert contents(clone / "mine") == before
    assert install(clone, "VENV=new")[::2] == (0, {"new"})
