"""No figure has texts that overlap or are cut off, or an empty panel; tests/conftest.py checks those that are saved."""

import html
import re
from functools import cache
from itertools import product

import numpy as np
import pytest
from legible import LOWEST, WIDTHS, defects_on_screen, drawn, needs_browser
from legible import defects_of as defects_in
from matplotlib.text import Text
from pages import plots_of, replace_plots
from readable import defects_of
from sampling import sample

from railgrip.report.campaign_figures import (
    adhesion_figure,
    distance_figure,
    distribution_figure,
    friction_figure,
    sweep_figure,
)
from railgrip.report.comparison import compare
from railgrip.report.distribution import distributions_of, over_cases
from railgrip.report.frame import frame_of
from railgrip.report.index import write_report
from railgrip.report.interactive import interactive
from railgrip.report.page import Page
from railgrip.report.results import read_results
from railgrip.report.style import panels, save


def kept(stop):
    return stop.variants["controller"] in ("slip_two_state", "adhesion_based") and "sine_sweep-service" not in stop.name


@pytest.fixture(scope="module")
def drawings(stops, folder):
    """Return a function that draws a kind of figure once."""
    return cache(lambda name: FIGURES[name](stops, folder))


def comparison(stops, folder):
    names = ("slip_two_state", "adhesion_based")
    return compare(*(folder / f"trapezoid-ideal-{name}" for name in names)).plot()


FIGURES = {
    "stop": lambda stops, folder: stops["trapezoid-service-adhesion_based"].plot(),
    "friction": lambda stops, folder: friction_figure(
        [stops[f"{rail}-ideal-slip_two_state"] for rail in ("trapezoid", "sine_sweep", "random")]
    ),
    "adhesion": lambda stops, folder: adhesion_figure(
        stops["random-ideal-slip_two_state"], stops["random-ideal-adhesion_based"]
    ),
    "distances": lambda stops, folder: distance_figure(frame_of(read_results(folder))),
    "distributions": lambda stops, folder: distribution_figure(
        distributions_of(over_cases(frame_of(read_results(folder))))
    ),
    "comparison": comparison,
    "comparison of campaigns": lambda stops, folder: compare(folder, folder).plot(),
    "sweep": lambda stops, folder: sweep_figure(
        {"start.speed": [10.0 + k for k in range(60)], "seed": [1, 2]}, np.ones((60, 2))
    ),
}


def texts_in(plot):
    """Return all texts of a figure on a page as they are shown."""
    if isinstance(plot, dict | list):
        return {text for part in (plot.values() if isinstance(plot, dict) else plot) for text in texts_in(part)}
    return {html.unescape(plot.replace("<br>", "\n"))} if isinstance(plot, str) else set()


def words_of(drawing):
    """Return what is written in a drawing, without numbers, which plotly.js places itself."""
    hidden = {
        text
        for panel in drawing.axes
        for axis in (panel.xaxis, panel.yaxis)
        if not (panel.axison and axis.get_visible())
        for text in axis.findobj(Text)
    }
    texts = [text for text in drawing.findobj(Text) if text.get_visible() and text not in hidden]
    return {text.get_text() for text in texts if re.search("[a-zA-Z]", text.get_text()) and not text.get_parse_math()}


def test_bars_have_their_names_on_a_page():
    drawing, (upper, lower) = panels(6, 4, 2, 1)
    upper.barh(["sand", "$5 < 6"], [1.0, 2.0])
    lower.bar(["new brake"], [1.0])
    plot = interactive(drawing)
    assert words_of(drawing) == {"sand", "new brake"}
    assert {"sand", "$5 < 6", "new brake"} <= texts_in(plot)
    assert plot["layout"]["yaxis"]["tickvals"] == [0.0, 1.0]


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_readable(name, drawings):
    drawing = drawings(name)
    assert defects_of(drawing) == []
    # The version on a page has all panels, too.
    plot = interactive(drawing)
    axes = {trace["xaxis"] for trace in plot["data"] if "xaxis" in trace}
    assert len(axes) == len(drawing.axes)
    assert words_of(drawing) <= texts_in(plot)


def page_of(figures, folder):
    """Return a page with figures alone."""
    page = Page(
        title="figures",
        question="",
        answer="",
        template="report/campaign.md.jinja",
        values=dict.fromkeys(("references", "missing", "scenarios"), "")
        | dict.fromkeys(("changes", "quantiles", "worst", "tables", "notes"), ())
        | {"sections": {}, "repeats": None, "captions": dict.fromkeys(list(figures)[1:], "")},
        figures=figures,
    )
    return page.write(folder)


@pytest.fixture(scope="module")
def pages(folder, drawings, tmp_path_factory):
    """A page of all kinds of figures, that of a campaign, and that of a stop."""
    write_report(folder, panels="abc")
    of_kinds = tmp_path_factory.mktemp("kinds")
    kinds = {f"figures/{name.replace(' ', '-')}.png": drawings(name) for name in FIGURES}
    return {
        "figures": page_of(kinds, of_kinds),
        "campaign": folder / "index.html",
        "stop": folder / "trapezoid-ideal-adhesion_based" / "index.html",
    }


SCREENS = sample([*product(("figures", "campaign", "stop"), WIDTHS)], 5)


@pytest.fixture(scope="module")
def screens(pages, tmp_path_factory):
    """What a browser draws of the pages, by name, width and height of the screen; one browser draws them all."""
    sizes = [*((name, width, 900) for name, width in SCREENS), ("campaign", 1280, 800)]
    found = drawn([(pages[name], width, height) for name, width, height in sizes], tmp_path_factory.mktemp("screens"))
    return dict(zip(sizes, found, strict=True))


@needs_browser
@pytest.mark.parametrize(("name", "width"), SCREENS)
def test_no_text_of_a_page_overlaps_and_no_axis_is_low(name, width, screens):
    assert screens[name, width, 900]["plots"]
    assert defects_in(screens[name, width, 900]) == []


@needs_browser
def test_the_answer_of_a_campaign_is_on_the_first_screen(screens):
    """On a screen of 1280 by 800 pixels: the overview with all of its columns, and the figure."""
    found = screens["campaign", 1280, 800]
    first = found["plots"][0]
    assert first["name"] == "figures/overview.png"
    assert first["frame"]["bottom"] <= 800
    assert found["page"] <= 1280


def test_every_panel_of_a_figure_is_high_enough_without_a_browser(pages):
    for plot in plots_of(pages["figures"]).values():
        layout = plot["layout"]
        inner = layout["height"] - layout["margin"]["t"] - layout["margin"]["b"]
        domains = [axis["domain"] for key, axis in layout.items() if key.startswith("yaxis")]
        assert min(high - low for low, high in domains) * inner >= LOWEST


def low(axes):
    axes.set_position([0.1, 0.1, 0.8, 0.1])


def legend_over_lines(axes):
    axes.legend(loc="center", bbox_to_anchor=(0.5, 0.5))


def many_names_above(axes):
    for number in range(8):
        axes.plot([0, 1], [number, 1], label=f"line {number}")
    axes.figure.legend(loc="outside upper left", ncols=3)


@needs_browser
def test_a_page_mends_what_it_draws_larger_than_a_figure(tmp_path):
    """Legends of plotly.js are larger than those of matplotlib, and panels must not be low."""
    pages = []
    for spoil in (low, legend_over_lines, many_names_above):
        drawing, axes = panels(6, 3)
        axes.plot([0, 1], [0, 1], label="a line")
        spoil(axes)
        pages.append(page_of({"figures/one.png": drawing}, tmp_path / spoil.__name__))
    assert defects_on_screen(pages, tmp_path / "screen", 800) == [[], [], []]


@needs_browser
def test_a_browser_finds_texts_that_overlap(tmp_path):
    drawing, axes = panels(6, 3)
    axes.plot([0, 1], [0, 1])
    axes.text(0.5, 0.5, "one text")
    page = page_of({"figures/one.png": drawing}, tmp_path)
    packed = plots_of(page)
    note = next(note for note in packed["figures/one.png"]["layout"]["annotations"] if note["text"] == "one text")
    moved = {**note, "text": "another one"}
    packed["figures/one.png"]["layout"]["annotations"].append(moved)
    replace_plots(page, packed)
    assert (
        "figures/one.png: 'one text' overlaps 'another one'" in defects_on_screen([page], tmp_path / "screen", 800)[0]
    )


def crowd_ticks(axes):
    axes.set_xticks(np.linspace(0, 1, 30), [f"tick number {k}" for k in range(30)])


def crowd_minor_ticks(axes):
    axes.set_xticks(np.linspace(0, 1, 30), [f"minor tick {k}" for k in range(30)], minor=True)


def cover_title(axes):
    axes.set_title("what the panel shows", loc="left")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 0.95))


def cover_title_of_figure(axes):
    axes.figure.suptitle("what the figure shows")
    axes.figure.legend(loc="upper center")


def empty(axes):
    axes.lines[0].remove()
    axes.axhline(0.5)
    axes.axvspan(0.2, 0.4)


def fill_with_nan(axes):
    axes.lines[0].set_ydata([np.nan, np.nan])


def cut_off(axes):
    axes.figure.text(0.9, 0.5, "a sentence that goes beyond the figure")


DEFECTS = {
    crowd_ticks: "'tick number 1' overlaps 'tick number 2'",
    crowd_minor_ticks: "'minor tick 1' overlaps 'minor tick 2'",
    cover_title: "'what the panel shows' overlaps the legend of 'a line'",
    cover_title_of_figure: "'what the figure shows' overlaps the legend of 'a line'",
    empty: "panel 1 is empty",
    fill_with_nan: "panel 1 is empty",
    cut_off: "'a sentence that goes beyond the figure' is cut off",
}


@pytest.mark.parametrize("spoil", DEFECTS)
def test_an_unreadable_figure_is_found(spoil, tmp_path):
    drawing, axes = panels(6, 3)
    axes.plot([0, 1], [0, 1], label="a line")
    save(drawing, tmp_path / "good.png")
    spoil(axes)
    found = defects_of(drawing)
    assert DEFECTS[spoil] in found
    with pytest.raises(AssertionError, match="cannot be read"):
        save(drawing, tmp_path / "bad.png")
