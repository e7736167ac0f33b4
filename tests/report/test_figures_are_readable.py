"""No figure has labels of ticks that overlap, or a panel with nothing in it."""

from itertools import pairwise

import numpy as np
import pytest

from railgrip.report.comparison import compare
from railgrip.report.distances import rows_of
from railgrip.report.distribution import distributions_of, over_cases
from railgrip.report.distribution_figure import distribution_figure
from railgrip.report.figures import adhesion_figure, distance_figure, friction_figure, stop_figure
from railgrip.report.interactive import interactive
from railgrip.report.results import read_results
from railgrip.report.sweep_figure import sweep_figure


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
    "stop": lambda stops, folder: stop_figure(stops["trapezoid-service-adhesion_based"]),
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


def overlaps(drawing):
    """Return pairs of labels of neighbouring ticks whose boxes cut each other."""
    drawing.draw_without_rendering()
    pairs = []
    for axes in drawing.axes:
        for axis in (axes.xaxis, axes.yaxis):
            labels = [label for label in axis.get_ticklabels() if label.get_visible() and label.get_text()]
            low, high = sorted(axis.get_view_interval())
            places = sorted(zip(axis.get_majorticklocs(), labels, strict=False), key=lambda one: one[0])
            boxes = [(label, label.get_window_extent()) for place, label in places if low <= place <= high]
            pairs += [
                (one.get_text(), other.get_text())
                for (one, a), (other, b) in pairwise(boxes)
                if a.overlaps(b) and a.width and b.width
            ]
    return pairs


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_can_be_read(name, stops, folder):
    drawing = FIGURES[name](stops, folder)
    assert overlaps(drawing) == []
    empty = [axes.get_title(loc="left") or number for number, axes in enumerate(drawing.axes) if not axes.has_data()]
    assert empty == []
    # What a page shows of it has all panels, too.
    plot = interactive(drawing)
    shown = {trace["xaxis"] for trace in plot["data"] if "xaxis" in trace}
    assert len(shown) == len(drawing.axes)
