"""No text of a user becomes markup on a page or in a file of Markdown."""

import shutil
import subprocess
from html.parser import HTMLParser

import pytest
from hypothesis import given
from hypothesis import strategies as st
from markdown_it import MarkdownIt

from railgrip.report.page import Page, rendered
from railgrip.report.page import _html_of as html_of
from railgrip.report.table import Table, plain

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FRAGMENTS = [
    "<script>alert(1)</script>",
    "# forged",
    "\n# forged\n",
    "![x](y)",
    "[a](javascript:b)",
    "<img src=x>",
    "\n\n<b>",
    "`",
    "|",
    "***",
    "\n---\n",
    "\n- a",
    "1. a",
    "1) a",
    "&lt;",
    "<http://a.b>",
    "_a_",
    "\\",
    '"',
    "a",
]
texts = st.one_of(st.text(max_size=40), st.lists(st.sampled_from(FRAGMENTS), max_size=6).map("".join))


class Elements(HTMLParser):
    """The elements of a page, with their attributes."""

    def __init__(self, page):
        super().__init__()
        self.found = []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, [name for name, _ in attrs]))


def elements(page):
    return Elements(page).found


def markdown(text):
    return MarkdownIt("commonmark", {"html": True}).enable("table").render(text)


@given(texts)
def test_a_text_makes_no_element(text):
    assert elements(markdown(f"{plain(text)}\n")) in ([("p", [])], [])
    assert elements(html_of(f"{plain(text)}\n")) in ([("p", [])], [])


@given(texts, texts)
def test_a_cell_of_a_table_makes_no_element_in_markdown_and_in_html(cell, column):
    name, value = f"c{column}", cell.replace("`", "")  # commands in cells are code
    table = Table([{name.replace("`", ""): value}], left=(name,))
    other = Table([{"c": "a"}], left=("c",))
    assert [tag for tag, _ in elements(markdown(str(table)))] == [tag for tag, _ in elements(markdown(str(other)))]
    page = html_of(f"{table.__html__()}\n")
    assert [tag for tag, _ in elements(page)] == ["table", "thead", "tr", "th", "tbody", "tr", "td"]


@given(texts, texts)
def test_name_and_description_make_no_element_in_the_file_of_a_campaign(name, description):
    def page(name, description):
        results = {"name": name, "description": description}
        text = rendered("report/distances.md.jinja", results=results, sections={}, missing=name, notes=[])
        return [tag for tag, _ in elements(markdown(text))]

    assert page(f"a{name}", f"a{description}") == page("a", "a")


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
def test_a_browser_runs_nothing_of_a_hostile_text(tmp_path):
    """The title would be another one if any of the texts were taken as a script or an image."""
    hostile = "<script>document.title='run'</script>\n\n![x](y)<img src=x onerror=\"document.title='run'\">\n\n# forged"
    values = {"references": "", "quantiles": [], "worst": [], "tables": [Table([{"stop": hostile}])], "notes": []}
    page = Page(
        title=hostile, question=hostile, answer=hostile, template="report/campaign.md.jinja",
        values=values | {"missing": hostile, "captions": {}, "scenarios": Table([{"description": hostile}])},
    ).write(tmp_path)  # fmt: skip
    options = ("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", f"--user-data-dir={tmp_path / 'p'}")
    command = [BROWSER, *options, "--virtual-time-budget=3000", "--dump-dom", page.as_uri()]
    shown = subprocess.run(command, check=True, capture_output=True, timeout=60, encoding="utf-8").stdout
    found = elements(shown)
    assert "<title>run</title>" not in shown
    assert "img" not in [tag for tag, _ in found]
    assert [tag for tag, _ in found].count("script") == 1, "only that of the page"
    assert not [attributes for _, attributes in found if "onerror" in attributes]
