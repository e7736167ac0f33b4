"""The examples of docs/how_to/own_plant.md run as printed."""

import json
import re
import shlex
import tomllib
from pathlib import Path

import pytest
from faulty_fmu import faulty_fmu, quick_stop

from railgrip.cli.main import main
from railgrip.fmi import Signal, bind, describe

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/how_to/own_plant.md").read_text(encoding="utf-8")

HEAD = """
name = "mine"
seed = 1
"""

THEIRS = (
    {f"pressure_command[{i}]": f"cylinder[{i}].demand" for i in range(1, 5)}
    | {f"mu0[{i}]": f"rail[{i}].grip" for i in range(1, 7)}
    | {f"wheelset_speed[{i}]": name for i, name in enumerate(("front.n", "axle3.n", "axle4.n", "rear.n"), start=1)}
    | {"acceleration": "retardation"}
)


@pytest.fixture
def printed() -> str:
    """Return the page's example of a mapping."""
    block = re.search(r"^```toml\n(\[vehicle\]\n.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    assert block
    return block[1]


def test_the_mapping_says_what_it_seems_to_say(printed: str, foundry: Path):
    """Their friction counts in per cent, so 0.3 of ours is 30 of theirs; what slows down is negative to us."""
    table = tomllib.loads(printed)["vehicle"]["map"]
    binding = bind(
        describe(faulty_fmu(foundry, names=THEIRS)),
        inputs=[
            Signal(name="pressure_command", unit="Pa", size=4, needed=True),
            Signal(name="mu0", unit="1", size=6, needed=True),
        ],
        outputs=[
            Signal(name="wheelset_speed", unit="rad/s", size=4, needed=True),
            Signal(name="acceleration", unit="m/s2", size=0, needed=True),
        ],
        table=table,
    )
    channel_in, channel_out = binding.inputs.channels[0], binding.outputs.channels[0]
    gain = dict(
        zip((*channel_in.variables, *channel_out.variables), (*channel_in.gain, *channel_out.gain), strict=True)
    )
    assert gain["rail[6].grip"] == pytest.approx(100.0)
    assert gain["cylinder[4].demand"] == gain["axle3.n"] == 1.0
    assert gain["retardation"] == -1.0


def test_the_scenario_with_it_runs(printed: str, foundry: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Their FMU takes friction in per cent, as the table says."""
    monkeypatch.chdir(tmp_path)
    faulty_fmu(foundry, names=THEIRS, defined=("SIGN=-1", "GRIP=0.0981")).rename(tmp_path / "MyTrain.fmu")
    (tmp_path / "mine.toml").write_text(f"{HEAD}\n{printed}\n{quick_stop('slip_two_state')}")
    with pytest.raises(SystemExit) as end:
        main(["run", "mine.toml"])
    assert (end.value.code or 0) == 0
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
    """Those that run a stop, from 20 km/h to save time. tests/fmus has the tests of `railgrip build`."""
    monkeypatch.chdir(ROOT)
    text = (ROOT / page).read_text(encoding="utf-8")
    commands = re.findall(r"railgrip (run\s+[^`\n]+)", text)
    assert len(commands) == count
    for k, command in enumerate(commands):
        folder = tmp_path / str(k)
        with pytest.raises(SystemExit) as end:
            main([*shlex.split(command), *changes, "--out", str(folder)])
        assert (end.value.code or 0) == 0
        assert json.loads((folder / "stop.json").read_text())["outcome"] == "standstill"
