"""An input file may be a pipe, a device, a folder, huge, or not text: the command reports it at once in a sentence."""

import re
import zipfile

import pytest
from test_files_of_users import make_obstacle, needs_posix

COMMANDS = [
    "run odd.toml",
    "campaign odd.toml",
    "run extends.toml",
    "campaign equipment.toml",
    "run wet.toml --set adhesion.kind=table --set adhesion.file=odd.csv",
    "run wet.toml --set vehicle.plant=odd.fmu",
    "run wet.toml --set vehicle.library=odd.mo",
    "run wet.toml --set controller.kind=fmu --set controller.file=odd.fmu",
    "map odd.fmu",
    "build My.Train --library odd.mo",
    "train check odd.toml",
    "train show odd.toml",
    "estimate odd.toml",
    "observability odd.toml",
    "inspect odd.csv",
    "ride odd.toml",
    "report odd.toml",
    "compare odd.toml odd.toml",
    "monitor odd.toml",
    "tools conditioning odd.toml",
]


@needs_posix
@pytest.mark.usefixtures("alarm")
@pytest.mark.parametrize("kind", ["pipe", "device", "folder", "large", "not text"])
@pytest.mark.parametrize("words", COMMANDS)
def test_an_odd_file_is_refused_in_a_sentence(command, project, monkeypatch, words, kind):
    monkeypatch.chdir(project)
    named = re.search(r"odd\.\w+", words)
    make_obstacle(kind, project / (named[0] if named else "odd.toml"))
    (project / "extends.toml").write_text('extends = "odd.toml"\n', encoding="utf-8")
    (project / "equipment.toml").write_text('name = "e"\nscenarios = ["wet.toml"]\n[axes.a]\nb = "odd.toml"\n')
    result = command(*words.split())
    assert result.code == 2, result.err
    assert len(result.err.strip()) > 20


@pytest.mark.parametrize("given", [("map", "system.ssp"), ("run", "wet.toml", "--set", "vehicle.plant=system.ssp")])
def test_an_ssp_system_is_not_accepted_as_a_plant(command, project, monkeypatch, given):
    monkeypatch.chdir(project)
    with zipfile.ZipFile("system.ssp", "w") as archive:
        archive.writestr("SystemStructure.ssd", "<ssd/>")
        archive.writestr("resources/train.fmu", b"")
    result = command(*given)
    assert result.code == 2
    assert "a system by SSP" in result.err
    assert "railgrip exports" in result.err
