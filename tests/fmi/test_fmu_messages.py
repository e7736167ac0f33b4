"""Messages and warnings of FMUs: counted, shown once, stored, and taken from any thread without a deadlock."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from faulty_fmu import faulty_fmu, stop_of_plant
from tiny_fmu import tied, tiny, xml
from waiting import LONGEST, until

from railgrip.fmi import CoSimulation, IsolatedCoSimulation, describe, open_plant
from railgrip.report.stop import read_stop


@pytest.mark.parametrize("trust", [True, False])
@pytest.mark.parametrize(
    ("misbehaviour", "message"),
    [
        ("WARNS", "table of brake force is extrapolated at 0.1 s"),  # later ones differ in the time
        ("WARNS_IN_SILENCE", "the status of a call was a warning, without a message"),
        ("LOGS_FROM_A_THREAD", "a worker speaks"),
    ],
)
def test_warnings_are_shown_once_with_their_number_and_stored(
    tmp_path: Path, foundry: Path, command, trust: bool, misbehaviour: str, message: str
):
    """From 0.1 s on, each step of 10 ms warns once: the number follows from the duration of the stop."""
    file, out = tmp_path / "town.toml", tmp_path / "out"
    result = command("run", stop_of_plant(file, faulty_fmu(foundry, misbehaviour), trust=trust), "--out", out)
    assert result.code == 0, result.err
    duration = json.loads((out / "stop.json").read_text())["duration_s"]
    count = round(duration / 0.01) - 10
    name = f"{misbehaviour.lower()}.fmu"
    assert result.err.count(f"{name} warned {count} times: {message}.") == 1
    assert result.err.count(message) == 1
    assert read_stop(out).fmu_warnings == {name: {message: count}}


def test_references_become_names(tmp_path: Path, foundry: Path, command):
    """FMI 2.0.4, §2.1.5: #r12# is the Real variable of value reference 12, ## is #; #r99# is not a variable."""
    file = stop_of_plant(tmp_path / "town.toml", faulty_fmu(foundry, "REFERS"))
    result = command("run", file, "--out", tmp_path / "out")
    assert "it says: error: speed is above #r99#, see #5." in result.err


def warned(foundry: Path, misbehaviour: str, steps: int, kind: type[CoSimulation] = CoSimulation) -> dict[str, int]:
    """Return the warnings of a tiny FMU after some steps; they are kept after its end."""
    description = describe(tiny(foundry, misbehaviour))
    with kind(description, tied(description), period=1e-3, parameters={"allowed": 0}) as plant:
        plant.start(np.zeros(1))
        for _ in range(steps):
            plant.step(np.zeros(1))
        before = dict(plant.warnings)
    assert plant.warnings == before
    return before


@pytest.mark.parametrize("kind", [CoSimulation, IsolatedCoSimulation])
def test_messages_that_differ_only_in_numbers_are_of_one_kind(foundry: Path, kind: type[CoSimulation]):
    """tiny.c warns in each step with its time; #r0# and #r5# are two variables, not two numbers."""
    assert warned(foundry, "WARNS", 20, kind) == {"x is late by 0": 20, "y is late by 0": 20}


def test_kinds_of_messages_are_limited(foundry: Path):
    warnings = warned(foundry, "WARNS_ALWAYS_OTHERWISE", 26)
    assert (len(warnings), warnings["further messages"], sum(warnings.values())) == (21, 6, 26)


TO_NOBODY = """
import json, sys
from pathlib import Path
import numpy as np
from tiny_fmu import tied
from railgrip.fmi import CoSimulation, describe

description = describe(Path(sys.argv[1]))
open_one = lambda: CoSimulation(description, tied(description), period=1e-3, parameters={"allowed": 0})
with open_one() as plant:
    plant.start(np.zeros(1))
    plant.step(np.zeros(1))
    alone = dict(plant.warnings)
    with open_one() as other:
        other.start(np.zeros(1))
        other.step(np.zeros(1))
        print(json.dumps([alone, dict(other.warnings), dict(plant.warnings)]))
"""


def test_a_message_to_an_unknown_instance_belongs_to_the_only_one_or_is_dropped(foundry: Path):
    """Some FMUs pass themselves instead of the environment that they were given, and no category.

    In a process of its own: an FMU that another test of this process has open would be a second instance.
    """
    fmu = tiny(foundry, "WARNS_SOMEBODY_ELSE")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    result = subprocess.run(
        [sys.executable, "-c", TO_NOBODY, fmu], capture_output=True, text=True, env=environment, check=False
    )
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout) == [{"hello": 1}, {}, {"hello": 1}]


def test_control_codes_do_not_reach_the_terminal(foundry: Path):
    assert warned(foundry, "WARNS_IN_COLOUR", 1) == {"[31mred  line": 1}


@pytest.mark.skipif(not Path("/proc").exists(), reason="needs POSIX signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_program_though_a_trusted_fmu_never_returns(tmp_path: Path, foundry: Path, number: int):
    marker = tmp_path / "in_the_step"
    command = str(Path(sys.executable).with_name("railgrip"))
    file = stop_of_plant(tmp_path / "town.toml", faulty_fmu(foundry, "NEVER_RETURNS"))
    environment = os.environ | {"FAULTY_MARKER": str(marker)}
    process = subprocess.Popen(
        [command, "run", str(file), "--out", str(tmp_path / "out")], stderr=subprocess.PIPE, env=environment
    )
    until(marker.exists)
    process.send_signal(number)
    _, errors = process.communicate(timeout=LONGEST)
    assert process.returncode == 128 + number
    assert b"never_returns.fmu does not return, so the program ends at once" in errors


@pytest.mark.skipif(os.name != "posix", reason="isolation needs POSIX")
def test_an_fmu_of_one_instance_runs_in_a_process_of_its_own(foundry: Path):
    """Trial runs in this process would use up its only instance."""
    text = xml().replace("<CoSimulation ", '<CoSimulation canBeInstantiatedOnlyOncePerProcess="true" ')
    description, sentences = describe(tiny(foundry, description=text)), list[str]()
    plant = open_plant(
        description, tied(description), period=1e-3, parameters={}, trusted=True, notify=sentences.append
    )
    assert isinstance(plant, IsolatedCoSimulation)
    assert "only once in a process, and runs in a separate one in spite of trust = true" in sentences[0]
