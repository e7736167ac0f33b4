"""A co-simulation FMU follows its closed form, reports failures in a sentence, and leaves no files behind."""

import os
import pickle
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from threading import Event
from unittest.mock import Mock

import numpy as np
import pytest
from faulty_fmu import faulty_fmu
from tiny_fmu import GUID, repacked, tied, tiny, xml
from waiting import LONGEST

from railgrip.base.errors import FmuError, PlantFailed
from railgrip.fmi import CoSimulation, IsolatedCoSimulation, describe
from railgrip.fmi.instance import Instance, _without_solver_lines, unpack

PERIOD = 1e-3


def opened(file: Path, kind: type[CoSimulation] = CoSimulation, **parameters: object) -> CoSimulation:
    description = describe(file)
    return kind(description, tied(description), period=PERIOD, parameters=parameters)


def closed_form(t: float, rate: float, gain: float, u: float, x: float = 1.0) -> float:
    """Solution of dx/dt = −rate x + gain u."""
    return gain * u / rate + (x - gain * u / rate) * np.exp(-rate * t)


def failing(file: Path, steps: int = 10) -> PlantFailed:
    with opened(file) as plant:
        try:
            plant.start(np.zeros(1))
            for _ in range(steps):
                plant.step(np.zeros(1))
        except PlantFailed as failed:
            return failed
    raise AssertionError(f"{file.name} did not fail in {steps} steps")


def test_a_thousand_steps_give_the_closed_form(foundry: Path):
    with opened(tiny(foundry), rate=4.0, gain=1.5, allowed=10**6) as plant:
        np.testing.assert_array_equal(plant.start(np.array([2.0])), [1.0, 4.0])
        outputs = [plant.step(np.array([2.0])) for _ in range(1000)]
        assert plant.sample == 1000
        assert plant.time == 1.0
    x = closed_form(1.0, rate=4.0, gain=1.5, u=2.0)
    # A thousand roundings of 1e-16 each.
    np.testing.assert_allclose(outputs[-1], [x, 2 * x + 2.0], rtol=1e-13)


def test_inputs_are_held_over_the_step_that_they_are_set_for(foundry: Path):
    """Outputs of earlier steps do not change."""
    with opened(tiny(foundry)) as plant:
        outputs = [plant.start(np.zeros(1)), plant.step(np.array([1.0])), plant.step(np.array([-1.0]))]
    x = closed_form(PERIOD, 2.0, 3.0, 1.0)
    expected = [1.0, x, closed_form(PERIOD, 2.0, 3.0, -1.0, x)]
    assert [row[0] for row in outputs] == pytest.approx(expected, rel=1e-15)


def test_time_is_counted_and_not_summed(foundry: Path):
    """The FMU fails unless it receives exactly k · period; a sum of periods deviates after a few steps."""
    with opened(tiny(foundry), label="strict") as plant:
        plant.start(np.zeros(1))
        for _ in range(30_000):
            plant.step(np.zeros(1))
        assert plant.time == 30_000 * PERIOD
    assert sum([PERIOD] * 30_000) != 30_000 * PERIOD


def test_a_wrong_number_of_inputs_is_refused(foundry: Path):
    with opened(tiny(foundry)) as plant, pytest.raises(ValueError, match=r"a vector of 1, got shape \(2,\)"):
        plant.start(np.zeros(2))


def test_two_plants_share_nothing(foundry: Path):
    file = tiny(foundry)
    with opened(file, rate=1.0) as slow, opened(file, rate=9.0) as fast:
        slow.start(np.zeros(1))
        fast.start(np.zeros(1))
        slow_x, fast_x = slow.step(np.zeros(1))[0], fast.step(np.zeros(1))[0]
    assert slow_x == pytest.approx(np.exp(-1.0 * PERIOD), rel=1e-15)
    assert fast_x == pytest.approx(np.exp(-9.0 * PERIOD), rel=1e-15)


# --- failures --------------------------------------------------------------------------------------------------


FREED = "freed\n"
"""After an error an FMU is freed without being terminated; after fmi2Fatal nothing is called."""


@pytest.mark.parametrize(
    ("misbehaviour", "sentence", "facts", "called"),
    [
        ("ERROR_STATUS", ".fmu: at 0.003 s fmi2DoStep returned fmi2Error; it says: error: the wheel came off at 0.003.",
         {"reason": "error", "time": 0.003}, FREED),
        ("ENDS", "at 0.003 s the FMU requested the end of the simulation", {}, None),
        ("PENDING", "asynchronous FMUs are not supported", {}, None),
        ("NO_STATUS", "no_status.fmu: at 0.003 s fmi2DoStep returned a number that is no fmi2Status (-5).", {}, FREED),
        ("NAN_OUTPUT", "nan_output.fmu: at 0.004 s output 'y' is not a finite number (nan).", {"variable": "y"}, None),
        ("DISCARD", "fmi2Discard", {"reason": "discard", "call": "fmi2DoStep", "reached": 0.0035}, None),
        ("FATAL", "fmi2Fatal", {"reason": "fatal"}, ""),
        ("BAD_INITIALISATION", "the rate does not suit it: 2", {"call": "fmi2ExitInitializationMode"}, None),
    ],
)  # fmt: skip
def test_a_failure_has_time_and_reason(foundry: Path, protests: Path, misbehaviour, sentence, facts, called):
    failure = failing(tiny(foundry, misbehaviour))
    assert sentence in str(failure)
    for name, value in ({"variable": ""} | facts).items():
        assert getattr(failure.failure, name) == (value if isinstance(value, str) else pytest.approx(value))
    assert called is None or protests.read_text() == called


def test_an_invalid_status_ends_a_sequence_of_steps(foundry: Path):
    with opened(tiny(foundry, "NO_STATUS")) as plant:
        plant.start(np.zeros(1))
        with pytest.raises(PlantFailed, match=r"at 0\.003 s fmi2DoStep returned a number that is no fmi2Status \(-5\)"):
            plant.follow(np.zeros((9, 1)))


def test_an_infinite_output_is_a_failure_and_a_large_one_is_not(foundry: Path):
    """The sum of the large outputs would overflow; each of them does not."""
    with opened(tiny(foundry)) as plant:
        np.testing.assert_array_equal(plant.start(np.array([1.5e308])), [1.0, 1.5e308])
    sentence = r"output 'y' is not a finite number \(inf\)"
    with opened(tiny(foundry)) as plant, pytest.raises(PlantFailed, match=sentence):
        plant.start(np.array([np.inf]))


@pytest.mark.parametrize(
    ("kind", "misbehaviour", "guid", "sentence"),
    [
        (CoSimulation, "REFUSES", GUID, "gave no instance; it says: error: no licence for plant"),
        (IsolatedCoSimulation, "REFUSES", GUID, "no licence for plant"),
        (CoSimulation, "WELL", "{other}", "the FMU could not be started"),
    ],
)
def test_a_refused_start_is_reported_with_its_reason(foundry: Path, scratch: Path, kind, misbehaviour, guid, sentence):
    with pytest.raises(PlantFailed, match=sentence):
        opened(tiny(foundry, misbehaviour, description=xml().replace(GUID, guid)), kind).__enter__()
    assert list(scratch.iterdir()) == []


@pytest.mark.parametrize(
    ("kind", "misbehaviour", "sentence"),
    [
        (CoSimulation, "ERROR_STATUS", "the wheel came off at 0"),
        (IsolatedCoSimulation, "CRASH", "ended by SIGSEGV"),
    ],
)
def test_a_failed_plant_repeats_its_failure_instead_of_running(foundry: Path, kind, misbehaviour: str, sentence: str):
    with opened(tiny(foundry, misbehaviour), kind, allowed=0) as plant:
        plant.start(np.zeros(1))
        for _ in range(2):
            with pytest.raises(PlantFailed, match=sentence):
                plant.step(np.zeros(1))


def test_two_fmus_of_one_guid_and_library_name_are_two_libraries(foundry: Path):
    """One of them fails in its first step; the other, open at the same time, steps correctly."""
    with opened(tiny(foundry, "ERROR_STATUS"), allowed=0) as ill, opened(tiny(foundry)) as well:
        ill.start(np.zeros(1))
        well.start(np.zeros(1))
        with pytest.raises(PlantFailed):
            ill.step(np.zeros(1))
        assert well.step(np.ones(1))[0] == pytest.approx(closed_form(PERIOD, 2.0, 3.0, 1.0), rel=1e-15)


def test_a_failure_is_preserved_between_processes(foundry: Path):
    failure = failing(tiny(foundry, "ERROR_STATUS"))
    assert pickle.loads(pickle.dumps(failure)).failure == failure.failure


def test_a_library_that_does_not_load_is_reported(foundry: Path, tmp_path: Path):
    broken = lambda name, content: (name, b"no library" if name.startswith("binaries/") else content)
    path = repacked(tiny(foundry), tmp_path / "broken.fmu", broken)
    with pytest.raises(FmuError, match="its binary does not load on this machine"):
        opened(path).__enter__()


# --- parameters ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"rat": 1.0}, r"has no variable 'rat'; did you mean 'rate'\?"),
        ({"rate": 11.0}, "'rate' of .* is at most 10, got 11"),
        ({"rate": 0}, "'rate' of .* is at least 0.1, got 0"),
        ({"rate": "fast"}, "'rate' of .* is a number, got 'fast'"),
        ({"rate": True}, "'rate' of .* is a number, got True"),
        ({"rate": float("nan")}, "'rate' of .* is a finite number, got nan"),
        ({"allowed": 2.5}, "'allowed' of .* is a whole number, got 2.5"),
        ({"label": 3}, "'label' of .* is a text, got 3"),
        ({"y": 3.0}, "'y' of .* cannot be set, it is calculated or constant; .* rate, gain, label, allowed"),
        ({"u": 3.0}, "'u' of .* cannot be set, it is an input"),
        ({"gain": [1.0, 2.0]}, r"has no variable 'gain\[1\]'; did you mean 'gain'"),
    ],
)
@pytest.mark.parametrize("kind", [CoSimulation, IsolatedCoSimulation])
def test_a_wrong_parameter_is_refused_before_anything_runs(foundry: Path, kind, parameters, sentence: str):
    with pytest.raises(FmuError, match=sentence):
        opened(tiny(foundry), kind, **parameters)


def test_an_array_parameter_is_set_element_by_element(foundry: Path):
    text = xml().replace('name="rate"', 'name="k[1]"').replace('name="gain"', 'name="k[2]"')
    with opened(tiny(foundry, description=text), k=[5.0, 7.0], label="second") as plant:
        plant.start(np.ones(1))
        assert plant.step(np.ones(1))[0] == pytest.approx(closed_form(PERIOD, 5.0, 7.0, 1.0), rel=1e-15)


def test_the_start_value_of_a_state_can_be_set(foundry: Path):
    with opened(tiny(foundry), x=4.0) as plant:
        assert plant.start(np.zeros(1))[0] == 4.0


@pytest.mark.parametrize("period", [0.0, -1e-3, float("nan"), float("inf")])
def test_a_period_is_a_positive_time(foundry: Path, period: float):
    description = describe(tiny(foundry))
    with pytest.raises(FmuError, match="the communication period is a positive time"):
        CoSimulation(description, tied(description), period=period, parameters={})


def test_an_fmu_is_given_the_time_after_which_it_is_not_stepped(foundry: Path):
    """In whole periods; without one it fails, as it does when it is stepped beyond."""
    description = describe(tiny(foundry, "REQUIRES_END"))
    with CoSimulation(description, tied(description), period=PERIOD, parameters={}, span=(2.0, 2.5 * PERIOD)) as plant:
        plant.start(np.zeros(1))
        for _ in range(3):
            plant.step(np.zeros(1))
        with pytest.raises(PlantFailed, match=r"after its end 2\.004"):
            plant.step(np.zeros(1))
    with opened(description.file) as plant, pytest.raises(PlantFailed, match="no stop time"):
        plant.start(np.zeros(1))


# --- leftovers ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("misbehaviour", ["WELL", "ERROR_STATUS", "DISCARD", "FATAL", "NAN_OUTPUT", "REFUSES"])
def test_no_file_is_left_behind(foundry: Path, scratch: Path, misbehaviour: str):
    file = tiny(foundry, misbehaviour)
    during: list[Path] = []
    try:
        with opened(file) as plant:
            during = list(scratch.iterdir())
            plant.start(np.zeros(1))
            for _ in range(10):
                plant.step(np.zeros(1))
    except PlantFailed:
        pass
    assert bool(during) == (misbehaviour != "REFUSES")
    assert list(scratch.iterdir()) == []


def test_nothing_is_left_when_the_caller_fails(foundry: Path, scratch: Path, protests: Path):
    def careless() -> None:
        with opened(tiny(foundry)) as plant:
            plant.start(np.zeros(1))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        careless()
    assert list(scratch.iterdir()) == []
    assert protests.read_text() == "freed\n"


def test_a_plant_is_used_inside_with_and_started_first(foundry: Path):
    plant = opened(tiny(foundry))
    with pytest.raises(RuntimeError, match="inside 'with'"):
        plant.start(np.zeros(1))
    with opened(tiny(foundry)) as plant:
        with pytest.raises(RuntimeError, match="started before it is stepped"):
            plant.step(np.zeros(1))
        plant.start(np.zeros(1))
        with pytest.raises(RuntimeError, match="started once"):
            plant.start(np.zeros(1))
    with pytest.raises(RuntimeError, match="inside 'with'"):
        plant.step(np.zeros(1))


@pytest.mark.parametrize("when", ["TALKS", "TALKS_AT_ONCE"])
@pytest.mark.parametrize("tool", ["OpenModelica Compiler OpenModelica v1.27.0", "another tool"])
def test_only_solver_lines_of_openmodelica_are_removed_from_an_fmus_output(
    foundry: Path, tool: str, when: str, capfd: pytest.CaptureFixture[str]
):
    """1.28 prints them in fmi2Instantiate."""
    description = describe(faulty_fmu(foundry, when, tool=tool))
    with unpack(description) as folder:
        print("before")
        fmu = Instance(description, "co-simulation", folder, name="m")
    with closing(fmu):
        fmu.enter_initialization()
        fmu.exit_initialization()
        print("after")
    printed = capfd.readouterr().out
    assert ("LOG_SOLVER" in printed) is (tool == "another tool")
    assert ("equidistant" in printed) is (tool == "another tool")
    if tool != "another tool":
        assert printed.split() == ["before", "first", "word", "last", "word", "after"]


def test_two_threads_restore_the_standard_output_of_the_process():
    def instantiate(inside: Event, end: Event) -> None:
        with _without_solver_lines(Mock(generator="OpenModelica")):
            inside.set()
            assert end.wait(LONGEST)

    before = os.fstat(1)
    events = [(Event(), Event()) for _ in range(2)]
    with ThreadPoolExecutor(2) as threads:
        (inside, end), (later, last) = events
        tasks = [threads.submit(instantiate, inside, end)]
        assert inside.wait(LONGEST)
        tasks.append(threads.submit(instantiate, later, last))
        later.wait(0.2)  # it comes inside in this time, unless it waits
        end.set()
        tasks[0].result()
        last.set()
        tasks[1].result()
    assert os.path.samestat(os.fstat(1), before)


def test_an_instance_that_cannot_be_created_is_closed(foundry: Path, monkeypatch: pytest.MonkeyPatch):
    """Its log would otherwise be written to after its memory is freed; Ctrl-C may come at any moment."""
    description, closed = describe(tiny(foundry)), []
    close = Instance.close
    monkeypatch.setattr(Instance, "close", lambda self: (closed.append(self), close(self)))
    monkeypatch.setattr("fmpy.fmi2.FMU2Slave.setDebugLogging", Mock(side_effect=KeyboardInterrupt))
    with unpack(description) as folder, pytest.raises(KeyboardInterrupt):
        Instance(description, "co-simulation", folder, name="m")
    assert [one.component for one in closed] == [0]
