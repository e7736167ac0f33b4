"""One table is shown in every way, and a page escapes what is not its own markup."""

import csv
import math

from railgrip.report.page import rendered, write_page
from railgrip.report.table import Table, change, yes_no

TABLE = Table(
    [
        {"stop": "<dry>", "distance": 12.34, "change": 0.1, "kept": True, "beside": None},
        {"stop": "wet", "distance": "none: horizon", "change": -0.05, "kept": False, "beside": math.nan},
    ],
    {"distance": "{:.1f} m", "change": change, "kept": yes_no},
)


def test_a_table_is_markdown():
    assert str(TABLE.filled()) == (
        "| stop | distance | change | kept |\n"
        "|---|--:|--:|--:|\n"
        "| <dry> | 12.3 m | −10.0 % | yes |\n"
        "| wet | none: horizon | +5.0 % | no |"
    )


def test_a_table_is_html_in_a_page_of_html():
    text = rendered("report/campaign.html.jinja", **PAGE)
    assert '<tr><td class="text">&lt;dry&gt;</td><td>12.3 m</td><td>−10.0 %</td><td>yes</td></tr>' in text
    assert "<h1>Campaign a &amp; b</h1>" in text
    assert "<p>less &lt; more</p>" in text
    assert '<p class="bad">locked &gt; 5 s</p>' in text
    assert text.count("<details>") == text.count("</details>") == 1
    assert text.startswith("<!doctype html>")


def test_a_table_is_csv_with_its_values(tmp_path):
    TABLE.write_csv(tmp_path / "table.csv")
    with (tmp_path / "table.csv").open(newline="", encoding="utf-8") as file:
        first, _ = csv.DictReader(file)
    assert first == {"stop": "<dry>", "distance": "12.34", "change": "0.1", "kept": "True", "beside": ""}


def test_a_page_of_markdown_escapes_nothing(tmp_path):
    results = {"name": "a & b", "description": "It's < 1."}
    page = write_page(
        tmp_path / "page.md", "report/distances.md.jinja", results=results, missing="x", notes=["Note."],
        sections={("ideal", "service", "dry"): [TABLE.without(("beside", "kept"))]},
    )  # fmt: skip
    assert page.read_text(encoding="utf-8") == (
        "# a & b\n\nIt's < 1.\n\n## Actuation ideal, sensors service, creep curve dry\n\n"
        "| stop | distance | change |\n|---|--:|--:|\n"
        "| <dry> | 12.3 m | −10.0 % |\n| wet | none: horizon | +5.0 % |\n\n"
        "Not run: x.\n\nNote.\n"
    )


PAGE = {
    "results": {"name": "a & b"},
    "paragraphs": ["less < more"],
    "tables": [TABLE.filled()],
    "notes": [],
    "missing": "",
    "figures": {"Distances": "data:image/png;base64,AAAA"},
    "stops": [
        {
            "name": "s",
            "headline": "12 m",
            "doubts": ["locked > 5 s"],
            "signals": None,
            "metrics": [("d", "1", "m", "x")],
        }
    ],
}
