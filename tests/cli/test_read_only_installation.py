"""A stop writes nothing into the installation, which may be read-only; nor must a user write to other folders."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import ran
from project_files import ROOT

GUARDED = """
import os, sys

forbidden = tuple(os.path.realpath(path) + os.sep for path in sys.argv[1].split(os.pathsep))
writing = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC


def refuse(event, arguments):
    if event == "open" and isinstance(arguments[0], (str, bytes)) and arguments[2] & writing:
        paths = arguments[:1]
    elif event in ("os.mkdir", "os.rename", "os.remove", "os.rmdir"):
        paths = [path for path in arguments if isinstance(path, (str, bytes))]
    else:
        return
    for path in paths:
        if os.path.realpath(os.fsdecode(path)).startswith(forbidden):
            os.write(2, f"{event} {path}".encode())
            os._exit(99)


sys.addaudithook(refuse)
"""


def guarded(code: str, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run code that exits with 99 if it writes to the sources or to the environment of this interpreter."""
    places = os.pathsep.join(
        [sys.prefix, *(str(ROOT / name) for name in ("harness", "estimators", "fmus", "modelica"))]
    )
    cache = str(folder / "cache")
    home = {"HOME": str(folder / "home"), "XDG_CACHE_HOME": cache, "LOCALAPPDATA": cache, "RAILGRIP_CACHE": ""}
    return ran([sys.executable, "-B", "-c", GUARDED + code, places, *arguments], folder, **home)


def test_a_first_stop_writes_only_to_the_cache_and_current_folder(tmp_path):
    done = guarded(
        "from railgrip.__main__ import main; main(['run', 'rig_slide', '--out', 'out', '--set', 'limits.horizon=1 s'])",
        tmp_path,
    )
    assert done.returncode in (0, 3), done.stderr  # after a second the train is still moving
    assert (tmp_path / "out/stop.json").exists()
    # The user's folders were empty: the FMU was compiled and is kept in the cache.
    assert list(tmp_path.rglob("*.fmu"))


def test_the_guard_stops_writes_to_the_sources(tmp_path):
    done = guarded("open(sys.argv[2], 'w')", tmp_path, str(ROOT / "harness/never_written.txt"))
    assert done.returncode == 99
    assert not (ROOT / "harness/never_written.txt").exists()


PROGRAM = """
import json, sys
from railgrip.cli.app import main
for words in json.loads(sys.argv[1]):
    try:
        main(words)
    except SystemExit as end:
        print(f"exit {end.code}", file=sys.stderr)
"""
REFUSED = {
    "new scenario own.toml": (3, "own.toml: cannot be written: Permission denied"),
    "table results --out table.csv": (2, "results: has neither campaign.json nor stop.json"),
    "run rig_slide": (2, ": results cannot be written there: Permission denied; name another folder by --out"),
    "train check tram": (0, ""),
}


@pytest.mark.skipif(sys.platform != "linux", reason="users and capabilities of Linux")
def test_another_user_who_may_write_nowhere_gets_sentences(tmp_path):
    """Root may write to all folders: the commands are then run as a user who may read all files, but change none."""
    as_user = []
    if os.geteuid() == 0:
        may_read = [f"--{kind}-caps=+dac_read_search" for kind in ("inh", "ambient")]
        as_user = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", *may_read]
        if not shutil.which("setpriv") or subprocess.run([*as_user, "true"], check=False).returncode:
            pytest.skip("root cannot become another user here")
    tmp_path.chmod(0o555)
    program = [*as_user, sys.executable, "-B", "-c", PROGRAM, json.dumps([words.split() for words in REFUSED])]
    done = ran(program, tmp_path, HOME="/nonexistent", RAILGRIP_CACHE=str(tmp_path / "cache"), PYTHONPATH="")
    tmp_path.chmod(0o755)
    assert "Traceback" not in done.stderr
    said = re.split(r"exit (\d)\n", done.stderr)
    assert [int(code) for code in said[1::2]] == [code for code, _ in REFUSED.values()], done.stderr
    for (words, (_, sentence)), text in zip(REFUSED.items(), said[::2], strict=False):
        assert sentence in text, words
    assert list(tmp_path.iterdir()) == []
