"""The table that compares published figures with computed ones."""

import math

import pytest

from railgrip.studies.papers.pages import PaperRow, comparison


@pytest.mark.parametrize(
    ("published", "ours", "shown", "difference"),
    [
        (400.0, 410.0, "400.00 m", "+2.5 %"),
        (0.0, -0.01, "0.00 m", "−0.01 m"),
        ((0.02, 0.05), 0.03, "0.02 m to 0.05 m", "within"),
        ((0.02, 0.05), 0.06, "0.02 m to 0.05 m", "0.01 m above"),
        ((0.02, 0.05), 0.01, "0.02 m to 0.05 m", "0.01 m below"),
        ((-math.inf, 0.05), -3.0, "≤ 0.05 m", "within"),
        ((0.05, math.inf), 3.0, "≥ 0.05 m", "within"),
        ("a curve", 3.0, "a curve", ""),
    ],
)
def test_a_difference_is_a_change_or_the_distance_to_a_range(published, ours, shown, difference):
    quantity = PaperRow(figure="Fig. 1", quantity="length", published=published, ours=ours, form="{:.2f} m")
    row = comparison([quantity]).texts[0]
    assert (row["published"], row["difference"]) == (shown, difference)


def test_a_value_chosen_after_the_published_one_has_no_difference():
    chosen, found = (
        PaperRow("Fig. 1", "speed", 120.0, 120.0, is_chosen=is_chosen, form="{:.0f} km/h")
        for is_chosen in (True, False)
    )
    assert [row["difference"] for row in comparison([chosen, found]).texts] == ["*chosen*", "+0.0 %"]
