"""FMUs of a folder are stepped; for those that cannot be stepped the reason is reported."""

import csv
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import Done
from tiny_fmu import tiny, xml

from railgrip.base.groups import gather


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    place = tmp_path / "fmus" / "vendor"
    place.mkdir(parents=True)
    model_exchange = xml(ways=("ModelExchange",)).replace(
        "<fmiModelDescription ", '<fmiModelDescription generationTool="Tool v1.2" '
    )
    for name, arguments in {
        "cs": {"description": xml(ways=("CoSimulation",))},
        "both": {},
        "me": {"description": model_exchange},
        "crash": {"misbehaviour": "CRASH"},
        "old": {"description": xml(version="1.0")},
        "windows": {"platform": "win32"},
    }.items():
        tiny(tmp_path, **arguments).rename(place / f"{name}.fmu")
    (place / "text.fmu").write_text("no archive")
    return place.parent


def test_each_fmu_has_a_result_or_a_reason_and_the_table_counts_by_tool(folder: Path, command: Callable[..., Done]):
    out = folder.parent / "out" / "fmus.csv"
    result = command("tools", "fmus", folder, "--out", out)
    assert result.code == 0
    rows = list(csv.DictReader(out.open()))
    found = gather((Path(row["file"]).stem, (row["FMI"], row["reason"])) for row in rows)
    assert found["both"] == [("2.0 CS", ""), ("2.0 ME", "")]
    assert found["cs"] == [("2.0 CS", "")]
    assert found["me"] == [("2.0 ME", "")]
    assert ("2.0 CS", "crash") in found["crash"]
    assert found["old"] == [("1.0", "another version of FMI")]
    assert found["windows"][-1][1].startswith("no binary")
    assert found["text"] == [("", "no archive of an FMU")]
    assert {row["tool"] for row in rows if row["file"].endswith("me.fmu")} == {"Tool"}
    assert all(bool(row["reason"]) == bool(row["sentence"]) for row in rows)
    (total,) = (line.split() for line in result.out.splitlines() if line.split()[:1] == ["all,"])
    assert total[-2:] == ["7", "4"], "crash.fmu steps as Model Exchange"
