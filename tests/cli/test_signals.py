"""Ctrl-C and SIGTERM at any moment yield a sentence and an exit code, no traceback and no files left behind."""

import os
import signal
from contextlib import suppress
from pathlib import Path

import pytest
from sampling import FUZZ
from synthetic import LIBRARY
from waiting import LONGEST, is_running, until

from railgrip.fmus.build import fmu

pytestmark = pytest.mark.skipif(not Path("/proc").exists(), reason="looks processes up in /proc")


def members(group: int) -> list[int]:
    """Return the running processes of a session, without those that have ended but are still in the table."""
    processes: list[int] = []
    for process in (int(path.name) for path in Path("/proc").iterdir() if path.name.isdigit()):
        # Only files of this session are read: the function is called a hundred times a second.
        with suppress(OSError):  # it ended meanwhile
            if os.getsid(process) == group and is_running(process):
                processes.append(process)
    return processes


@pytest.fixture
def place(tmp_path):
    """A folder for results and one for temporary files, with a campaign and a stop of a foreign plant."""
    (tmp_path / "temporary").mkdir()
    text = (LIBRARY / "foreign_train.toml").read_text(encoding="utf-8")
    foreign = text.replace("../../../build/fmus/ForeignTrain.fmu", str(fmu("ForeignTrain")))
    # A slow train on a long track: the stop runs until it is ended.
    (tmp_path / "foreign.toml").write_text(foreign, encoding="utf-8")
    (tmp_path / "pair.toml").write_text(
        'name = "pair"\nscenarios = ["foreign.toml"]\n[axes.seed.one]\nseed = 1\n[axes.seed.two]\nseed = 2\n',
        encoding="utf-8",
    )
    return tmp_path


def loading(_, process):
    """Modules are being loaded: the library of numpy is mapped."""
    return "numpy" in Path(f"/proc/{process}/maps").read_text()


def workers_start(_, process):
    return len(members(process)) > 2


def plant_runs(place, _):
    try:
        return any((place / "temporary").rglob("modelDescription.xml"))
    except FileNotFoundError:  # a folder was removed during the search
        return False


RUN, CAMPAIGN = ("run", "foreign.toml", "--out", "out"), ("campaign", "pair.toml", "--out", "out")
MORE = [
    (RUN, loading, signal.SIGTERM, False),
    (CAMPAIGN, workers_start, signal.SIGINT, True),
    (CAMPAIGN, plant_runs, signal.SIGTERM, False),
] if FUZZ else []  # fmt: skip
"""The other signal at the same moments."""


@pytest.mark.parametrize(
    ("arguments", "moment", "number", "to_all"),
    [
        (RUN, loading, signal.SIGINT, True),
        (RUN, plant_runs, signal.SIGTERM, True),
        (CAMPAIGN, workers_start, signal.SIGTERM, False),
        (CAMPAIGN, plant_runs, signal.SIGINT, True),
        *MORE,
    ],
)
def test_a_signal_ends_the_program_with_a_sentence_and_no_leftovers(program, place, arguments, moment, number, to_all):
    """Workers end, too."""
    process = program(place, "-m", "railgrip", *arguments, TMPDIR=str(place / "temporary"))
    until(lambda: moment(place, process.pid) or process.poll() is not None)
    assert process.poll() is None, process.communicate()
    # A terminal sends Ctrl-C to all processes; `kill` and a service manager send SIGTERM to one.
    (os.killpg if to_all else os.kill)(process.pid, number)
    out, err = process.communicate(timeout=LONGEST)
    until(lambda: not members(process.pid))
    word = "Interrupted" if number == signal.SIGINT else "Terminated"
    messages = [line for line in err.splitlines() if "a process of its own" not in line and not line.endswith(" s")]
    assert messages == [f"{word}; what had finished is kept."], err
    assert process.returncode == 128 + number
    assert out == ""
    assert list((place / "temporary").iterdir()) == []
    assert [path for path in (place / "out").rglob("*") if path.name.endswith(".partial")] == []
