"""An input file may be a pipe, a device, a folder, huge, or not text: the command reports it at once in a sentence."""

import os
import zipfile

import pytest

COMMANDS = {
    "scenario": ("run", "{}"),
    "campaign": ("campaign", "{}"),
    "extends": ("run", "extends.toml"),
    "equipment": ("campaign", "equipment.toml"),
    "adhesion table": ("run", "wet.toml", "--set", "adhesion.kind=table", "--set", "adhesion.file={}"),
    "plant": ("run", "wet.toml", "--set", "vehicle.plant={}"),
    "library": ("run", "wet.toml", "--set", "vehicle.library={}"),
    "controller": ("run", "wet.toml", "--set", "controller.kind=fmu", "--set", "controller.file={}"),
    "map": ("map", "{}"),
    "class": ("build", "My.Train", "--library", "{}"),
    "train": ("train", "check", "{}"),
    "drawing": ("train", "draw", "{}"),
    "estimation": ("estimate", "{}"),
    "observability": ("observability", "{}"),
    "recording": ("inspect", "{}"),
    "ride": ("ride", "{}"),
    "results": ("report", "{}"),
    "comparison": ("compare", "{}", "{}"),
    "evidence": ("monitor", "{}"),
    "baseline": ("maintain", "conditioning", "{}"),
}
SUFFIX = {
    "plant": ".fmu",
    "controller": ".fmu",
    "map": ".fmu",
    "recording": ".csv",
    "adhesion table": ".csv",
} | dict.fromkeys(("library", "class"), ".mo")


def pipe(path):
    os.mkfifo(path)


def device(path):
    path.symlink_to("/dev/zero")


def folder(path):
    path.mkdir()


def huge(path):
    with path.open("wb") as file:
        file.truncate(3 << 30)  # sparse: it uses no disk space


def no_text(path):
    path.write_bytes(bytes(range(128, 256)) * 10)


@pytest.mark.usefixtures("alarm")
@pytest.mark.skipif(os.name != "posix", reason="named pipes and devices are files on POSIX systems only")
@pytest.mark.parametrize("make", [pipe, device, folder, huge, no_text])
@pytest.mark.parametrize("given", COMMANDS)
def test_an_odd_file_is_refused_in_a_sentence(command, project, monkeypatch, given, make):
    monkeypatch.chdir(project)
    path = project / f"odd{SUFFIX.get(given, '.toml')}"
    make(path)
    (project / "extends.toml").write_text(f'extends = "{path.name}"\n', encoding="utf-8")
    (project / "equipment.toml").write_text(
        f'name = "e"\nscenarios = ["wet.toml"]\n[axes.a]\nb = "{path.name}"\n', encoding="utf-8"
    )
    result = command(*(part.format(path.name) for part in COMMANDS[given]))
    assert result.code == 2, result.err
    assert len(result.err.strip()) > 20
    assert "Traceback" not in result.err


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
