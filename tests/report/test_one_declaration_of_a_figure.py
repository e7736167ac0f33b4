"""A new figure is one field of `Metrics`: files, tables, comparison, reference and interface then have it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import railgrip.trace.metrics
from railgrip.report.limits import AssessmentLimits
from railgrip.trace.metrics import FIGURES, Figure

ROOT = Path(__file__).parents[2]

FIELD = """
    comfort: Annotated[Each, Figure("m/s2", "greatest deceleration at each group, which passengers feel",
        lambda stop: tuple(2.0 + number for number in range(4)), extent="group", combined="maximum", title="discomfort",
        column="greatest deceleration", form="{:.2f} m/s²", over_draws="median", better="less", is_compared=True)]
    # fmt: on
"""

PROGRAM = """
import importlib.util, json, sys
from pathlib import Path
source, tests, folder = sys.argv[1:]
sys.path[:0] = [tests + "/report", tests]
spec = importlib.util.spec_from_file_location("railgrip.trace.metrics", source)
sys.modules[spec.name] = module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
import railgrip.trace
railgrip.trace.metrics = module

from synthetic import LIBRARY
from synthetic_runner import run_stop
from test_distributions import CAMPAIGN as DRAWS
import railgrip as rg
from railgrip.campaign.sweep import csv_of, write_table as write_frame
from railgrip.campaign.run import write_description
from railgrip.report.distances import write_table
from railgrip.report.results import read_results
from railgrip.report.stop import metrics_table, write_stop
from railgrip.scenario.campaign import load_campaign
import pandas

folder = Path(folder)
for name, text in (("drawn", DRAWS), ("single", DRAWS.replace("[draws]", "[sweep]\\nseed = [1]\\n[ignored]"))):
    text = text.format(library=LIBRARY.as_posix()).split("[ignored]\\nfirst = 1\\nlast = 4\\n")
    place = folder / name
    place.mkdir()
    file = place / "c.toml"
    file.write_text("".join(text), encoding="utf-8")
    periods = [f"periods.{one}=10 ms" for one in ("communication", "estimator", "controller")]
    campaign = load_campaign(file, periods)
    write_description(campaign, place)
    for stop in campaign.stops:
        write_stop(run_stop(stop.scenario), place / stop.name)
frame = rg.load(folder / "drawn").to_pandas()
write_frame(frame, folder / "x.parquet")
stops = read_results(folder / "single").stops
compared = rg.compare(stops[0], __import__("dataclasses").replace(
    stops[1], metrics=__import__("dataclasses").replace(stops[1].metrics, comfort=(1.0,) * 4)))
print(json.dumps({
    "stop.json": json.loads(next((folder / "single").glob("*/stop.json")).read_text())["metrics"]["comfort"],
    "frame": frame["comfort[4]"].tolist()[:1],
    "csv": csv_of(frame).splitlines()[0].split(",").count("comfort[2] [m/s2]"),
    "parquet": float(pandas.read_parquet(folder / "x.parquet")["comfort[4] [m/s2]"].iloc[0]),
    "xarray": rg.load(folder / "drawn").to_xarray()["comfort"].dims[-1],
    "single": write_table(read_results(folder / "single"), folder / "single")[1].read_text(encoding="utf-8"),
    "drawn": write_table(read_results(folder / "drawn"), folder / "drawn")[1].read_text(encoding="utf-8"),
    "stop page": [row for row in metrics_table(stops[0].figures).rows if row["figure"] == "comfort"],
    "comparison": [row["figure"] for row in compared.answer.rows],
    "compared": stops[0].metrics.compared()["comfort"],
    "axis": module.FIGURES["comfort"].axis,
    "reference": __import__("railgrip.trace.metrics", fromlist=["FIGURES"]).FIGURES["comfort"].meaning,
}))
"""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("figure")
    source = Path(railgrip.trace.metrics.__file__).read_text(encoding="utf-8")
    assert source.count("    # fmt: on\n") == 1
    (folder / "metrics.py").write_text(source.replace("    # fmt: on\n", FIELD.lstrip("\n")), encoding="utf-8")
    (folder / "results").mkdir()
    command = [sys.executable, "-c", PROGRAM, str(folder / "metrics.py"), str(ROOT / "tests"), str(folder / "results")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_a_new_figure_is_everywhere(found):
    assert found["stop.json"] == [2.0, 3.0, 4.0, 5.0]
    assert found["frame"] == [5.0]
    assert found["csv"] == 1
    assert found["parquet"] == 5.0
    assert found["xarray"] == "group"
    assert found["compared"] == 5.0
    assert found["axis"] == "discomfort [m/s2]"
    assert {f"comfort[{group}]" for group in (1, 2, 3, 4)} <= set(found["comparison"])
    (row,) = found["stop page"]
    assert row == {
        "figure": "comfort", "value": "2, 3, 4, 5", "unit": "m/s2",
        "meaning": "greatest deceleration at each group, which passengers feel",
    }  # fmt: skip


def test_it_has_a_column_in_both_tables_of_a_campaign(found):
    assert "| greatest deceleration |" in found["single"]
    assert "| 5.00 m/s² |" in found["single"]
    assert "| greatest deceleration, median |" in found["drawn"]
    assert "| 5.00 m/s² |" in found["drawn"]


def test_a_declaration_is_complete():
    """A figure whose declaration lacks something fails here with what to add."""
    for name, figure in FIGURES.items():
        assert isinstance(figure, Figure)
        assert figure.column == "" or figure.extent == "train" or figure.combined, (
            f"{name}: has a column, but not how values of its {figure.extent}s become one; add combined=… in metrics.py"
        )
        assert not figure.over_draws or figure.column, f"{name}: has a statistic over draws; add column=…"
        assert not figure.clause or figure.clause in AssessmentLimits.model_fields, (
            f"{name}: clause {figure.clause} is not in report/limits.py; add it there"
        )
        assert not figure.clause or figure.better, f"{name}: has a limit; add better='less' or better='more'"
