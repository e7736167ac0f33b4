"""Ctrl-C and SIGTERM, whenever they come: a sentence and an exit code, no traceback, and nothing left behind."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from railgrip.fmus.build import fmu

LIBRARY = Path(__file__).parents[2] / "harness" / "scenario" / "library"
ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.skipif(not Path("/proc").exists(), reason="looks processes up in /proc")


def members(group: int) -> list[int]:
    """Return the processes of a session that still run; one that has ended stays until somebody asks how."""
    processes: list[int] = []
    for process in (int(path.name) for path in Path("/proc").iterdir() if path.name.isdigit()):
        try:
            # Files of the session's own alone are read: this is asked a hundred times a second.
            if os.getsid(process) != group:
                continue
            state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:  # it ended meanwhile
            continue
        if state != "Z":
            processes.append(process)
    return processes


def until(state, patience=300.0):
    """Wait for a state; the machine may be busy with other tests."""
    end = time.monotonic() + patience
    while not state():
        assert time.monotonic() < end, "it did not come to that"
        time.sleep(0.01)


@pytest.fixture
def place(tmp_path):
    """A folder for results and one for temporary files, with a campaign and a stop of a plant from outside."""
    (tmp_path / "temporary").mkdir()
    text = (LIBRARY / "foreign_train.toml").read_text(encoding="utf-8")
    foreign = text.replace("../../../build/fmus/ForeignTrain.fmu", str(fmu("ForeignTrain")))
    # At a crawl on a long way: it runs as long as anybody waits.
    (tmp_path / "foreign.toml").write_text(foreign, encoding="utf-8")
    (tmp_path / "pair.toml").write_text(
        'name = "pair"\nscenarios = ["foreign.toml"]\n[axes.seed.one]\nseed = 1\n[axes.seed.two]\nseed = 2\n',
        encoding="utf-8",
    )
    return tmp_path


def ended(place, arguments, moment, number, *, to_all):
    """Start the command line, send a signal at a moment; return what it said, its exit code, and how long it took."""
    process = subprocess.Popen(
        [sys.executable, "-m", "railgrip", *arguments],
        cwd=place,
        env=os.environ | {"TMPDIR": str(place / "temporary"), "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        until(lambda: moment(place, process.pid) or process.poll() is not None)
        assert process.poll() is None, process.communicate()
        # A terminal sends Ctrl-C to all, `kill` and a service manager SIGTERM to one.
        (os.killpg if to_all else os.kill)(process.pid, number)
        signalled_at = time.monotonic()
        out, err = process.communicate(timeout=300)
        until(lambda: not members(process.pid))
        return out, err, process.returncode, time.monotonic() - signalled_at
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()


def loading(_, process):
    """While modules are loaded: the library of numpy is there."""
    return "numpy" in Path(f"/proc/{process}/maps").read_text()


def workers_start(_, process):
    return len(members(process)) > 2


def plant_runs(place, _):
    try:
        return any((place / "temporary").rglob("modelDescription.xml"))
    except FileNotFoundError:  # a folder went while it was searched
        return False


RUN, CAMPAIGN = ("run", "foreign.toml", "--out", "out"), ("campaign", "pair.toml", "--out", "out")


@pytest.mark.parametrize(
    ("arguments", "moment", "number", "to_all"),
    [
        (RUN, loading, signal.SIGINT, True),
        (RUN, loading, signal.SIGTERM, False),
        (RUN, plant_runs, signal.SIGTERM, True),
        (CAMPAIGN, workers_start, signal.SIGINT, True),
        (CAMPAIGN, workers_start, signal.SIGTERM, False),
        (CAMPAIGN, plant_runs, signal.SIGINT, True),
        (CAMPAIGN, plant_runs, signal.SIGTERM, False),
    ],
)
def test_a_signal_ends_the_program_with_a_sentence_and_leaves_nothing(place, arguments, moment, number, to_all):
    """Workers do not go on: two seconds on an idle machine, a tenfold of that where others compute, too."""
    out, err, code, seconds = ended(place, arguments, moment, number, to_all=to_all)
    word = "Interrupted" if number == signal.SIGINT else "Terminated"
    messages = [line for line in err.splitlines() if "a process of its own" not in line and not line.endswith(" s")]
    assert messages == [f"{word}; what had finished is kept."], err
    assert code == 128 + number
    assert out == ""
    assert list((place / "temporary").iterdir()) == []
    assert [path for path in (place / "out").rglob("*") if path.name.endswith(".partial")] == []
    assert seconds < 20.0
