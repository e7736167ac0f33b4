"""A stop writes nothing into the installation of railgrip and its dependencies, which may be read-only."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]

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
    home = {
        "HOME": str(folder / "home"),
        "XDG_CACHE_HOME": str(folder / "cache"),
        "LOCALAPPDATA": str(folder / "cache"),
    }
    return subprocess.run(
        [sys.executable, "-B", "-c", GUARDED + code, places, *arguments],
        cwd=folder,
        env={**{key: value for key, value in os.environ.items() if key != "RAILGRIP_CACHE"}, **home},
        capture_output=True,
        encoding="utf-8",
        check=False,
    )


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
