import tempfile
from pathlib import Path

import pytest

from railgrip.fmus.native.dae import read
from railgrip.fmus.native.system import System, explicit


@pytest.fixture(scope="session")
def foundry(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder for compiling tiny FMUs, once for all tests of this folder."""
    return tmp_path_factory.mktemp("foundry")


@pytest.fixture(scope="session")
def foreign_train() -> System:
    """The equations of a train whose signals have other names and units, read once."""
    return explicit(read("ForeignTrain.Train", Path(__file__).parents[2] / "modelica" / "ForeignTrain"))


@pytest.fixture
def scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The only folder for temporary files during a test, child processes included, to check for leftovers."""
    folder = tmp_path / "scratch"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setattr(tempfile, "tempdir", None)
    return folder


@pytest.fixture
def protests(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file to which the tiny FMU writes at the end which of its functions were called."""
    file = tmp_path / "protests.txt"
    file.write_text("")
    monkeypatch.setenv("TINY_PROTEST", str(file))
    return file
