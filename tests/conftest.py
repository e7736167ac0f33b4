"""What every test may import."""

import gc
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

# Before NumPy is loaded: matrices here are small, and threads that wait for each other on a busy machine take minutes
# over what one does in a second.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parent))

# An example is not wrong because the machine is busy or a registry of units is loaded with the first one.
settings.register_profile("busy", deadline=None)
settings.load_profile("busy")

# A search for garbage after every 700 new objects, Python's default, takes a fifteenth of the time of the tests.
gc.set_threshold(50_000, 20, 20)

LONGEST = {
    "test_trains_in_files.py", "test_wheel.py", "test_any_formation.py", "test_modelica_validation.py",
    "test_ideal_bound.py", "test_curves_along_the_track.py", "test_exported_stops.py", "test_brake_equipment.py",
    "test_own_modelica.py", "test_command_line.py", "test_code_blocks.py", "test_gallery.py", "test_site.py",
    "test_signals.py", "test_process_environment.py", "test_train_fmus.py", "test_any_step.py", "test_brake.py",
    "test_detailed_mechanics.py", "test_two_maxima.py", "test_lateral_judgement.py",
}  # fmt: skip
"""Files of fifteen seconds and more."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the longest files: one that is left for the end runs while the other process has nothing to do."""
    items.sort(key=lambda item: item.path.name not in LONGEST)


def pytest_collection_finish() -> None:
    """Leave the tests themselves out of every later collection of garbage, which is searched thousands of times."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True, scope="session")
def _temporary_files_go_with_the_tests(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Remove at the end what the tests and their child processes left in the temporary folder.

    FMPy, for one, unpacks FMUs there for `extract` and systems for `simulate_ssp`, and leaves that to its callers.
    """
    tmp_path_factory.getbasetemp()  # pytest's own folders stay where they are, to be looked at
    # A short name: sockets of worker processes lie in it, whose paths have 108 characters at most.
    with (
        tempfile.TemporaryDirectory(prefix="rg-", ignore_cleanup_errors=True) as folder,
        pytest.MonkeyPatch.context() as patch,
    ):
        patch.setenv("TMPDIR", folder)
        patch.setattr(tempfile, "tempdir", None)
        yield


@pytest.fixture(autouse=True, scope="session")
def _saved_figures_are_readable() -> Iterator[None]:
    """Check each figure that is saved as PNG in any test, be it of a study, a page or a command."""
    from matplotlib.figure import Figure  # loads NumPy, as the next one does
    from readable import defects_of

    save = Figure.savefig

    def save_and_check(drawing: Any, *arguments: Any, **options: Any) -> None:
        if options.get("format", "png") == "png":  # the same one is drawn again for other formats
            assert defects_of(drawing) == [], f"{arguments}: cannot be read"
        save(drawing, *arguments, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", save_and_check)
        yield


@pytest.fixture
def blank_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write empty files in place of figures, where a test is not about them: drawing takes longer than a campaign."""
    from matplotlib.figure import Figure

    monkeypatch.setattr(Figure, "draw_without_rendering", lambda drawing: None)
    monkeypatch.setattr(Figure, "savefig", lambda drawing, file, **options: Path(file).write_bytes(b""))


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of a cache that starts empty and is used by nobody else, child processes included."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("RAILGRIP_CACHE", str(folder))
    return folder


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    """Return a function that runs a command in this process and the current folder: `command_line.Done`."""
    from command_line import done

    monkeypatch.setenv("COLUMNS", "200")
    return lambda *arguments: done(capfd, *arguments)


@pytest.fixture
def in_process() -> Iterator[None]:
    """Run stops in this process, where a test is not about workers."""
    from one_process import one_process

    with one_process():
        yield
