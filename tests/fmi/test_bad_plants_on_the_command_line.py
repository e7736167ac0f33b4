"""`railgrip run` with a foreign plant: any fault of it is reported in a sentence with an exit code.

The whole path is real: scenario file, mapping, FMU in a separate process or in this one, loop, result.
"""

import json
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from command_line import Done
from faulty_fmu import faulty_fmu, stop_of_plant
from wrong import table

from railgrip.report.stop import read_stop

Railgrip = Callable[..., Done]


@pytest.fixture
def railgrip(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: Railgrip) -> Railgrip:
    """Run town.toml with a plant, in this process; results go to `out`."""
    monkeypatch.chdir(tmp_path)

    def run(plant: Path, **more) -> Done:
        return command("run", stop_of_plant(tmp_path / "town.toml", plant, **more), "--out", "out")

    return run


def test_a_plant_with_the_standard_names_needs_no_table(railgrip: Railgrip, foundry: Path):
    result = railgrip(faulty_fmu(foundry))
    assert result.code == 0, result.err
    # 3.4, 2, 2 and 3.4 bar on average times its rate are 1.08 m/s2. It moves on with the speed at the beginning of a
    # step: over all steps of 10 ms together half a step at 10 m/s too far.
    assert "town: standstill" in result.out
    # It does not output its adhesion, so its utilisation is unknown and not printed.
    assert "nan" not in result.out
    assert "warned" not in result.err
    content = json.loads(Path("out/stop.json").read_text())
    assert "fmu_warnings" not in content
    assert content["distance_m"] == pytest.approx((10**2 - 0.1**2) / 2 / 1.08 + 0.05, abs=2e-3)


FAILED = "plant_failed", 0.1
"""Outcome and duration [s]."""


@pytest.mark.parametrize(
    ("misbehaviour", "trust", "end", "sentence"),
    [
        ("ERROR_STATUS", True, FAILED, "fmi2DoStep returned fmi2Error; it says: error: the wheel came off."),
        ("CRASH", False, FAILED, "the FMU crashed (its process was ended by SIGSEGV)."),
        ("NEVER_HALTS", True, ("horizon", 30.0), "Still moving at 5.00 m/s after 30 s"),
    ],
)
def test_a_plant_that_fails_is_a_result_and_exits_3(
    railgrip: Railgrip, foundry: Path, misbehaviour: str, trust: bool, end: tuple[str, float], sentence: str
):
    result = railgrip(faulty_fmu(foundry, misbehaviour), trust=trust)
    assert result.code == 3
    assert f"town: no braking distance, the stop ended with {end[0]}: " in result.err
    assert sentence in result.err
    content = json.loads(Path("out/stop.json").read_text())
    # Earlier samples are kept.
    assert (content["outcome"], content["duration_s"]) == (end[0], pytest.approx(end[1], abs=0.011))


@pytest.mark.parametrize("trust", [True, False])
def test_a_plant_that_does_not_start_leaves_a_result_without_numbers(railgrip: Railgrip, foundry: Path, trust: bool):
    """Its only row contains no number, rather than uninitialised memory."""
    result = railgrip(faulty_fmu(foundry, "NEVER_STARTS"), trust=trust)
    assert result.code == 3
    assert "plant_failed: never_starts.fmu: at 0 s fmi2ExitInitializationMode returned fmi2Error" in result.err
    content = json.loads(Path("out/stop.json").read_text())
    assert (content["outcome"], content["duration_s"], content["distance_m"]) == ("plant_failed", 0.0, None)
    assert np.isnan(read_stop(Path("out")).trace["speed"].values).all()


@pytest.mark.parametrize(("more", "defined", "sentence"), table(__file__, "tables.toml")["wrong_plants"])
def test_a_short_run_finds_a_wrong_map_or_radius(
    railgrip: Railgrip, foundry: Path, more: str, defined: tuple[str, ...], sentence: str
):
    result = railgrip(faulty_fmu(foundry, defined=defined), more=f"[vehicle.map]\n{more}")
    assert result.code == 2
    assert "town: [vehicle.map] does not fit well.fmu: in a short run before the stop '" in result.err
    assert sentence in result.err
    assert not Path("out/stop.json").exists()


def test_a_wrong_plant_in_a_process_of_its_own_is_found_before_the_stop(railgrip: Railgrip, foundry: Path):
    """Both runs of the trial, on a good rail and on a poor one, start the process anew."""
    result = railgrip(faulty_fmu(foundry, defined=("GRIP=1e9",)), trust=False)
    assert result.refuses("'mu0' does not bound the brakes: they slow the train by 1.08 m/s2 with friction of 0.4")
    assert not Path("out/stop.json").exists()


def test_a_draft_of_the_map_is_printed_with_the_results_of_a_short_run(foundry: Path, command: Railgrip):
    theirs = {"speed": "velocity", "distance": "odometer", "acceleration": "retardation", "start_speed": "v0"}
    theirs |= {f"pressure_command[{i}]": f"demand[{i}]" for i in range(1, 5)}
    wheels = ["front.n", "axle2.n", "axle3.n", "rear.n"]
    theirs |= {f"wheelset_speed[{i}]": name for i, name in enumerate(wheels, start=1)}
    result = command("map", faulty_fmu(foundry, names=theirs, defined=("RADIUS=0.46", "GRIP=0.0981")))
    assert result.code == 0
    out = result.out
    draft = tomllib.loads(out)["vehicle"]["map"]
    assert draft["pressure_command"] == "demand[{i}]"
    assert draft["wheelset_speed"] == wheels
    assert draft["mu0"] == {"variable": "mu0[{i}]", "scale": 0.01}
    assert "# corrected: mu0 had percent for a ratio" in out
    assert (draft["speed"], draft["distance"], draft["start_speed"]) == ("velocity", "odometer", "v0")
    # Its sign convention is ours, whatever the name suggests, and its wheels are larger: the run reveals both.
    assert draft["acceleration"] == "retardation"
    assert "# corrected: acceleration had the other sign; in the first run acceleration has" in out
    assert "WRONG" not in out
    assert tomllib.loads(out)["vehicle"]["formation"] == {
        "wheelsets_per_group": [2, 1, 1, 2],
        "brakes": {"r_wheel": [0.46] * 4},
    }
    assert "# fits: distance" in out


@pytest.mark.parametrize(
    ("plant", "more", "sentence"),
    [
        ("gone.fmu", "", "town.toml: [vehicle] plant names 'gone.fmu', but there is no file"),
        ("", 'map.speed = "sped"', "town: [vehicle.map] speed: well.fmu has no variable 'sped'; did you mean 'speed'"),
        ("", "parameters.start_sped = 3", "[vehicle.parameters] has no parameter 'start_sped'; did you mean"),
    ],
)
def test_a_plant_that_does_not_match_is_refused_with_exit_code_2(
    railgrip: Railgrip, foundry: Path, plant: str, more: str, sentence: str
):
    result = railgrip(plant or faulty_fmu(foundry), more=more)
    assert result.code == 2
    assert sentence in result.err
    assert result.out == ""
    assert not Path("out/stop.json").exists()
