"""Files that users name are read only if they are regular, bounded and UTF-8 text; each refusal is immediate."""

import os
import socket
import time
from pathlib import Path

import pytest

from railgrip.base.errors import InputError
from railgrip.base.files import read_text

SECONDS = 2.0
"""Time that a refusal may take; a file that is waited for is never refused."""


def make_obstacle(kind: str, path: Path) -> Path:
    """Make what a user may name by mistake in place of a file, and return its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    match kind:
        case "pipe":
            os.mkfifo(path)
        case "device":
            path.symlink_to("/dev/zero")
        case "folder":
            path.mkdir()
        case "unreadable":
            path.write_text("", encoding="utf-8")
            path.chmod(0)
        case "large":
            with path.open("wb") as stream:
                stream.truncate(3_000_000_000)  # sparse, as it takes no space on the disk
        case "not text":
            path.write_bytes(b"\x80\xff\xfe\x00" * 20)
        case "loop":
            path.symlink_to(path)
        case _:
            assert kind == "missing"
    return path


OBSTACLES = {
    "pipe": "is a pipe or a device",
    "device": "is a pipe or a device",
    "folder": "is a folder",
    "large": "has 3,000 MB",
    "not text": "is not text in UTF-8",
    "loop": "cannot be read",
    "missing": "there is no such file",
}
needs_posix = pytest.mark.skipif(os.name != "posix", reason="pipes and devices in the file system are POSIX")


@needs_posix
@pytest.mark.parametrize("kind", OBSTACLES)
def test_what_is_not_a_readable_text_is_refused_at_once(kind, tmp_path):
    path = make_obstacle(kind, tmp_path / "file.toml")
    begin = time.monotonic()
    with pytest.raises(InputError, match=OBSTACLES[kind]) as refusal:
        read_text(path)
    assert time.monotonic() - begin < SECONDS
    assert str(path) in str(refusal.value)


@needs_posix
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads every file")
def test_a_file_without_permission_is_refused(tmp_path):
    with pytest.raises(InputError, match="Permission denied"):
        read_text(make_obstacle("unreadable", tmp_path / "file.toml"))


@needs_posix
def test_a_socket_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the path of a socket has 108 characters at most
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind("socket")
        with pytest.raises(InputError, match=r"socket: cannot be read"):
            read_text(Path("socket"))


def test_byte_order_mark_and_ends_of_lines_of_windows_are_removed(tmp_path):
    path = tmp_path / "text.toml"
    path.write_bytes("\ufeffa = 1\r\nb = '½'\r\n".encode())
    assert read_text(path) == "a = 1\nb = '½'\n"


def test_a_null_character_in_a_path_is_refused():
    with pytest.raises(InputError, match="null"):
        read_text(Path("a\0b"))
