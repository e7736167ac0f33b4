"""Files that users name are read only if they are regular, bounded and UTF-8 text."""

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest
from synthetic import TWO_PART_TRAIN
from wrong import table

from railgrip import run
from railgrip.base.errors import InputError
from railgrip.base.files import read_text
from railgrip.estimation.inspection import inspect_recording
from railgrip.estimation.spec import load_specification
from railgrip.estimators.learned.trained import load as load_trained
from railgrip.fmi import describe
from railgrip.fmus.native.library import library_digest
from railgrip.recording.files import read_mf4, read_table
from railgrip.report.table import write_tables
from railgrip.rolling_stock.schema import load_train
from railgrip.scenario.adhesion import profile_of
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.conditioning import read_conditioning
from railgrip.scenario.load import load
from railgrip.simulate.named_models import plant_description


def make_obstacle(kind: str, path: Path) -> Path:
    """Create an object that a user may name by mistake instead of a file, and return its path."""
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
                stream.truncate(3_000_000_000)  # sparse, to use no disk space
        case "not text":
            path.write_bytes(b"\x80\xff\xfe\x00" * 20)
        case "loop":
            path.symlink_to(path)
        case _:
            assert kind == "missing"
    return path


OBSTACLES = table(__file__, "tables.toml")["obstacles"]
needs_posix = pytest.mark.skipif(os.name != "posix", reason="pipes and devices in the file system are POSIX")


@needs_posix
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads every file")
def test_a_file_without_permission_is_refused(tmp_path):
    with pytest.raises(InputError, match="Permission denied"):
        read_text(make_obstacle("unreadable", tmp_path / "file.toml"))


@needs_posix
def test_a_socket_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the path of a socket is limited to 108 characters
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind("socket")
        with pytest.raises(InputError, match=r"socket: cannot be read"):
            read_text(Path("socket"))


def test_byte_order_mark_and_line_ends_of_windows_are_removed(tmp_path):
    path = tmp_path / "text.toml"
    path.write_bytes("\ufeffa = 1\r\nb = '½'\r\n".encode())
    assert read_text(path) == "a = 1\nb = '½'\n"


def test_an_archive_in_place_of_a_text_is_named(tmp_path):
    (tmp_path / "a.toml").write_bytes(b"PK\x03\x04\xb5")
    with pytest.raises(
        InputError, match=r"a\.toml: is a zip archive, as \.fmu, \.ssp and \.xlsx files are; name a file of"
    ):
        read_text(tmp_path / "a.toml")


def test_a_null_character_in_a_path_is_refused():
    with pytest.raises(InputError, match="null"):
        read_text(Path("a\0b"))


def plant_of(path: Path) -> object:
    return plant_description(load(path))


def friction_of(path: Path) -> object:
    return profile_of(load(path), TWO_PART_TRAIN)


SCENARIO = 'extends = "plain"\n'
CAMPAIGN = 'name = "c"\nscenarios = ["plain"]\n'
NOISE = 'noise = { file = "x.toml" }\n'
FRICTION = '[adhesion]\nkind = "table"\npolach = "dry"\nfile = "x.csv"\n'
FMU_SCENARIO = f'{SCENARIO}[vehicle]\nplant = "x.fmu"\n'
LIBRARY_SCENARIO = f'{SCENARIO}[vehicle]\nmodel = "x.X"\nlibrary = "x.mo"\n'
INPUTS: dict[str, tuple[str, dict[str, str], Callable[[Path], object]]] = {
    "scenario": ("x.toml", {}, load),
    "campaign": ("x.toml", {}, load_campaign),
    "estimation": ("x.toml", {}, load_specification),
    "train": ("x.toml", {}, load_train),
    "equipment": ("x.toml", {}, lambda path: load(Path("plain"), [], [str(path)])),
    "extends": ("x.toml", {"scenario.toml": 'extends = "x.toml"\n'}, load),
    "scenario of a campaign": ("x.toml", {"c.toml": 'name = "c"\nscenarios = ["x.toml"]\n'}, load_campaign),
    "variant of a campaign": ("x.toml", {"c.toml": f'{CAMPAIGN}[axes.a]\nv = "x.toml"\n'}, load_campaign),
    "noise of an estimation": ("x.toml", {"e.toml": f'extends = "wagon"\n{NOISE}'}, load_specification),
    "train of a scenario": ("x.toml", {"scenario.toml": f'{SCENARIO}[vehicle]\ntrain = "x.toml"\n'}, plant_of),
    "friction": ("x.csv", {"scenario.toml": f"{SCENARIO}{FRICTION}"}, friction_of),
    "demand": ("x.csv", {"scenario.toml": f'{SCENARIO}[demand]\nfile = "x.csv"\n'}, run),
    "plant": ("x.fmu", {"scenario.toml": FMU_SCENARIO}, run),
    "FMU": ("x.fmu", {}, describe),
    "Modelica library": ("x.mo", {"scenario.toml": LIBRARY_SCENARIO}, plant_of),
    "file of a Modelica library": (
        "x.mo",
        {"package.mo": "package P end P;"},
        lambda path: library_digest(path.parent),
    ),
    "conditioning": ("x.json", {}, read_conditioning),
    "page": ("x.md", {}, lambda path: write_tables(path, {})),
    "trained estimator": ("x.json", {}, load_trained),
    **{f"recording {suffix}": (f"x{suffix}", {}, read_table) for suffix in (".csv", ".parquet", ".mat")},
    "inspection": ("x.csv", {}, lambda path: inspect_recording(path, Path("wagon"))),
    "recording .mf4": ("x.mf4", {}, read_mf4),
    "text": ("x.toml", {}, read_text),
}
"""Input → name of an obstacle, a file that names it, and the reader of that file or else of the obstacle."""


@needs_posix
@pytest.mark.usefixtures("alarm")
@pytest.mark.parametrize("kind", OBSTACLES)
@pytest.mark.parametrize("place", INPUTS)
def test_every_input_refuses_anything_but_a_readable_file(place, kind, tmp_path):
    """Only tables may have other encodings, because loggers write them."""
    if place == "file of a Modelica library" and kind in ("folder", "missing", "loop", "not text"):
        pytest.skip("not a file of the library, or read as bytes")
    name, others, read = INPUTS[place]
    for other, text in others.items():
        (tmp_path / other).write_text(text, encoding="utf-8")
    make_obstacle(kind, tmp_path / name)
    with pytest.raises(InputError, match=OBSTACLES[kind] if place == "text" else None) as refusal:
        read(tmp_path / next(iter(others), name))
    assert (str(tmp_path / name) if place == "text" else name.partition(".")[0]) in str(refusal.value)
    assert len(str(refusal.value)) < 1000
