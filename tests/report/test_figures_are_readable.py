"""No figure has texts that overlap or are cut off, or an empty panel; tests/conftest.py checks those that are saved."""

from functools import cache
from itertools import product
from pathlib import Path
from shutil import copy

import numpy as np
import pytest
from legible import WIDTHS, drawn, needs_browser
from legible import defects_of as defects_in
from pages import replace_signals, signals_of
from readable import defects_of, missing_in

from railgrip.report.campaign_figures import (
    adhesion_figure,
    distance_figure,
    distribution_figure,
    friction_figure,
    overview_figure,
    sweep_figure,
)
from railgrip.report.comparison import compare
from railgrip.report.distances import overview_of
from railgrip.report.distribution import distributions_of, over_cases
from railgrip.report.frame import frame_of
from railgrip.report.index import write_report
from railgrip.report.results import read_results
from railgrip.report.style import panels, save, svg


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
    "overview": lambda stops, folder: overview_figure(overview_of(frame_of(read_results(folder)))),
    "comparison": comparison,
    "comparison of campaigns": lambda stops, folder: compare(folder, folder).plot(),
    "sweep": lambda stops, folder: sweep_figure(
        {"start.speed": [10.0 + k for k in range(60)], "seed": [1, 2]}, np.ones((60, 2))
    ),
}


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_readable(name, drawings):
    assert defects_of(drawings(name)) == []


def labels(frame, column="controller_label"):
    return list(frame[column].unique())


NAMES = {
    "distances": labels,
    "distributions": labels,
    "overview": labels,
    "comparison of campaigns": lambda frame: labels(frame, "stop"),
    "sweep": lambda frame: [f"{10 + number}" for number in range(0, 60, 3)],
}


@pytest.mark.parametrize("name", NAMES)
def test_the_ticks_of_categories_are_the_names_of_the_data(name, drawings, folder):
    panel = drawings(name).axes[0]
    ticks = panel.get_xticklabels() if name == "sweep" else panel.get_yticklabels()
    names = [" ".join(tick.get_text().split()) for tick in ticks]
    assert sorted(names) == sorted(NAMES[name](frame_of(read_results(folder))))


@pytest.fixture(scope="module")
def pages(folder):
    """The page of a campaign, and that of a stop."""
    write_report(folder, panels="abc")
    return {
        "campaign": folder / "index.html",
        "stop": folder / "trapezoid-ideal-adhesion_based" / "index.html",
    }


SCREENS = [*product(("campaign", "stop"), WIDTHS)]


@pytest.fixture(scope="module")
def screens(pages, tmp_path_factory):
    """What a browser draws of the pages, by name and width of the screen; one browser draws them all."""
    found = drawn([(pages[name], width) for name, width in SCREENS], tmp_path_factory.mktemp("screens"))
    return dict(zip(SCREENS, found, strict=True))


@needs_browser
@pytest.mark.parametrize(("name", "width"), SCREENS)
def test_no_text_of_a_page_overlaps_and_no_axis_is_low(name, width, screens):
    found = screens[name, width]
    assert found["plots" if name == "stop" else "figures"]
    assert defects_in(found) == []


@needs_browser
def test_a_browser_finds_texts_that_overlap(pages, tmp_path):
    page = Path(copy(pages["stop"], tmp_path))
    plot = signals_of(page)
    place = {"x": 1, "y": 1, "showarrow": False}
    plot["layout"]["annotations"] = [{**place, "text": text} for text in ("one text", "another one")]
    replace_signals(page, plot)
    (found,) = drawn([(page, 800)], tmp_path / "screen")
    assert "'one text' overlaps 'another one'" in defects_in(found)


def crowd_ticks(axes, name, minor=False):
    axes.set_xticks(np.linspace(0, 1, 30), [f"{name} {k}" for k in range(30)], minor=minor)


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


def place_bars_by_names(axes):
    axes.clear()
    axes.barh(["a", "a"], [1, 2])


@pytest.mark.parametrize(
    ("spoil", "defect"),
    [
        (lambda axes: crowd_ticks(axes, "tick"), "'tick 1' overlaps 'tick 2'"),
        (lambda axes: crowd_ticks(axes, "minor tick", minor=True), "'minor tick 1' overlaps 'minor tick 2'"),
        (cover_title, "'what the panel shows' overlaps the legend of 'a line'"),
        (cover_title_of_figure, "'what the figure shows' overlaps the legend of 'a line'"),
        (empty, "panel 1 is empty"),
        (lambda axes: axes.lines[0].set_ydata([np.nan, np.nan]), "panel 1 is empty"),
        (lambda axes: axes.figure.text(0.9, 0.5, "a text beyond the figure"), "'a text beyond the figure' is cut off"),
        (lambda axes: axes.bar([0, 1], [1, 1]), "bars of panel 1 have no names"),
        (place_bars_by_names, "bars of panel 1 have no names"),
    ],
)
def test_an_unreadable_figure_is_found(spoil, defect, tmp_path):
    drawing, axes = panels(6, 3)
    axes.plot([0, 1], [0, 1], label="a line")
    save(drawing, tmp_path / "good.png")
    spoil(axes)
    found = defects_of(drawing)
    assert defect in found
    with pytest.raises(AssertionError, match="cannot be read"):
        save(drawing, tmp_path / "bad.png")


def test_a_text_that_a_page_lacks_is_found():
    drawing, axes = panels(6, 3)
    axes.barh([0, 1], [1, 2])
    axes.set_yticks([0, 1], ["costs $5 & $6", "two\nlines"])
    page = svg(drawing)
    assert missing_in(page, drawing) == []
    assert missing_in(page.replace(b"costs $5", b"0").replace(b"lines", b"1"), drawing) == ["costs $5 & $6", "lines"]
