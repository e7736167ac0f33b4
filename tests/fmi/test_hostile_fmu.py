"""Whatever an FMU in a separate process does to the machine, the run ends in a sentence and leaves nothing behind."""

import os
import pickle
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from faulty_fmu import faulty_fmu
from waiting import is_running, until

from railgrip.base.errors import PlantFailed
from railgrip.base.limits import FMU_LIMITS, FmuLimits
from railgrip.fmi import IsolatedCoSimulation, Port, bind, describe, shared_budget
from railgrip.fmi.isolation import ANSWER, FAILED, KEEPER
from railgrip.vehicle.signals import PLANT

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes of FMUs are held on Linux")

SIGNALS = [signal for signal in PLANT if signal.name in ("speed", "distance")]


def isolated(
    plant: Path, limits: FmuLimits = FMU_LIMITS, notify: Callable[[str], object] = lambda sentence: None
) -> IsolatedCoSimulation:
    """Return a train that is stepped by 10 ms in a separate process."""
    description = describe(plant, limits)
    binding = bind(
        description,
        inputs=[Port(name="pressure_command", unit="Pa", size=4, needed=True)],
        outputs=[Port(name=s.name, unit=s.unit, size=0, needed=True) for s in SIGNALS],
    )
    return IsolatedCoSimulation(description, binding, period=0.01, parameters={}, limits=limits, notify=notify)


def stopped(plant: Path, limits: FmuLimits = FMU_LIMITS) -> str:
    """Step a plant in a separate process until it fails, and return the message."""
    plant_in_its_own = isolated(plant, limits)
    try:
        with plant_in_its_own as running:
            running.start(np.zeros(4))
            for _ in range(20):
                running.step(np.zeros(4))
    except PlantFailed as failed:
        return str(failed)
    pytest.fail("it did not fail")


@pytest.fixture
def left_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], list[int]]]:
    """Return the process numbers recorded by the children of FMUs; they are ended after the test."""
    file = tmp_path / "left_behind.txt"
    file.write_text("")
    monkeypatch.setenv("MULE_LEFT_BEHIND", str(file))

    def numbers() -> list[int]:
        return [int(line) for line in file.read_text().split()]

    yield numbers
    for number in filter(is_running, numbers()):
        os.kill(number, 9)


@pytest.mark.parametrize(("misbehaviour", "count"), [("FORKS", 3), ("KILLS_PARENT", 1)])
def test_processes_that_leave_their_session_are_ended(
    foundry: Path, left_behind: Callable[[], list[int]], scratch: Path, misbehaviour: str, count: int
):
    sentence = stopped(faulty_fmu(foundry, misbehaviour))
    assert sentence.startswith(f"{misbehaviour.lower()}.fmu: at 0.1 s ")
    assert len(left_behind()) == count, "it did start them"
    until(lambda: not any(map(is_running, left_behind())))
    assert list(scratch.iterdir()) == [], "its files are gone"


def test_memory_is_limited(foundry: Path):
    sentence = stopped(faulty_fmu(foundry, "ALLOCATES"), FmuLimits(memory_mib=700))
    assert "its process was ended by SIGSEGV when it had " in sentence
    assert "MiB; memory_mib under [limits.fmu] is 700)" in sentence


@pytest.mark.parametrize(
    ("misbehaviour", "limits", "sentence"),
    [
        ("LOGS", FmuLimits(messages=25_000), "it logged more than allowed; messages under [limits.fmu] is 25000"),
        ("PRINTS", FmuLimits(output_mib=5), "it printed more than allowed; output_mib under [limits.fmu] is 5"),
    ],
)
def test_the_total_output_is_limited(
    foundry: Path, misbehaviour: str, limits: FmuLimits, sentence: str, capfd: pytest.CaptureFixture[str]
):
    """Ten thousand messages and two megabytes per step: the third step exceeds the limit."""
    file = faulty_fmu(foundry, misbehaviour)
    assert stopped(file, limits) == f"{file.name}: at 0.12 s the FMU was stopped ({sentence})."
    assert len(capfd.readouterr().err) <= 5.1 * 2**20, "the limit, and a piece of 64 KiB"


def test_the_calls_of_a_run_have_a_time_budget(foundry: Path, scratch: Path):
    """Each step takes a fifth of a second, less than the patience; the process starts in more than half of one."""
    sentence = stopped(faulty_fmu(foundry, "SLEEPS"), FmuLimits(patience=5.0, budget=2.0))
    assert sentence.endswith("(its calls took longer than allowed; budget under [limits.fmu] is 2 s).")
    assert list(scratch.iterdir()) == []


def test_trial_runs_and_the_stop_share_one_budget(foundry: Path):
    """A run of seven quick steps and five that print two megabytes each; a second such run exceeds the budget."""

    def steps(plant: IsolatedCoSimulation) -> None:
        with plant as running:
            running.start(np.zeros(4))
            for _ in range(15):
                running.step(np.zeros(4))

    file, limits = faulty_fmu(foundry, "PRINTS"), FmuLimits(output_mib=15)
    steps(isolated(file, limits))
    steps(isolated(file, limits))
    with shared_budget():
        steps(isolated(file, limits))
        with pytest.raises(PlantFailed, match="it printed more than allowed"):
            steps(isolated(file, limits))


@pytest.mark.parametrize("misbehaviour", ["CRASHES_IN_TERMINATE", "CRASHES_IN_FREE"])
def test_a_crash_at_the_end_is_reported_and_keeps_the_results(foundry: Path, scratch: Path, misbehaviour: str):
    sentences: list[str] = []
    with isolated(faulty_fmu(foundry, misbehaviour), notify=sentences.append) as plant:
        plant.start(np.zeros(4))
        assert plant.step(np.zeros(4))[0] == pytest.approx(0.2), "20 m/s for 10 ms"
    assert sentences == [
        f"{misbehaviour.lower()}.fmu: when it was terminated and freed after the last step, its process was ended by "
        "SIGABRT; the results are valid."
    ]
    assert list(scratch.iterdir()) == []


def test_a_regular_end_prints_nothing(foundry: Path):
    with isolated(faulty_fmu(foundry), notify=pytest.fail) as plant:
        plant.start(np.zeros(4))


def test_an_fmu_that_closes_every_descriptor_is_reported(foundry: Path, capfd: pytest.CaptureFixture[str]):
    sentence = stopped(faulty_fmu(foundry, "CLOSES"))
    assert sentence.endswith("the FMU crashed (it closed the descriptor by which its process answers).")
    assert "Traceback" not in capfd.readouterr().err


def test_open_files_are_limited(foundry: Path):
    assert stopped(faulty_fmu(foundry, "OPENS_FILES")).endswith("it says: error: no more files.")


def test_a_start_has_the_same_time_limit_as_a_step(foundry: Path, scratch: Path):
    sentence = stopped(faulty_fmu(foundry, "NEVER_INSTANTIATES"), FmuLimits(patience=1.0))
    assert sentence.endswith("at 0 s the FMU did not return (within 1 s of real time, it was stopped).")
    assert list(scratch.iterdir()) == []


class Exploit:
    """Creates a file when it is unpickled."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.file,)


def test_an_answer_forged_by_the_fmu_runs_no_code(foundry: Path, tmp_path: Path):
    mark = tmp_path / "ran"
    payload = pickle.dumps(Exploit(mark))
    pickle.loads(payload)
    assert mark.exists(), "that is what it does where it is unpickled"
    mark.unlink()
    sentence = stopped(faulty_fmu(foundry, "FORGES", forged=struct.pack("<BI", FAILED, len(payload)) + payload))
    assert sentence.endswith("the FMU crashed (its process answered nonsense).")
    assert not mark.exists()


@pytest.mark.parametrize("length", [3, 1 << 31])
def test_an_answer_of_wrong_length_is_invalid(foundry: Path, length: int):
    sentence = stopped(faulty_fmu(foundry, "FORGES", forged=struct.pack("<BI", ANSWER, length) + b"abc"))
    assert sentence.endswith("the FMU crashed (its process answered nonsense).")


def test_the_fmus_process_imports_nothing_from_the_current_folder(
    foundry: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """A downloaded folder may contain such a module; it used to be executed, and the FMU was blamed."""
    mark = tmp_path / "ran"
    for name in ("random", "numpy", "fmpy", "railgrip", "struct"):
        (tmp_path / f"{name}.py").write_text(f"open({str(mark)!r}, 'w').close()\nraise ImportError('a trap')\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    assert stopped(faulty_fmu(foundry, "ERROR_STATUS")).endswith("the wheel came off.")
    assert not mark.exists()


def test_the_keeper_needs_only_the_standard_library():
    result = subprocess.run(
        [sys.executable, "-I", "-S", "-c", f"import runpy; runpy.run_path({str(KEEPER)!r})"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
