"""Fixtures and settings of all tests."""

import gc
import json
import os
import random
import re
import signal
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from weakref import WeakSet

import pytest
from hypothesis import settings

# Set before NumPy is imported: matrices here are small, and on a busy machine threads that wait for each other take
# minutes for work that a single thread does in a second.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path[:0] = [str(Path(__file__).parents[1] / folder) for folder in ("tests", "tools", "docs/studies")]

# Python looks for cycles after every 700 new objects: with thousands of tests in memory that is a tenth of the time.
gc.set_threshold(50_000, 20, 50)

# A slow example is not a failure: the machine may be busy, or the first example loads a registry of units.
# `make fuzz` draws as many examples as Hypothesis does unless told otherwise.
settings.register_profile("busy", deadline=None, max_examples=100 if "RAILGRIP_FUZZ" in os.environ else 15)
settings.load_profile("busy")

LONGEST = {
    "test_every_command.py",
    "test_trains_in_files.py", "test_wheel.py", "test_any_formation.py", "test_modelica_validation.py",
    "test_ideal_bound.py", "test_curves_along_the_track.py", "test_exported_stops.py", "test_brake_equipment.py",
    "test_own_modelica.py", "test_command_line.py", "test_code_blocks.py", "test_gallery.py", "test_site.py",
    "test_signals.py", "test_process_environment.py", "test_train_fmus.py", "test_any_step.py", "test_brake.py",
    "test_detailed_mechanics.py", "test_two_maxima.py", "test_lateral_judgement.py", "test_long_trains.py",
}  # fmt: skip
"""Files whose tests take fifteen seconds or longer."""


LEFT_OUT = tomllib.loads(Path(__file__).with_name("left_out.toml").read_text(encoding="utf-8"))


def pytest_addoption(parser: pytest.Parser) -> None:
    """Select one of the two floors of tests that tools/floors.py has chosen."""
    parser.addoption(
        "--floor", choices=["deciding", "rest"], help="only tests not in left_out.toml, or only the others"
    )


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out files none of whose tests decides, whose imports take longer than some tests."""
    names = LEFT_OUT.get(collection_path.relative_to(config.rootpath).as_posix())
    if config.getoption("floor") != "deciding" or not names:
        return None
    return (
        set(re.findall(r"^def (test_\w+)", collection_path.read_text(encoding="utf-8"), re.MULTILINE)) <= {*names}
        or None
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Select the floor, and start with the longest files: at the end one would leave the other process idle.

    With RAILGRIP_ORDER, any number, the order of files and of the tests in each is random: none may depend on another.
    """
    if floor := config.getoption("floor"):
        of = {True: [], False: []}
        for item in items:
            file, _, test = item.nodeid.partition("::")
            of[bool({test, test.partition("[")[0]} & {*LEFT_OUT.get(file, ())})].append(item)
        items[:] = of[floor == "rest"]
        config.hook.pytest_deselected(items=of[floor != "rest"])
    if number := os.environ.get("RAILGRIP_ORDER"):
        draw = random.Random(number)
        of_file = {path: draw.random() for path in sorted({item.path for item in items})}
        items.sort(key=lambda item: (of_file[item.path], draw.random()))
    else:
        items.sort(key=lambda item: item.path.name not in LONGEST)


def pytest_collection_finish() -> None:
    """Exclude the test items from garbage collection, which would otherwise traverse them thousands of times."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True, scope="session")
def _temporary_files_go_with_the_tests(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Remove the temporary files of the tests and their child processes at the end.

    FMPy, for example, unpacks FMUs there for `extract` and systems for `simulate_ssp`, and leaves the removal to its
    callers.
    """
    tmp_path_factory.getbasetemp()  # pytest's own folders are kept for inspection
    # A short name: it holds sockets of worker processes, whose paths are limited to 108 characters.
    with (
        tempfile.TemporaryDirectory(prefix="rg-", ignore_cleanup_errors=True) as folder,
        pytest.MonkeyPatch.context() as patch,
    ):
        patch.setenv("TMPDIR", folder)
        patch.setattr(tempfile, "tempdir", None)
        yield


@pytest.fixture(autouse=True, scope="session")
def _saved_figures_are_readable() -> Iterator[None]:
    """Check each figure that any test saves as PNG or shows on a page, whether of a study, a page or a command.

    A figure on a page has all texts that it has as PNG.
    """
    from matplotlib import rcParams
    from matplotlib.figure import Figure  # imports NumPy, as does the next one
    from readable import defects_of, missing_in

    save, checked = Figure.savefig, WeakSet[Any]()

    def save_and_check(drawing: Any, *arguments: Any, **options: Any) -> None:
        of_page = options.get("format") == "svg" and rcParams["svg.fonttype"] == "none"
        if options.get("format", "png") == "png" or (of_page and drawing not in checked):
            assert defects_of(drawing) == [], f"{arguments}: cannot be read"
            checked.add(drawing)
        save(drawing, *arguments, **options)
        if of_page:
            assert missing_in(arguments[0].getvalue(), drawing) == []

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", save_and_check)
        yield


@pytest.fixture(autouse=True, scope="session")
def _classes_of_users_are_translated_in_this_process() -> Iterator[None]:
    """Translate small classes without a new process, whose imports take longer than most of them.

    tests/fmus/test_separate_process.py tests the process.
    """
    from railgrip.fmus.native import separate_process

    def here(task: str, class_name: str, library: Path, **arguments: Any) -> Any:
        answer = json.loads(json.dumps(separate_process._answer(task, class_name, library, arguments)))
        return separate_process.result_of(answer, task, class_name, library, arguments.get("others", ()))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(separate_process, "call", here)
        yield


@pytest.fixture
def blank_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write empty files instead of figures where a test does not check them: drawing takes longer than a campaign."""
    from matplotlib.figure import Figure

    monkeypatch.setattr(Figure, "draw_without_rendering", lambda drawing: None)
    monkeypatch.setattr(
        Figure, "savefig", lambda drawing, file, **options: Path(file).write_bytes(b"") if isinstance(file, Path) else 0
    )


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of an empty cache that only this test and its child processes use."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("RAILGRIP_CACHE", str(folder))
    return folder


@pytest.fixture
def own_results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep results of studies apart, so that each case runs; FMUs and libraries are those of all tests."""
    folder = tmp_path / "results"
    folder.mkdir()
    own = SimpleNamespace(
        find=lambda kind, key, name: next(folder.glob(key), None),
        keep=lambda kind, key, name, content: (folder / key).write_bytes(content),
    )
    monkeypatch.setattr("railgrip.campaign.work.cache", own)


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    """Return a function that runs a command in this process and the current folder and returns `command_line.Done`."""
    from command_line import done

    monkeypatch.setenv("COLUMNS", "200")
    return lambda *arguments: done(capfd, *arguments)


@pytest.fixture
def alarm() -> Iterator[None]:
    """End a test that hangs."""
    from waiting import LONGEST

    def give_up(*_: object) -> None:
        raise TimeoutError(f"waits after {LONGEST:g} s")

    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(int(LONGEST))
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture
def in_process() -> Iterator[None]:
    """Run stops in this process, for tests that do not check workers."""
    from one_process import one_process

    with one_process():
        yield
