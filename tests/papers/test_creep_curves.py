"""Figure 1 of Schwarz, Posielek and Goetjes (2021): creep curves with one maximum and with two."""

import numpy as np
import pytest

from railgrip.studies.papers.creep_curves import RAILS, SLIPS, SPEEDS, causes, figure_1, maxima, rails


@pytest.fixture(scope="module")
def of_causes():
    return causes()


@pytest.fixture(scope="module")
def of_rails():
    return rails()


def test_only_heat_and_cleaning_together_have_two_maxima(of_causes):
    heated, cleaned, both = of_causes
    assert len(heated.maxima) == 1
    (first, _), (second, _) = cleaned.maxima
    assert first < 0.1
    assert second == SLIPS[-1] == 1.0
    (first, _), (second, _) = both.maxima
    assert first < 0.1
    assert 0.2 < second < 0.6


def test_wet_rail_and_leaves_have_two_maxima_and_fall_before_lock(of_rails):
    assert len(of_rails) == len(RAILS) * len(SPEEDS)
    for curve in of_rails:
        (first, low), (second, high) = curve.maxima
        assert first < 0.1 < 0.2 < second < 0.6
        between = curve.adhesion[(first < SLIPS) & (second > SLIPS)]
        # Distinct: a valley of 4 % is visible in the figure, and is a hundred times the noise of the iteration.
        assert between.min() < 0.96 * min(low, high)
        assert curve.adhesion[-1] < 0.75 * high


def test_the_first_maximum_falls_with_speed_and_leaves_have_the_higher_second(of_rails):
    by_label = {curve.label: curve.maxima for curve in of_rails}
    for rail in RAILS:
        firsts = [by_label[f"{rail}, {speed} km/h"][0][0] for speed in SPEEDS]
        assert np.all(np.diff(firsts) < 0)
    for speed in SPEEDS:
        (_, first), (_, second) = by_label[f"leaves, {speed} km/h"]
        assert second > 1.4 * first


def test_maxima_of_a_polynomial_are_at_zeros_of_its_derivative():
    """x (x − 1)² (3 − x): its derivative is (x − 1)(−4 x² + 11 x − 3), and 1 is the minimum."""
    x = np.linspace(0.0, 3.0, 3001)
    places = x[maxima(x * (x - 1) ** 2 * (3 - x))]
    assert places == pytest.approx([(11 - np.sqrt(73)) / 8, (11 + np.sqrt(73)) / 8], abs=2e-3)
    assert x[maxima(x)] == pytest.approx([3.0])


def test_the_figure_marks_every_maximum_and_names_its_axes(of_causes, of_rails):
    panels = figure_1(of_causes, of_rails).axes
    marks = [[line for line in panel.lines if line.get_marker() == "o"] for panel in panels]
    assert [len(each) for each in marks] == [5, 12]
    assert all(panel.get_xlabel().endswith("[%]") for panel in panels)
    assert panels[0].get_ylabel() == "adhesion"
