"""A full disk ends a command in a sentence: exit code 3, no partial files, and results that fit are kept.

A limit of the file size simulates the disk: the system reports the same error beyond it as at the end of a disk.
"""

import json
import os
import resource
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import xarray
from command_line import ran
from matplotlib.figure import Figure
from synthetic import COARSE
from synthetic_runner import run_stop

from railgrip.base.errors import WriteFailed, for_user
from railgrip.base.files import replacing, write_text
from railgrip.base.records import RECORD
from railgrip.campaign.run import find_result
from railgrip.report.stop import read_stop, write_stop
from railgrip.report.style import save
from railgrip.scenario.campaign import PlannedStop
from railgrip.scenario.load import load
from railgrip.trace.recorder import write_trace

ROOT = Path(__file__).parents[2]
WET = ROOT / "harness" / "scenario" / "library" / "trapezoid.toml"


@pytest.fixture
def disk(monkeypatch):
    """Return a context in which files have a maximum size in bytes; pytest itself may write to a longer one."""
    # Python would keep the truncated bytecode of a module, and the next import would fail.
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    @contextmanager
    def limited(size):
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)

    return limited


def dataset(_):
    return xarray.Dataset({"x": ("time", np.random.default_rng(1).standard_normal(4000))})


WRITERS = {
    "text": lambda path: write_text(path, "x" * 9000),
    "trace": lambda path: write_trace(dataset(path), path),
    "figure": lambda path: save(Figure(figsize=(5, 5), facecolor="red"), path),
}


@pytest.mark.parametrize("write", WRITERS.values(), ids=WRITERS)
def test_a_failed_write_keeps_the_earlier_file_and_leaves_no_partial_one(tmp_path, disk, write):
    path = tmp_path / "result"
    path.write_text("before", encoding="utf-8")
    with disk(1000), pytest.raises(WriteFailed, match=r"result: cannot be written: File too large"):
        write(path)
    assert [file.name for file in tmp_path.iterdir()] == ["result"]
    assert path.read_text(encoding="utf-8") == "before"


def test_a_stop_without_space_for_its_trace_keeps_its_figures_and_is_run_again(tmp_path, disk):
    scenario = load(WET, COARSE)
    stop = run_stop(scenario)
    write_stop(stop, tmp_path)
    size = (tmp_path / "stop.json").stat().st_size
    assert (tmp_path / "trace.nc").stat().st_size > size + 100
    with disk(size + 100), pytest.raises(WriteFailed, match=r"trace\.nc: cannot be written"):
        write_stop(stop, tmp_path)
    assert sorted(file.name for file in tmp_path.iterdir()) == [RECORD, "stop.json"]
    assert read_stop(tmp_path).metrics.distance == stop.metrics.distance
    assert find_result(PlannedStop(name="wet", variants={}, scenario=scenario), tmp_path) is None
    with disk(size - 100), pytest.raises(WriteFailed, match=r"stop\.json: cannot be written"):
        write_stop(stop, tmp_path)
    # The earlier result stays complete.
    assert sorted(file.name for file in tmp_path.iterdir()) == [RECORD, "stop.json"]
    assert read_stop(tmp_path).digest == scenario.digest()


def test_a_full_disk_is_a_failure_of_the_run_and_not_a_wrong_input(tmp_path):
    with pytest.raises(WriteFailed) as error, replacing(tmp_path / "a"):
        raise OSError(28, "No space left on device")
    message = for_user(error.value)
    assert message is not None
    assert message.exit_code == 3
    assert str(message) == f"{tmp_path / 'a'}: cannot be written: No space left on device"
    elsewhere = for_user(OSError(28, "No space left on device", "model.c"))
    assert elsewhere is not None
    assert str(elsewhere) == "model.c: No space left on device"


PROGRAM = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop(1)), resource.RLIM_INFINITY))
import synthetic_runner
sys.modules["railgrip.simulate.run"] = synthetic_runner
from railgrip.__main__ import main
main()
"""


def test_the_command_line_exits_with_3_and_the_distance_is_kept(tmp_path):
    """In a separate process, which HDF5 used to crash."""
    words = ["-B", "-c", PROGRAM, "9000", "run", WET, "--out", "out"]
    result = ran([sys.executable, *words], tmp_path, PYTHONPATH=f"{ROOT}{os.pathsep}{ROOT / 'tests'}")
    assert result.returncode == 3, result.stderr
    assert [line for line in result.stderr.splitlines() if not line.endswith(" s")] == [
        "out/trace.nc: cannot be written: File too large"
    ]
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == [RECORD, "stop.json"]
    assert json.loads((tmp_path / "out" / "stop.json").read_text(encoding="utf-8"))["distance_m"] > 0
