"""One table is output in every format, and a page escapes all text that is not its own markup."""

import csv
import gzip
import math
import re
from pathlib import Path

from pages import needs_nothing_else

import railgrip.report
from railgrip.report.page import Page, write_page
from railgrip.report.table import Link, ReportTable, change, yes_no

TABLE = ReportTable(
    [
        {"stop": "<dry>", "distance": 12.34, "change": 0.1, "kept": True, "beside": None},
        {"stop": "wet", "distance": "none: horizon", "change": -0.05, "kept": False, "beside": math.nan},
    ],
    {"distance": "{:.1f} m", "change": change, "kept": yes_no},
)


def test_a_table_is_markdown():
    assert str(TABLE.drop_empty_columns()) == (
        "| stop | distance | change | kept |\n"
        "|---|--:|--:|--:|\n"
        "| <dry> | 12.3 m | −10.0 % | yes |\n"
        "| wet | none: horizon | +5.0 % | no |"
    )


def test_a_table_is_html_in_a_page_of_html(tmp_path):
    page = Page(
        title="a & b", question="less < more", answer="12 m.", template="report/campaign.md.jinja", values=VALUES
    )
    text = page.write(tmp_path).read_text(encoding="utf-8")
    assert (
        '<tr><td class="text">&lt;dry&gt;</td><td data-value="12.34">12.3\u00a0m</td>'
        '<td data-value="0.1">−10.0\u00a0%</td><td data-value="1">yes</td></tr>'
    ) in text
    assert "<h1>a &amp; b</h1>" in text
    assert "less &lt; more" in text
    assert '<p class="bad">Not run: x &lt; y.</p>' in text
    assert text.startswith("<!doctype html>")
    assert needs_nothing_else(tmp_path / "index.html")
    assert 'id="plotly"' not in text  # without signals there is nothing to draw


def test_a_value_common_to_all_rows_is_stated_once_above_the_table():
    """A column of numbers stays: it is a result. Links are in the first remaining column."""
    rows = [{"scenario": "dry", "actuation": "ideal", "controller": name, "distance": 12.34} for name in ("SBC", "ABC")]
    sentence, table = ReportTable(rows).parts(["sbc.html", None])
    assert sentence == "Same in all rows: scenario dry; actuation ideal."
    assert table.columns == ["controller", "distance"]
    assert [getattr(row["controller"], "address", None) for row in table.rows] == ["sbc.html", None]
    (single,) = ReportTable(rows[:1]).parts()
    assert single.columns == ["scenario", "actuation", "controller", "distance"]
    assert ReportTable([]).parts() == []


def test_a_cell_links_to_a_page_and_is_text_elsewhere():
    table = ReportTable([{"stop": Link("a & b", "a/index.html")}])
    assert '<td class="text"><a href="a/index.html">a &amp; b</a></td>' in table.__html__()
    assert str(table).endswith("| a & b |")


def test_a_command_is_code_in_html_and_in_markdown():
    table = ReportTable([{"stop": "`railgrip run < a`"}])
    assert "<code>railgrip run &lt; a</code>" in table.__html__()
    assert str(table).endswith("| `railgrip run < a` |")


def test_rows_wider_than_a_page_make_a_table_wide():
    """Long texts wrap, numbers with their intervals do not."""
    interval = "1.23e-05 [9.9e-06, 1.2e-05]"
    assert 'class="data wide"' in ReportTable([{str(column): interval for column in range(6)}]).__html__()
    assert 'class="data"' in ReportTable([{str(column): "1.0" for column in range(12)}]).__html__()
    assert 'class="data"' in ReportTable([{"stop": 10 * interval}]).__html__()


def test_a_table_is_csv_with_its_values(tmp_path):
    TABLE.write_csv(tmp_path / "table.csv")
    with (tmp_path / "table.csv").open(newline="", encoding="utf-8") as file:
        first, _ = csv.DictReader(file)
    assert first == {"stop": "<dry>", "distance": "12.34", "change": "0.1", "kept": "True", "beside": ""}


def test_a_page_of_markdown_escapes_markup(tmp_path):
    results = {"name": "a & b", "description": "It's < 1."}
    page = write_page(
        tmp_path / "page.md", "report/distances.md.jinja", results=results, repeats=None, missing="x", notes=["Note."],
        sections={("ideal", "service", "dry"): [TABLE.without(("beside", "kept"))]},
    )  # fmt: skip
    assert page.read_text(encoding="utf-8") == (
        "# a \\& b\n\nIt's \\< 1.\n\n## Actuation ideal, sensors service, creep curve dry\n\n"
        "| stop | distance | change |\n|---|--:|--:|\n"
        "| \\<dry> | 12.3 m | −10.0 % |\n| wet | none: horizon | +5.0 % |\n\n"
        "Not run: x.\n\nNote.\n"
    )


def test_plotly_has_the_traces_of_signals_and_its_licence():
    report = Path(railgrip.report.__file__).parent
    script = gzip.decompress((report / "plotly/plotly-cartesian.min.js.gz").read_bytes()).decode()
    types = set(re.findall(r'"type": "(\w+)"', (report / "signals.py").read_text(encoding="utf-8")))
    types -= {"log", "line"}  # of axes and shapes
    assert types == {"scatter"}
    assert types <= set(re.findall(r'moduleType:"trace",name:"(\w+)"', script))
    (version,) = re.findall(r"plotly\.js (\S+) with", (report / "page.py").read_text(encoding="utf-8"))
    assert f"plotly.js (cartesian - minified) v{version}\n" in script
    assert (report / "plotly/LICENSE").read_text(encoding="utf-8").startswith("MIT License\n\nCopyright (c)")


VALUES = {
    "in_browser": "",
    "references": "",
    "changes": [],
    "sections": {},
    "repeats": None,
    "tables": [TABLE.drop_empty_columns()],
    "quantiles": None,
    "worst": None,
    "notes": [],
    "missing": "x < y",
    "captions": {},
    "scenarios": "",
}
