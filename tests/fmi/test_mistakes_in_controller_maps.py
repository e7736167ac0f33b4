"""Plausible mistakes in the map of a controller FMU are refused, announced, or change the stop in sight.

The FMU is a built-in law of slip, exported, with names and units that a map has to translate.
"""

from pathlib import Path
from typing import Any

import pytest

from railgrip.base.errors import InputError
from railgrip.fmus.native.package import pack
from railgrip.scenario.load import load
from railgrip.scenario.schema import Scenario
from railgrip.simulate.export.controller_and_plant import controller_fmu
from railgrip.simulate.run import run_stop

ROOT = Path(__file__).parents[2]
PLAIN = ROOT / "harness/scenario/library/plain.toml"
LAW = ("controller.kind=slip_three_state", "estimator.kind=none", "adhesion.mu0=0.06", "start.speed=20 km/h")


@pytest.fixture(scope="module")
def law(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pack(controller_fmu(load(PLAIN, LAW)), tmp_path_factory.mktemp("law") / "law.fmu")


def each(name: str, numbers: list[int]) -> list[str]:
    return [f"{name}[{number}]" for number in numbers]


REVERSED, SWAPPED = [4, 3, 2, 1], [1, 3, 2, 4]
RIGHT: dict[str, Any] = {
    "speed": "speed", "slip": "slip[{i}]", "pressure": "pressure[{i}]", "driver_demand": "driver_demand[{i}]",
    "demand": "demand[{i}]",
}  # fmt: skip

MISTAKES: dict[str, dict[str, Any]] = {
    "slip of groups from the rear": {"slip": each("slip", REVERSED)},
    "slip of two groups exchanged": {"slip": each("slip", SWAPPED)},
    "demands of groups from the rear": {"demand": each("demand", REVERSED)},
    "demands of two groups exchanged": {"demand": each("demand", SWAPPED)},
    "demands of two neighbours exchanged": {"demand": each("demand", [2, 1, 3, 4])},
    "slip with the other sign": {"slip": "-slip[{i}]"},
    "slip in per cent": {"slip": {"variable": "slip[{i}]", "scale": 100}},
    "demands in bar": {"demand": {"variable": "demand[{i}]", "scale": 1e-5}},
    "demands in kPa": {"demand": {"variable": "demand[{i}]", "scale": 1e-3}},
    "demands with the other sign": {"demand": "-demand[{i}]"},
}


def scenario_of(law: Path, changes: dict[str, Any]) -> Scenario:
    controller = {"kind": "fmu", "file": str(law), "trust": True, "map": {}}
    known = controller_inputs(law)
    controller["map"] = {name: entry for name, entry in (RIGHT | changes).items() if name in known}
    return load(PLAIN, LAW[1:]).revised({}).model_validate(load(PLAIN, LAW[1:]).tables() | {"controller": controller})


def controller_inputs(law: Path) -> set[str]:
    from railgrip.fmi import describe

    return {name.partition("[")[0] for name in describe(law).variables}


def test_the_right_map_gives_the_stop_of_the_law(law: Path) -> None:
    sentences: list[str] = []
    stop = run_stop(scenario_of(law, {}), notify=sentences.append)
    built_in = run_stop(load(PLAIN, LAW))
    assert stop.metrics.distance == pytest.approx(built_in.metrics.distance, abs=1e-9)
    assert not [sentence for sentence in sentences if "short run" in sentence]


@pytest.mark.parametrize("name", sorted(MISTAKES))
def test_a_mistake_is_noticed(name: str, law: Path) -> None:
    sentences: list[str] = []
    try:
        short = scenario_of(law, MISTAKES[name]).revised({"limits": {"horizon": "8 s"}})  # some never brake
        stop = run_stop(short, notify=sentences.append)
    except InputError:
        return
    is_announced = any("changed no pressure" in sentence for sentence in sentences)
    assert is_announced or stop.limited_demands or stop.outcome.value == "controller_failed", stop.reason
