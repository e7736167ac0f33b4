"""Plausible mistakes in the map, the units and the formation of a foreign plant are refused.

The FMU is the train of modelica/ForeignTrain, which outputs all signals in other units; a correct map runs, and
each mistake changes one entry of it as a person may. Initial speeds are drawn. What cannot be noticed is listed in
docs/limits_of_checks.md.
"""

import copy
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sampling import FUZZ
from wrong import table

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
Change = tuple[str, str, Any]


@pytest.fixture(scope="module")
def foreign(foreign_train: System, tmp_path_factory: pytest.TempPathFactory) -> Path:
    source = package.sources(foreign_train, interfaces=("cs",), solver="rodas3", tolerance=1e-5, step=5e-3)
    return describe(package.pack(source, tmp_path_factory.mktemp("foreign") / "ForeignTrain.fmu")).file


def entry(tables: Tables, name: str, factor: float) -> None:
    """Multiply the values of a signal by a factor."""
    mapped = tables["vehicle"]["map"]
    written = mapped[name]
    scaled = [{"variable": each, "scale": factor} for each in (written if isinstance(written, list) else [written])]
    mapped[name] = scaled if isinstance(written, list) else scaled[0]


def order(tables: Tables, name: str, numbers: list[int]) -> None:
    """Map element i of a signal to element numbers[i] of the FMU."""
    mapped = tables["vehicle"]["map"]
    mapped[name] = [mapped[name].replace("{i}", str(number)) for number in numbers]


def key(tables: Tables, path: str, value: Any) -> None:
    *tables_above, last = path.split(".")
    at = tables
    for name in tables_above:
        at = at.setdefault(name, {})
    at[last] = value


CHANGES = {"entry": entry, "order": order, "key": key}
MISTAKES: dict[str, list[Change]] = table(__file__, "tables.toml")["mistakes_in_maps"]


def scenario_with(changes: list[Change], plant: Path, speed: float, force: float = 0.0):
    tables = copy.deepcopy(TABLES)
    tables["vehicle"] |= {"plant": str(plant), "trust": True}
    tables["start"]["speed"] = f"{speed} km/h"
    tables["periods"] = {"communication": "5 ms"}
    tables["controller"] = {"kind": "slip_two_state"}
    tables["track"] = {"force": force}
    for kind, place, value in changes:
        CHANGES[kind](tables, place, value)
    return scenario_of(tables, directory=plant.parent, origin="foreign.toml")


def verdict(changes: list[Change], plant: Path, speed: float) -> str:
    """Return the fate of the scenario: refused, announced or accepted."""
    try:
        scenario = scenario_with(changes, plant, speed)
        with assemble(scenario):
            return "announced" if remarks_before(scenario) else "accepted"
    except InputError:
        return "refused"


@settings(max_examples=4, suppress_health_check=[HealthCheck.function_scoped_fixture], database=None, derandomize=True)
@given(speed=st.floats(40, 110).map(round))
def test_the_correct_map_is_accepted(foreign: Path, speed: float) -> None:
    assert verdict([], foreign, speed) == "accepted"


@pytest.mark.parametrize("name", sorted(MISTAKES))
def test_a_mistake_is_refused(name: str, foreign: Path) -> None:
    @settings(max_examples=3 if FUZZ else 1, deadline=None, database=None, derandomize=True)
    @given(speed=st.floats(40, 110).map(round))
    def check(speed: float) -> None:
        assert verdict(MISTAKES[name], foreign, speed) != "accepted"

    check()
