"""Plausible mistakes in the map, the units and the formation of a foreign plant are refused.

The FMU is the train of modelica/ForeignTrain, which outputs all signals in other units; a correct map runs, and
each mistake changes one entry of it as a person may. Initial speeds are drawn. What cannot be noticed is listed in
docs/limits_of_checks.md.
"""

import copy
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sampling import FUZZ

from railgrip.base.errors import InputError
from railgrip.fmi import describe
from railgrip.fmus.native import package
from railgrip.fmus.native.system import System
from railgrip.scenario.load import scenario_of
from railgrip.simulate.assembly import assemble
from railgrip.simulate.remarks import remarks_before

ROOT = Path(__file__).parents[2]
TABLES = tomllib.loads((ROOT / "harness/scenario/library/foreign_train.toml").read_text(encoding="utf-8"))
GROUPS, WHEELSETS = 4, 6
Tables = dict[str, Any]
Change = Callable[[Tables], None]


@pytest.fixture(scope="module")
def foreign(foreign_train: System, tmp_path_factory: pytest.TempPathFactory) -> Path:
    source = package.sources(foreign_train, interfaces=("cs",), solver="rodas3", tolerance=1e-5, step=5e-3)
    return describe(package.pack(source, tmp_path_factory.mktemp("foreign") / "ForeignTrain.fmu")).file


def entry(name: str, factor: float) -> Change:
    """Return the change of the map by which values of a signal are multiplied by a factor."""

    def change(tables: Tables) -> None:
        table = tables["vehicle"]["map"]
        written = table[name]
        table[name] = (
            [{"variable": variable, "scale": factor} for variable in written]
            if isinstance(written, list)
            else {"variable": written, "scale": factor}
        )

    return change


def order(name: str, numbers: list[int]) -> Change:
    """Return the change of the map by which element i of a signal is element numbers[i] of the FMU."""

    def change(tables: Tables) -> None:
        table = tables["vehicle"]["map"]
        table[name] = [table[name].replace("{i}", str(number)) for number in numbers]

    return change


def all_of(*changes: Change) -> Change:
    def change(tables: Tables) -> None:
        for one in changes:
            one(tables)

    return change


def key(path: str, value: Any) -> Change:
    def change(tables: Tables) -> None:
        *tables_above, last = path.split(".")
        at = tables
        for name in tables_above:
            at = at.setdefault(name, {})
        at[last] = value

    return change


def variable(name: str, text: str) -> Change:
    return key(f"vehicle.map.{name}", text)


REVERSED, SWAPPED = [4, 3, 2, 1], [1, 3, 2, 4]
WHEELS_REVERSED, WHEELS_SWAPPED = [6, 5, 4, 3, 2, 1], [3, 2, 1, 4, 5, 6]

MISTAKES: dict[str, Change] = {
    "the command in MPa for bar": entry("pressure_command", 10),
    "the command in kPa for bar": entry("pressure_command", 0.01),
    "the command in Pa for bar": entry("pressure_command", 1e-5),
    "the command in psi for bar": entry("pressure_command", 1 / 14.5),
    "the command as a share of full brake": entry("pressure_command", 3.8),
    "the command and the pressures in MPa for bar": all_of(
        entry("pressure_command", 10), entry("cylinder_pressure", 10)
    ),
    "the command and the pressures in kPa for bar": all_of(
        entry("pressure_command", 0.01), entry("cylinder_pressure", 0.01)
    ),
    "pressures in MPa for bar": entry("cylinder_pressure", 10),
    "pressures in kPa for bar": entry("cylinder_pressure", 0.01),
    "pressures with the other sign": entry("cylinder_pressure", -1),
    "friction in per cent": entry("mu0", 0.01),
    "friction of per cent as a ratio": entry("mu0", 100),
    "the force of the track with the other sign": variable("track_force", "drag"),
    "the force of the track in N for kN": entry("track_force", -1e-3),
    "the force of the track in MN for kN": entry("track_force", -1e3),
    "the force on each axle for that on the train": entry("track_force", -1 / 6),
    "the speed in m/s for km/h": entry("speed", 3.6),
    "the speed in mph for km/h": entry("speed", 1.609),
    "all speeds in m/s for km/h": all_of(entry("speed", 3.6), entry("start_speed", 3.6)),
    "the initial speed in m/s for km/h": entry("start_speed", 3.6),
    "the distance in m for km": entry("distance", 1e-3),
    "the distance in miles for km": entry("distance", 1.609),
    "the acceleration with the other sign": variable("acceleration", "retardation"),
    "the acceleration in multiples of g": entry("acceleration", -1 / 9.81),
    "wheel speeds in rad/s for rev/min": entry("wheelset_speed", 9.549),
    "wheel speeds in rev/s for rev/min": entry("wheelset_speed", 60),
    "wheel speeds with the other sign": entry("wheelset_speed", -1),
    "wheel speeds at the rim for those of rotation": entry("wheelset_speed", 0.38),
    "wheel speeds of motors": entry("wheelset_speed", 4.8),
    "slip with the other sign": variable("slip", "creep[{i}]"),
    "slip in per cent": entry("slip", -100),
    "slip of per cent as a ratio": entry("slip", -0.01),
    "adhesion with the other sign": variable("adhesion", "used_grip[{i}]"),
    "adhesion in per cent": entry("adhesion", -100),
    "loads in kg for kN": entry("wheelset_load", 9.81e-3),
    "loads of wheels for those of wheelsets": entry("wheelset_load", 0.5),
    "loads in t for kN": entry("wheelset_load", 9.81),
    "commands of groups from the rear": order("pressure_command", REVERSED),
    "commands of two groups exchanged": order("pressure_command", SWAPPED),
    "wheel speeds of groups from the rear": order("wheelset_speed", REVERSED),
    "wheel speeds of two groups exchanged": order("wheelset_speed", SWAPPED),
    "pressures of groups from the rear": order("cylinder_pressure", REVERSED),
    "pressures of two groups exchanged": order("cylinder_pressure", SWAPPED),
    "the pressure of one cylinder for all": order("cylinder_pressure", [1, 1, 1, 1]),
    "brake torques of two groups exchanged": order("brake_torque", SWAPPED),
    "brake torques with the other sign": entry("brake_torque", -1),
    "slips of groups from the rear": order("slip", REVERSED),
    "slips of two groups exchanged": order("slip", SWAPPED),
    "friction of wheelsets from the rear": order("mu0", WHEELS_REVERSED),
    "friction of two wheelsets exchanged": order("mu0", WHEELS_SWAPPED),
    "adhesion of wheelsets from the rear": order("adhesion", WHEELS_REVERSED),
    "adhesion of two wheelsets exchanged": order("adhesion", WHEELS_SWAPPED),
    "commands, pressures and torques from the rear": all_of(
        *(order(name, REVERSED) for name in ("pressure_command", "cylinder_pressure", "brake_torque"))
    ),
    "the diameter of wheels for their radius": key("controller.parameters.r_wheel", 0.76),
    "the radius of wheels in mm": key("controller.parameters.r_wheel", 380.0),
    "groups of the formation from another train": key("vehicle.formation.wheelsets_per_group", [2, 2, 1, 1]),
    "a group for each axle": key("vehicle.formation.wheelsets_per_group", [1, 1, 1, 1, 1, 1]),
    "masses for loads in the formation": key("vehicle.formation.wheelset_load", [14000.0] * 6),
    "loads in kN in the formation": key("vehicle.formation.wheelset_load", [137.3] * 6),
}  # fmt: skip


def scenario_with(change: Change | None, plant: Path, speed: float, force: float = 0.0):
    tables = copy.deepcopy(TABLES)
    tables["vehicle"] |= {"plant": str(plant), "trust": True}
    tables["start"]["speed"] = f"{speed} km/h"
    tables["periods"] = {"communication": "5 ms"}
    tables["controller"] = {"kind": "slip_two_state"}
    tables["track"] = {"force": force}
    if change is not None:
        change(tables)
    return scenario_of(tables, directory=plant.parent, origin="foreign.toml")


def verdict(change: Change | None, plant: Path, speed: float) -> str:
    """Return the fate of the scenario: refused, announced or accepted."""
    try:
        scenario = scenario_with(change, plant, speed)
        with assemble(scenario):
            return "announced" if remarks_before(scenario) else "accepted"
    except InputError:
        return "refused"


@settings(max_examples=4, suppress_health_check=[HealthCheck.function_scoped_fixture], database=None, derandomize=True)
@given(speed=st.floats(40, 110).map(round))
def test_the_correct_map_is_accepted(foreign: Path, speed: float) -> None:
    assert verdict(None, foreign, speed) == "accepted"


@pytest.mark.parametrize("name", sorted(MISTAKES))
def test_a_mistake_is_refused(name: str, foreign: Path) -> None:
    @settings(max_examples=3 if FUZZ else 1, deadline=None, database=None, derandomize=True)
    @given(speed=st.floats(40, 110).map(round))
    def check(speed: float) -> None:
        assert verdict(MISTAKES[name], foreign, speed) != "accepted"

    check()
