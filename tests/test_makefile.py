"""The Makefile installs only into environments that it created; tests/cli/test_every_command.py runs its targets."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from project_files import ROOT

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="stands in for Python by a shell script")


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


def install(clone: Path, *settings: str, **variables: str) -> tuple[int, str, set[str]]:
    """Run `make install`; return exit code, output and the environments that pip installed into."""
    (clone / "pip.log").unlink(missing_ok=True)
    command = ["make", "install", f"PYTHON={clone / 'python3'}", *settings]
    environment = {"PATH": "/usr/bin:/bin"} | variables
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


def test_make_refuses_an_environment_with_a_blank_and_one_that_it_did_not_create(clone: Path) -> None:
    before = own_environment(clone / "mine")
    for name, sentence in (
        ("my environment", "VENV='my environment': make takes no path with blanks"),
        ("mine", "mine: make did not create this environment"),
    ):
        code, output, used = install(clone, f"VENV={name}")
        assert (code, used, sentence in output) == (2, set(), True)
    assert contents(clone / "mine") == before
    assert install(clone, "VENV=new")[::2] == (0, {"new"})


@pytest.fixture
def bare(tmp_path: Path) -> Path:
    """A folder for PATH with the programs that the Makefile calls, and without a C compiler."""
    folder = tmp_path / "programs"
    folder.mkdir()
    for name in ("sh", "make", "mkdir", "touch", "ls", "cp", "chmod", "test", "echo", "env"):
        path = shutil.which(name, path="/usr/bin:/bin")
        assert path is not None
        (folder / name).symlink_to(path)
    return folder


@pytest.mark.parametrize("name", ["cc", "gcc", "clang", "my-compiler", ""])
def test_make_installs_a_compiler_only_where_there_is_none(clone: Path, bare: Path, name: str) -> None:
    """A user may name one that is not on the path."""
    named = {"CC": f"{clone / name} -m64"} if name == "my-compiler" else {}
    if name:
        compiler = (clone if named else bare) / name
        compiler.write_text("#!/bin/sh\n")
        compiler.chmod(0o755)
    assert install(clone, PATH=str(bare), **named)[0] == 0
    found = re.search(r"--editable (\S+)", (clone / "pip.log").read_text())
    assert found is not None
    assert found[1] == ("." if name else ".[compiler]")


def test_the_extra_with_a_compiler_exists_and_only_windows_needs_it() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (extra,) = project["optional-dependencies"]["compiler"]
    assert extra.startswith("ziglang")
    (required,) = (requirement for requirement in project["dependencies"] if requirement.startswith("ziglang"))
    assert required == f"{extra}; sys_platform == 'win32'"


def test_the_main_job_runs_every_controller_of_the_published_table() -> None:
    """Those with a published distance, and the law of railgrip and the bound next to them."""
    campaigns = ROOT / "harness" / "scenario" / "campaigns"
    table1 = tomllib.loads((campaigns / "table1.toml").read_text(encoding="utf-8"))
    done = subprocess.run(
        ["make", "--dry-run", "--always-make", "simulate"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    choice = re.search(r"--only controller=(\S+?)[;\s]", done.stdout)
    assert choice is not None
    chosen = set(choice[1].split(","))
    published = {reference["match"]["controller"] for reference in table1["reference"]}
    assert published | {"adhesion_based", "adhesion_literal", "ideal_bound"} <= chosen
    assert chosen <= set(table1["axes"]["controller"])
    assert "shapes.toml" not in done.stdout
