"""The examples of docs/how_to/own_plant.md run as printed."""

import json
import re
import shlex
from pathlib import Path

import pytest
from command_line import exit_code
from faulty_fmu import faulty_fmu, quick_stop

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/how_to/own_plant.md").read_text(encoding="utf-8")

HEAD = """
name = "mine"
extends = "plain"
"""

THEIRS = (
    {f"pressure_command[{i}]": f"cylinder[{i}].demand" for i in range(1, 5)}
    | {f"mu0[{i}]": f"rail[{i}].grip" for i in range(1, 7)}
    | {f"wheelset_speed[{i}]": name for i, name in enumerate(("front.n", "axle3.n", "axle4.n", "rear.n"), start=1)}
    | {"acceleration": "retardation"}
)


def test_the_scenario_with_the_mapping_of_the_page_runs(foundry: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The FMU has friction in per cent and outputs its decelerating forces, as the table states."""
    block = re.search(r"^```toml\n(\[vehicle\]\n.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    monkeypatch.chdir(tmp_path)
    faulty_fmu(foundry, names=THEIRS, defined=("SIGN=-1", "GRIP=0.0981")).rename(tmp_path / "MyTrain.fmu")
    (tmp_path / "mine.toml").write_text(f"{HEAD}\n{block[1]}\n{quick_stop('slip_two_state')}")
    assert exit_code("run", "mine.toml") == 0
    (result,) = (tmp_path / "build/runs").glob("mine-*/stop.json")
    assert json.loads(result.read_text())["outcome"] == "standstill"


@pytest.mark.parametrize(
    ("page", "count", "changes"),
    [
        ("README.md", 1, ("--set", "start.speed=20 km/h")),
        ("docs/how_to/own_plant.md", 2, ("--set", "start.speed=20 km/h")),
        ("docs/how_to/driver_demand.md", 2, ()),
    ],
)
def test_the_commands_run(
    page: str, count: int, changes: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Commands that run a stop, from 20 km/h to save time; tests/fmus has the tests of `railgrip build`."""
    monkeypatch.chdir(ROOT)
    text = (ROOT / page).read_text(encoding="utf-8")
    commands = re.findall(r"railgrip (run\s+[^`\n]+)", text)
    assert len(commands) == count
    for k, command in enumerate(commands):
        folder = tmp_path / str(k)
        assert exit_code(*shlex.split(command), *changes, "--out", folder) == 0
        assert json.loads((folder / "stop.json").read_text())["outcome"] == "standstill"
