"""Pages are printed completely: every column of the widest table, and sections that are folded on the screen."""

import re
from unicodedata import normalize

import numpy as np
import pytest
from legible import browse, needs_browser
from sampling import sample

from railgrip.report.distances import overview_of, overview_table, setting_tables
from railgrip.report.frame import frame_of
from railgrip.report.index import write_report
from railgrip.report.page import Page
from railgrip.report.results import read_results
from railgrip.report.style import panels
from railgrip.report.table import ReportTable
from railgrip.trace.metrics import FIGURES

pytestmark = needs_browser
A4 = {(595, 842), (842, 595)}  # points


@pytest.fixture(scope="module")
def folder(tmp_path_factory, write_campaign):
    directory = tmp_path_factory.mktemp("printed")
    write_campaign(directory, lambda stop: stop.name.startswith("trapezoid-"))
    write_report(directory, panels="abc")
    return directory


def printed(page, folder, convert=None):
    """Return the text of each printed page, without spaces unless converted, and the page sizes in points."""
    from pypdf import PdfReader  # only where there is a browser

    path = folder / "printed.pdf"
    browse(page, folder, "--no-pdf-header-footer", f"--print-to-pdf={path}")
    pages = PdfReader(path).pages
    return [(convert or bare)(one.extract_text()) for one in pages], {
        (round(p.mediabox.width), round(p.mediabox.height)) for p in pages
    }


def bare(text):
    return re.sub(r"\s", "", normalize("NFKC", text))  # printed letters may be joined, as in ﬁ


@pytest.fixture(scope="module")
def paper(folder, tmp_path_factory):
    """The printed page of the campaign."""
    return printed(folder / "index.html", tmp_path_factory.mktemp("paper"))


def test_all_columns_of_a_campaign_are_on_paper(folder, paper):
    texts, sizes = paper
    assert sizes <= {
        (w + dx, h + dy) for w, h in A4 for dx in (-1, 0, 1) for dy in (-1, 0, 1)
    }  # rounded by the browser
    everything = "".join(texts)
    frame = frame_of(read_results(folder))
    overview = overview_of(frame)
    settings = setting_tables(frame, {})
    assert len(settings) == 3
    for name, (sentence, table, *_) in settings.items():
        (first,) = [text for text in texts if bare(f"All stops with {name}") in text]
        assert bare(sentence) in first
        assert [column for column in table.columns if bare(column) not in first] == []
    tables = [overview_table(overview), *(table for _, table, *_ in settings.values())]
    assert max(len(table.columns) for table in tables) >= 14
    assert [
        cell for table in tables for row in table.texts for cell in row.values() if bare(cell) not in everything
    ] == []


def test_the_answer_its_table_and_its_figure_are_on_the_first_page(folder, paper):
    """Panels are next to each other on paper although the window is narrow; no page is half empty."""
    first = paper[0][0]
    overview = overview_of(frame_of(read_results(folder)))
    (rail,) = overview["place"].cat.categories
    cells = [cell for row in overview_table(overview).texts for cell in row.values()]
    labels = [rail, "braking distance [m]", "ideal equipment", *cells]
    assert [label for label in labels if bare(label) not in first] == []


def test_names_are_broken_between_their_words_and_the_last_page_is_not_a_remainder(folder, tmp_path):
    """Columns are as narrow as a name with an underscore permits, and rows fill a page and a line."""
    rows = [{"scenario": "sine_sweep", **{f"column {n}": "1234.5 m" for n in range(14)}} for _ in range(40)]
    page = folder / next(folder.glob("*adhesion_based")).name / "index.html"
    text = page.read_text(encoding="utf-8")
    for count in sample([36, 37, 38, 39, 40], 2):
        moved = tmp_path / "moved.html"
        table = ReportTable(rows[:count], left=("scenario",)).__html__()
        moved.write_text(re.sub(r"(?s)<h2>Scenario</h2>.*(?=<section class=.provenance)", table, text), "utf-8")
        pages, _ = printed(moved, tmp_path, lambda extracted: extracted)
        names = [line for one in pages for line in one.splitlines() if "sine" in line or "sweep" in line]
        assert {re.sub(r"[ \d.m\u00a0]", "", line) for line in names} <= {"sine_sweep", "sine_", "sweep"}
        assert "Provenance" in pages[-1]
        assert "page written" in pages[-1]


def test_sections_folded_on_the_screen_are_printed(folder, tmp_path):
    stop = next(one for one in read_results(folder).stops if one.variants["controller"] == "adhesion_based")
    texts, _ = printed(folder / stop.name / "index.html", tmp_path)
    everything = "".join(texts)
    assert [text for text in ("periods.communication", "limits.alpha_max", stop.digest) if text not in everything] == []
    assert [each.meaning for each in FIGURES.values() if bare(each.meaning) not in everything] == []
    labels = "speed[km/h] slip[%] adhesion padfriction cylinderpressure[bar] timesincethebrakedemand[s]"
    assert [label for label in labels.split() if label not in everything] == []
    assert "wheelset6" in everything


@pytest.mark.parametrize("space", sample([0, 200, 400, 600, 800], 3))
def test_no_heading_is_stranded_at_the_end_of_a_page(folder, tmp_path, space):
    """Whatever precedes it, a heading is followed by its section."""
    page = next(folder.glob("*adhesion_based/index.html"))
    moved = tmp_path / "moved.html"
    gap = f'<div style="height:{space}px"></div>'
    moved.write_text(page.read_text(encoding="utf-8").replace("<h2>Results</h2>", f"{gap}<h2>Results</h2>"))
    texts, _ = printed(moved, tmp_path)
    below = bare("If a figure has several values, the first is that of the leading group or wheelset.")
    assert any(below in text for text in texts)
    assert [text[-80:] for text in texts if text.endswith(("Results", "Provenance", "Scenario", below))] == []


def test_every_kind_of_figure_is_drawn(tmp_path):
    drawing, (image, bars) = panels(8, 4, 1, 2)
    image.imshow([[0.0, 1.0], [0.5, np.nan]])
    image.text(0, 0, "in the image")
    bars.bar([0, 1], [1.0, 2.0], label="bars")
    bars.axhline(1.5)
    bars.plot([], [], label="in the legend alone")
    bars.fill_between([0, 1], [0.0, 0.5], [1.0, 1.5], label="shaded")
    bars.annotate("at a bar", (1, 2.0), xytext=(0, 3), textcoords="offset points")
    bars.set_xticks([0, 1], ["left tick", "right tick"])
    bars.legend()
    drawing.suptitle("above both")
    template = "studies/pad_monitor/pad_monitor.md.jinja"
    page = Page(
        title="t", question="q", answer="a", template=template, values={"table": ""}, figures={"lives.svg": drawing}
    )
    texts, _ = printed(page.write(tmp_path), tmp_path)
    for text in ("in the image", "at a bar", "left tick", "bars", "shaded", "in the legend alone", "above both"):
        assert "".join(texts).count(bare(text)) == 1
