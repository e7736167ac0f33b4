"""Figure 1 of Schwarz, Posielek and Goetjes (2021): creep curves with one maximum and with two."""

import numpy as np
import pytest

from railgrip.studies.papers.creep_curves import SLIPS, figure_1, figure_1_curves, maxima


@pytest.fixture(scope="module")
def curves():
    return figure_1_curves()


def test_a_rail_as_it_lies_has_one_maximum_and_one_that_slip_cleans_two(curves):
    *as_they_lie, cleaned = curves
    for curve in as_they_lie:
        slope = np.sign(np.diff(curve.adhesion))
        assert np.flatnonzero(np.diff(slope)).size == 1
        assert len(curve.maxima) == 1
    signs = np.sign(np.diff(cleaned.adhesion))
    assert signs[np.append(0, np.flatnonzero(np.diff(signs)) + 1)].tolist() == [1, -1, 1]
    (first, _), (second, _) = cleaned.maxima
    assert first < 0.1
    assert second == SLIPS[-1] == 1.0


def test_maxima_of_a_polynomial_are_where_its_derivative_is_zero():
    """x (x − 1)² (3 − x): its derivative is (x − 1)(−4 x² + 11 x − 3), and 1 is the minimum."""
    x = np.linspace(0.0, 3.0, 3001)
    places = x[maxima(x * (x - 1) ** 2 * (3 - x))]
    assert places == pytest.approx([(11 - np.sqrt(73)) / 8, (11 + np.sqrt(73)) / 8], abs=2e-3)
    assert x[maxima(x)] == pytest.approx([3.0])


def test_the_figure_marks_every_maximum_and_names_its_axes(curves):
    (panel,) = figure_1(curves).axes
    marks = [line for line in panel.lines if line.get_marker() == "o"]
    assert len(marks) == 4
    assert panel.get_xlabel().endswith("[%]")
    assert panel.get_ylabel() == "adhesion"
