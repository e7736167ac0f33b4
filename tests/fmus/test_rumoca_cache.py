"""rumoca caches parsed files without checking them; railgrip does not use this cache."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import ran

from railgrip.fmus.native.library import LIBRARY

CLASS = "RailBraking.FMUs.ContactPoint"
FILL = f"import rumoca; rumoca.Session(roots=[{str(LIBRARY)!r}]).load({str(LIBRARY / 'package.mo')!r}, model='{CLASS}')"
READ = f"from railgrip.fmus.native.dae import read; print(read('{CLASS}').class_name)"

DAMAGES: tuple[Callable[[bytes], bytes], ...] = (
    lambda content: b"",
    lambda content: content[: len(content) // 2],
    lambda content: content[:8] + 8 * b"\xff" + content[16:],
    lambda content: bytes(byte ^ (0x80 if number % 97 == 0 else 0) for number, byte in enumerate(content)),
)


def python(code: str, cache: Path) -> "subprocess.CompletedProcess[str]":
    """Run Python with `cache` as the folder of all caches except railgrip's."""
    return ran([sys.executable, "-c", code], XDG_CACHE_HOME=str(cache), RAILGRIP_CACHE=str(cache / "own"))


@pytest.mark.skipif(sys.platform == "win32", reason="it ends with a window of the system there")
def test_damaged_files_in_the_cache_of_rumoca_change_nothing(tmp_path: Path) -> None:
    """Each file in one of four ways: files of each kind are among them."""
    assert python(FILL, tmp_path).returncode == 0
    files = [path for path in tmp_path.rglob("*.bin") if path.is_file()]
    assert len(files) > 10, "rumoca keeps its cache elsewhere now"
    for number, file in enumerate(files):
        file.write_bytes(DAMAGES[number % len(DAMAGES)](file.read_bytes()))
    damaged = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    done = python(READ, tmp_path)
    assert (done.returncode, done.stdout.strip()) == (0, CLASS), done.stderr[-500:]
    left = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert left == damaged, "railgrip writes nothing into it"


def test_only_rumoca_gets_another_cache_folder(tmp_path: Path) -> None:
    """Programs that are started later find the user's caches."""
    code = f"{READ}; import os; os.system('echo $XDG_CACHE_HOME'); print(os.environ['XDG_CACHE_HOME'])"
    done = python(code, tmp_path)
    assert done.stdout.split() == [CLASS, str(tmp_path), str(tmp_path)] or sys.platform == "win32", done.stdout
