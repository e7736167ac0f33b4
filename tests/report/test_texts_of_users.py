"""Names and descriptions of users are text in every page: they add no element, attribute, link, image or heading."""

import csv
import re
from functools import partial
from html.parser import HTMLParser

import markdown
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from markdown_it import MarkdownIt
from wrong import table

from railgrip.report.page import Page, render
from railgrip.report.table import Link, ReportTable, as_html, as_markdown

TEXTS = st.text(
    st.sampled_from("<>&\"'`*_[]()!#|~\\-+=.:/ \n\t\r0123456789abcxyz\x00\x85\u2028") | st.characters(codec="utf-8"),
    max_size=60,
)
HOSTILE = table(__file__, "tables.toml")["hostile"]


class Elements(HTMLParser):
    """Elements of a page with their attributes, and its text."""

    def __init__(self, page):
        super().__init__()
        self.elements, self.text = [], ""
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, tuple(sorted(name for name, _ in attributes))))

    def handle_data(self, data):
        self.text += data


def words(text):
    """Return a text as a page displays it: white space and control characters become one space."""
    return " ".join(re.sub(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]", " ", text).split())


def page_of(text, folder):
    table = ReportTable([{"stop": text, "controller": Link(text, text), "distance": 1.0}], title=text)
    page = Page(
        title=text, question=text, answer=text, template="report/campaign.md.jinja",
        values={
            "references": text, "tables": [table, text], "quantiles": [table], "worst": [text], "notes": [text],
            "in_browser": "", "missing": text, "captions": {}, "scenarios": text, "changes": [text],
            "sections": {text: [table, text]}, "repeats": table,
        },
        overview=table, note=text,
        provenance={"scenario": text},
    )  # fmt: skip
    return page.write(folder).read_text(encoding="utf-8")


def with_hostile(test):
    for text in HOSTILE:
        test = example(text)(test)
    return test


@with_hostile
@given(TEXTS)
def test_a_page_has_the_same_elements_whatever_its_texts(tmp_path_factory, text):
    plain, page = (Elements(page_of(words_, tmp_path_factory.mktemp("page"))) for words_ in ("x", text))
    if words(text):
        # A command between backticks in a cell of a table is code, and a name may break at an underscore.
        assert [one for one in page.elements if one[0] not in ("code", "wbr")] == plain.elements
        assert words(text) in words(page.text)


@with_hostile
@given(TEXTS)
def test_a_text_in_markdown_is_a_paragraph_of_text(text):
    html = MarkdownIt("gfm-like", {"linkify": False}).render(as_markdown(text))
    found = Elements(html)
    assert [tag for tag, _ in found.elements] == (["p"] if words(text) else [])
    assert words(found.text) == words(text)


@with_hostile
@given(TEXTS)
def test_a_table_of_a_markdown_file_keeps_its_columns(text):
    table = ReportTable([{"stop": text, "distance": 1.0}, {"stop": "b", "distance": 2.0}])
    page = render(
        "report/distances.md.jinja", missing="", notes=[text], repeats=None,
        results={"name": "a", "description": text}, sections={("ideal", "ideal", "dry"): [table]},
    )  # fmt: skip
    found = Elements(MarkdownIt("gfm-like", {"linkify": False}).render(page))
    tags = [tag for tag, _ in found.elements if tag not in ("p", "em", "strong")]
    assert tags == ["h1", "h2", "table", "thead", "tr", "th", "th", "tbody", "tr", "td", "td", "tr", "td", "td"]


@pytest.mark.parametrize("text", HOSTILE)
def test_an_escaped_text_is_one_line(text):
    assert "\n" not in as_html(text)
    assert "\n" not in as_markdown(text)


BARS = st.text(st.sampled_from("ab|\\ \n\r`*"), max_size=12)


@example("a|b", "|")
@example("a\\|b", "\\\\|")
@example("`a|b`", "|x|")
@given(BARS, BARS.filter(lambda text: text.strip()))
def test_no_rendering_of_a_table_loses_a_cell_to_a_bar_or_a_line_break(tmp_path_factory, cell, heading):
    """GFM (4.10) and Python-Markdown, which docs use, split at bars that no backslash escapes; also within code."""
    table = ReportTable([{"stop": cell, f"{heading}1": "x", "c": cell}, {"stop": "p", f"{heading}1": "q", "c": "r"}])
    readers = (MarkdownIt("gfm-like", {"linkify": False}).render, partial(markdown.markdown, extensions=["tables"]))
    for read in (*readers, lambda _: table.__html__()):
        tags = [tag for tag, _ in Elements(read(str(table))).elements if tag in ("table", "tr", "th", "td", "p")]
        assert tags == ["table", "tr", "th", "th", "th", "tr", "td", "td", "td", "tr", "td", "td", "td"]
    if not set(cell) & set("\\`*"):
        for read in (*readers, lambda _: table.__html__()):
            assert words(re.findall(r"<td[^>]*>(.*?)</td>", read(str(table)), re.DOTALL)[0].replace("&#124;", "|")) == (
                words(cell)
            )
    path = tmp_path_factory.mktemp("table") / "a.csv"
    table.write_csv(path)
    with path.open(newline="", encoding="utf-8") as file:
        assert list(csv.DictReader(file)) == [dict(row) for row in table.rows]
