"""Closed streams, missing folders, resource limits and foreign programs cause neither tracebacks nor wrong results."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import ran
from project_files import ROOT
from sampling import FUZZ, sample

from railgrip.base.programs import environment_of_programs, find_program
from railgrip.fmus.native.toolchain import shared_library

pytestmark = pytest.mark.skipif(os.name != "posix", reason="shell and limits of POSIX")

PROGRAM = f"{shlex.quote(sys.executable)} -m railgrip"
STOP = "run trapezoid --set limits.horizon='1 s' --set controller.kind=full_brake --set estimator.kind=none"


def shell(command: str, folder: Path, **variables: str) -> "subprocess.CompletedProcess[str]":
    return ran(["/bin/sh", "-c", command], folder, **variables)


@pytest.mark.parametrize(
    ("command", "code", "closed"),
    sample(
        [
            *(("list scenarios", 0, closed) for closed in ("<&- >&- 2>&-", "<&-", ">&-")),
            *(("run nosuch", 2, closed) for closed in ("2>&-", ">&- 2>&-", ">&-")),
        ],
        3,
    ),
)
def test_closed_streams_do_not_change_the_exit_code(command: str, code: int, closed: str, tmp_path: Path) -> None:
    done = shell(f"{PROGRAM} {command} {closed}", tmp_path)
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    if code and "2>&-" not in closed:
        assert "nosuch" in done.stderr


def test_results_do_not_depend_on_closed_streams_or_the_clock(tmp_path: Path) -> None:
    """Output of the plant or the program does not end up in a file that reuses the number of a closed stream."""
    ways = {"open": ({}, ""), "closed": ({}, "<&- >&- 2>&-")}
    if sys.platform == "linux":
        clock = str(shared_library({"clock.c": Path(__file__).with_name("clock.c").read_text()}, "clock"))
        ways["late"] = ({"LD_PRELOAD": clock, "TZ": "<+2459>-24:59:59<-2459>24:59:59,0/167,J365/-167"}, "")
        years = "import time; t = [time.time() for _ in range(9)]; print((max(t) - min(t)) / 3.2e7)"
        assert float(shell(f"{shlex.quote(sys.executable)} -c '{years}'", tmp_path, **ways["late"][0]).stdout) > 30
    done = [shell(f"{PROGRAM} {STOP} --out {name} {how}", tmp_path, **more) for name, (more, how) in ways.items()]
    assert {one.returncode for one in done} == {3}  # the train does not stop within a second
    assert not any("Traceback" in one.stderr for one in done)
    contents = [{path.name: path.read_bytes() for path in (tmp_path / name).iterdir()} for name in ways]
    assert all(content == contents[0] for content in contents)
    assert contents[0]["stop.json"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
@pytest.mark.parametrize(("command", "code"), [("list scenarios > /dev/full", 3), ("run nosuch 2> /dev/full", 2)])
def test_a_full_output_device_is_reported_in_a_sentence(command: str, code: int, tmp_path: Path) -> None:
    done = shell(f"{PROGRAM} {command}", tmp_path)
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    assert code == 2 or "standard output: No space left on device" in done.stderr


def test_a_closed_pipe_ends_the_command_silently(tmp_path: Path) -> None:
    done = shell(f"{PROGRAM} schema scenario | head -c 10", tmp_path)
    assert (len(done.stdout), done.stderr) == (10, "")


@pytest.mark.parametrize("command", sample(["run trapezoid", "list scenarios", "doctor", "report ."], 1))
def test_a_removed_current_folder_is_reported_in_a_sentence(command: str, tmp_path: Path) -> None:
    (tmp_path / "gone").mkdir()
    done = shell(f"cd gone && rmdir ../gone && {PROGRAM} {command}", tmp_path, PYTHONPATH=str(ROOT / "harness"))
    assert done.returncode == 2
    assert done.stderr == "the current folder no longer exists; change to another one\n"


@pytest.mark.parametrize("command", [f"{STOP} --out out", "list scenarios"])
def test_a_file_size_limit_of_zero_is_reported_in_a_sentence(command: str, tmp_path: Path) -> None:
    """By `ulimit -f 0`; no file is left that looks like a result."""
    done = shell(f"ulimit -f 0; {PROGRAM} {command} 2>&1 | cat", tmp_path)
    assert "Traceback" not in done.stdout
    assert not list(tmp_path.glob("out/*.json"))
    if "out" in command:
        assert "no temporary folder can be written" in done.stdout


def test_a_home_that_is_not_writable_is_not_mentioned(tmp_path: Path) -> None:
    """Nothing is kept there but a cache, which is in another folder; Matplotlib's is a temporary one."""
    done = shell(f"{PROGRAM} train show vt642 --out train.svg", tmp_path, HOME="/dev/null", XDG_CONFIG_HOME="")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("temporary", ["temporary", *(["./missing"] if FUZZ else [])])
def test_relative_folders_get_no_temporary_files_and_their_programs_are_not_run(temporary: str, tmp_path: Path) -> None:
    """Relative and empty entries of PATH are both before and after the others."""
    (tmp_path / "temporary").mkdir()
    (tmp_path / "tools").mkdir()
    for folder in (tmp_path, tmp_path / "tools"):
        for name in ("omc", "git", "cc", "gcc", "clang", "ar"):
            (folder / name).write_text(f"#!/bin/sh\ntouch {tmp_path}/ran\n")
            (folder / name).chmod(0o755)
    relative = ".:tools:./tools"
    path = f":{relative}:{os.environ['PATH']}:{relative}:"
    done = shell(f"{PROGRAM} {STOP} --out out", tmp_path, PATH=path, TMPDIR=temporary)
    assert done.returncode == 3, done.stderr
    assert "Traceback" not in done.stderr
    assert not [path for path in tmp_path.rglob("railgrip-*") if path.is_dir()]
    assert not (tmp_path / "ran").exists()


def test_programs_are_only_searched_in_absolute_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "omc").write_text("#!/bin/sh\n")
    (tmp_path / "omc").chmod(0o755)
    monkeypatch.chdir(tmp_path)
    for path in (".", "", ":", f"..{os.sep}{tmp_path.name}", "./", ".:relative"):
        monkeypatch.setenv("PATH", path)
        assert find_program("omc") is None
        assert environment_of_programs()["PATH"] == ""
    monkeypatch.setenv("PATH", f".:{tmp_path}")
    assert find_program("omc") == str(tmp_path / "omc")
    assert environment_of_programs()["PATH"] == str(tmp_path)
    assert find_program("./omc") == str(tmp_path / "omc")  # as CC may specify it
