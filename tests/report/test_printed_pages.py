"""Pages are printed completely: every column of the widest table, and sections that are folded on the screen."""

import re
from unicodedata import normalize

import pytest
from legible import browse, needs_browser

from railgrip.report.distances import overview_of, overview_table, setting_tables
from railgrip.report.frame import frame_of
from railgrip.report.index import write_report
from railgrip.report.results import read_results
from railgrip.trace.metrics import FIGURES

pytestmark = needs_browser
A4 = {(595, 842), (842, 595)}  # points


@pytest.fixture(scope="module")
def folder(tmp_path_factory, write_campaign):
    directory = tmp_path_factory.mktemp("printed")
    write_campaign(directory, lambda stop: stop.name.startswith("trapezoid-"))
    write_report(directory, panels="abc")
    return directory


def printed(page, folder):
    """Return the text of each printed page, without spaces, and the page sizes in points."""
    from pypdf import PdfReader  # only where there is a browser

    path = folder / "printed.pdf"
    browse(page, folder, "--no-pdf-header-footer", f"--print-to-pdf={path}")
    pages = PdfReader(path).pages
    sizes = {(round(p.mediabox.width), round(p.mediabox.height)) for p in pages}
    return [bare(one.extract_text()) for one in pages], sizes


def bare(text):
    return re.sub(r"\s", "", normalize("NFKC", text))  # printed letters may be joined, as in ﬁ


def test_all_columns_of_a_campaign_are_on_paper(folder, tmp_path):
    texts, sizes = printed(folder / "index.html", tmp_path)
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


def test_sections_folded_on_the_screen_are_printed(folder, tmp_path):
    stop = next(one for one in read_results(folder).stops if one.variants["controller"] == "adhesion_based")
    texts, _ = printed(folder / stop.name / "index.html", tmp_path)
    everything = "".join(texts)
    assert [text for text in ("periods.communication", "limits.alpha_max", stop.digest) if text not in everything] == []
    assert [each.meaning for each in FIGURES.values() if bare(each.meaning) not in everything] == []
    labels = "speed[km/h] slip[%] adhesion padfriction cylinderpressure[bar] timesincethebrakedemand[s]"
    assert [label for label in labels.split() if label not in everything] == []
    assert "wheelset6" in everything
