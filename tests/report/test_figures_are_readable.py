"""No figure has texts that overlap or are cut off, or an empty panel; tests/conftest.py checks those that are saved."""

import numpy as np
import pytest
from readable import defects_of

from railgrip.report.comparison import compare
from railgrip.report.distances import rows_of
from railgrip.report.distribution import distributions_of, over_cases
from railgrip.report.distribution_figure import distribution_figure
from railgrip.report.figures import adhesion_figure, distance_figure, friction_figure, sweep_figure
from railgrip.report.interactive import interactive
from railgrip.report.results import read_results
from railgrip.report.style import panels, save


@pytest.fixture(scope="module")
def folder(tmp_path_factory, write_campaign):
    directory = tmp_path_factory.mktemp("readable")
    kept = {"slip_two_state", "adhesion_based", "slope_seeking"}
    write_campaign(directory, lambda stop: stop.variants["controller"] in kept)
    return directory


@pytest.fixture(scope="module")
def stops(folder):
    return {stop.name: stop for stop in read_results(folder).stops}


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
    "distances": lambda stops, folder: distance_figure(rows_of(read_results(folder))),
    "distributions": lambda stops, folder: distribution_figure(
        distributions_of(over_cases(rows_of(read_results(folder))))
    ),
    "comparison": comparison,
    "comparison of campaigns": lambda stops, folder: compare(folder, folder).plot(),
    "sweep": lambda stops, folder: sweep_figure(
        {"start.speed": [10.0 + k for k in range(60)], "seed": [1, 2]}, np.ones((60, 2))
    ),
}


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_readable(name, stops, folder):
    drawing = FIGURES[name](stops, folder)
    assert defects_of(drawing) == []
    # The version on a page has all panels, too.
    plot = interactive(drawing)
    axes = {trace["xaxis"] for trace in plot["data"] if "xaxis" in trace}
    assert len(axes) == len(drawing.axes)


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
