"""A table states common values once, and its cells may be links or commands; test_texts_of_users.py tests all texts."""

from railgrip.report.table import Link, ReportTable


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
