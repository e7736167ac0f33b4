"""A new figure is one field of `Metrics`: files, tables, comparison, reference and interface then have it."""

import sys
from pathlib import Path

from command_line import ran
from project_files import ROOT

import railgrip.trace.metrics
from railgrip.report.limits import AssessmentLimits
from railgrip.trace.metrics import FIGURES, Figure

FIELD = """
    comfort: Annotated[Each, Figure("m/s2", "greatest deceleration at each group, which passengers feel",
        lambda stop: tuple(2.0 + number for number in range(4)), extent="group", combined="maximum", title="discomfort",
        column="greatest deceleration", form="{:.2f} m/s²", over_draws="median", better="less", is_compared=True)]
    # fmt: on
"""

PROGRAM = """
import importlib.util, json, sys
from dataclasses import replace
from pathlib import Path
source, tests, folder = sys.argv[1:]
sys.path[:0] = [tests + "/report", tests]
spec = importlib.util.spec_from_file_location("railgrip.trace.metrics", source)
sys.modules[spec.name] = module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
import railgrip.trace
railgrip.trace.metrics = module

from test_distributions import CAMPAIGN as DRAWS
from written_campaigns import write_campaign
import railgrip as rg
from railgrip.campaign.sweep import csv_of, write_table as write_frame
from railgrip.report.distances import write_table
from railgrip.report.results import read_results
from railgrip.report.stop import metrics_table
import pandas

drawn, single = folders = [Path(folder) / name for name in ("drawn", "single")]
for place, text in zip(folders, (DRAWS, DRAWS.replace("[draws]\\nfirst = 1\\nlast = 4", "[sweep]\\nseed = [1]"))):
    place.mkdir()
    write_campaign(place, text=text)

frame = rg.load(drawn).to_pandas()
write_frame(frame, drawn / "x.parquet")
assert frame["comfort[4]"].iloc[0] == pandas.read_parquet(drawn / "x.parquet")["comfort[4] [m/s2]"].iloc[0] == 5.0
assert csv_of(frame).splitlines()[0].split(",").count("comfort[2] [m/s2]") == 1
assert rg.load(drawn).to_xarray()["comfort"].dims[-1] == "group"
tables = [write_table(read_results(place), place)[1].read_text(encoding="utf-8") for place in folders]
assert "| greatest deceleration, median |" in tables[0]
assert "| greatest deceleration |" in tables[1]
assert all("| 5.00 m/s² |" in table for table in tables)

stop, other, *_ = read_results(single).stops
content = json.loads((single / stop.name / "stop.json").read_text(encoding="utf-8"))
assert content["metrics"]["comfort"] == [2.0, 3.0, 4.0, 5.0]
assert stop.metrics.compared()["comfort"] == 5.0
(row,) = (row for row in metrics_table(stop.figures).rows if row["figure"] == "comfort")
assert [row["value"], row["unit"]] == ["2, 3, 4, 5", "m/s2"]
assert row["meaning"] == "greatest deceleration at each group, which passengers feel"
answer = rg.compare(stop, replace(other, metrics=replace(other.metrics, comfort=(1.0,) * 4))).answer
assert {f"comfort[{group}]" for group in (1, 2, 3, 4)} <= {row["figure"] for row in answer.rows}
assert module.FIGURES["comfort"].axis == "discomfort [m/s2]"
"""


def test_a_new_figure_is_everywhere(tmp_path):
    source = Path(railgrip.trace.metrics.__file__).read_text(encoding="utf-8")
    assert source.count("    # fmt: on\n") == 1
    (tmp_path / "metrics.py").write_text(source.replace("    # fmt: on\n", FIELD.lstrip("\n")), encoding="utf-8")
    (tmp_path / "results").mkdir()
    done = ran([sys.executable, "-c", PROGRAM, tmp_path / "metrics.py", ROOT / "tests", tmp_path / "results"])
    assert done.returncode == 0, done.stderr


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
