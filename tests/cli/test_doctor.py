"""`railgrip doctor` finds no problem in this installation, and reports each possible problem with its remedy."""

import os
import sys
from importlib.metadata import Distribution, PackageNotFoundError, version

import pytest
from users_parts import install_part

from railgrip.base import registry
from railgrip.cli import doctor
from railgrip.fmus.native import toolchain


@pytest.fixture(autouse=True)
def _fresh():
    """Clear what the process has cached."""
    for remembered in (registry.installed_names, toolchain._probe):
        remembered.cache_clear()
    yield
    for remembered in (registry.installed_names, toolchain._probe):
        remembered.cache_clear()


def test_a_good_installation_has_no_problems(railgrip):
    result = railgrip("doctor")
    assert (result.code, result.err) == (0, "")
    assert "PROBLEM" not in result.out
    for what in ("railgrip", "Python", "casadi", "C compiler", "OpenModelica", "cache", "temporary folder", "FMUs"):
        assert what in result.out
    assert "No problems." in result.out


def no_compiler(folder, monkeypatch):
    monkeypatch.setenv("CC", "false")


def compiler_that_compiles_nothing(folder, monkeypatch):
    (folder / "cc").write_text('#!/bin/sh\n[ "$1" = --version ] && echo cc 1.0 && exit\necho no licence >&2; exit 1\n')
    (folder / "cc").chmod(0o755)
    monkeypatch.setenv("CC", str(folder / "cc"))


def relative_cache(folder, monkeypatch):
    monkeypatch.setenv("RAILGRIP_CACHE", "cache")


def cache_that_is_a_file(folder, monkeypatch):
    (folder / "file").touch()
    monkeypatch.setenv("RAILGRIP_CACHE", str(folder / "file"))


def no_temporary_folder(folder, monkeypatch):
    monkeypatch.setattr(doctor, "gettempdir", lambda: str(folder / "gone"))


def missing_package(folder, monkeypatch):
    def version_of(name):
        if name == "pint":
            raise PackageNotFoundError(name)
        return version(name)

    monkeypatch.setattr(doctor, "version", version_of)


def missing_file(folder, monkeypatch):
    package, info = folder / "railgrip", folder / "railgrip-1.0.dist-info"
    package.mkdir()
    info.mkdir()
    (package / "there.py").touch()
    record = "railgrip/there.py,,\nrailgrip/gone.toml,,\nrailgrip/a.pyc,,\nrailgrip-1.0.dist-info/x,,\n"
    (info / "RECORD").write_text(record)
    monkeypatch.setattr(doctor, "distribution", lambda name: Distribution.at(info))


def part_that_does_not_load(folder, monkeypatch):
    install_part(folder, "estimators", "module_that_is_gone:Filter")
    monkeypatch.syspath_prepend(folder)


def fmpy_that_does_not_import(folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "railgrip.fmi.description", None)


def openmodelica_without_zip(folder, monkeypatch):
    (folder / "omc").write_text("#!/bin/sh\n")
    (folder / "omc").chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")
    monkeypatch.setattr("railgrip.fmus.openmodelica.missing_programs", lambda: ["zip"])


@pytest.mark.parametrize(
    ("break_it", "sentences"),
    [
        (no_compiler, ["C compiler", "does not start"]),
        (compiler_that_compiles_nothing, ["C compiler", "could not compile doctor", "no licence"]),
        (openmodelica_without_zip, ["OpenModelica", "omc needs zip", "install zip"]),
        (
            relative_cache,
            ["cache: fails: the cache folder must be an absolute path, got 'cache'; correct RAILGRIP_CACHE"],
        ),
        (cache_that_is_a_file, ["cache: fails", "cannot be written", "name another folder in RAILGRIP_CACHE"]),
        (no_temporary_folder, ["temporary folder", "cannot be written: No such file", "TMPDIR"]),
        (missing_package, ["pint: is not installed: python -m pip install 'pint"]),
        (missing_file, ["1 of 2 files are missing, such as railgrip/gone.toml", "--force-reinstall"]),
        (part_that_does_not_load, ["estimator mine", "module_that_is_gone cannot be imported", "railgrip.estimators"]),
        (fmpy_that_does_not_import, ["FMUs", "install railgrip again"]),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_each_problem_is_reported_with_its_remedy(railgrip, tmp_path_factory, monkeypatch, break_it, sentences):
    break_it(tmp_path_factory.mktemp("broken"), monkeypatch)
    result = railgrip("doctor")
    assert result.code == 1, result.out
    assert "PROBLEM" in result.out
    assert "No problems." not in result.out
    assert "Traceback" not in result.err
    message = " ".join(result.err.split())
    for sentence in sentences:
        assert sentence in message
