"""The overview of a campaign: published and simulated distances on one screen."""

import math

import pandas
import pytest

from railgrip.report.campaign_figures import overview_figure
from railgrip.report.distances import overview_of, overview_table
from railgrip.report.frame import frame_of
from railgrip.report.results import read_results

# Schwarz, Posielek and Goetjes (2021), Table 1.
PUBLISHED = {
    "slip_two_state": {"trapezoid": 382.9, "sine sweep": 316.2, "random": 339.6},
    "adhesion_literal": {"trapezoid": 333.4, "sine sweep": 286.6, "random": 309.6},
}


@pytest.fixture(scope="module")
def frame(tmp_path_factory, write_campaign):
    kept = {"slip_two_state", "slip_three_state", "adhesion_literal", "adhesion_based", "ideal_bound"}
    folder = tmp_path_factory.mktemp("overview")
    write_campaign(folder, lambda stop: stop.variants["controller"] in kept)
    return frame_of(read_results(folder))


def at(frame, controller, case):
    return next(
        row
        for row in frame.itertuples()
        if (row.controller, row.scenario.replace("_", " ")) == (controller, case) and row.case == "equipment ideal"
    )


def test_published_distances_precede_those_of_the_same_law(frame):
    overview = overview_of(frame)
    assert list(overview["place"].cat.categories) == ["trapezoid", "sine sweep", "random"]
    lines = overview.drop_duplicates("line")
    assert list(zip(lines["controller"], lines["is_published"], strict=True)) == [
        ("slip_two_state", True),
        ("slip_two_state", False),
        ("adhesion_literal", True),
        ("adhesion_literal", False),
        ("adhesion_based", False),
        ("ideal_bound", False),
    ]
    assert len(overview) == 3 * len(lines)
    for row in overview.itertuples():
        if row.is_published:
            metres = PUBLISHED[row.controller][row.place]
            change = metres / PUBLISHED["slip_two_state"][row.place] - 1
        else:
            metres = at(frame, row.controller, row.place).distance
            change = metres / at(frame, "slip_two_state", row.place).distance - 1
        assert row.distance == metres
        expected = math.nan if row.controller == "slip_two_state" else change
        assert row.change == pytest.approx(expected, nan_ok=True)


def test_a_law_that_depends_on_rounding_has_its_median_range_and_lock(frame):
    changed, place = frame.copy(), at(frame, "adhesion_literal", "trapezoid").Index
    changed.at[place, "repeats"], changed.at[place, "longest_lock"] = (300.0, 280.0, 324.0), 17.25
    texts = [list(row.values()) for row in overview_table(overview_of(changed)).texts]
    place = next(number for number, row in enumerate(texts) if row[0].endswith("simulated") and "ABC" in row[0])
    assert texts[place][1].startswith("300.0 m")
    assert texts[place + 1] == ["– range of repeated stops", "280.0 – 324.0 m", "", ""]
    assert texts[place + 2][:2] == ["– longest lock of a wheelset", "17.2 s"]


def test_a_stop_without_standstill_has_no_distance_and_no_change(frame):
    changed = frame.copy()
    changed.at[at(frame, "adhesion_based", "random").Index, "distance"] = math.nan
    row = next(
        row for row in overview_table(overview_of(changed)).texts if row["braking distance"].startswith("peak seeking")
    )
    assert row["random"] == "no stop"
    overview_figure(overview_of(changed))


def test_a_screen_has_the_table(frame):
    """25 lines of 100 characters: with sentences, a path and other targets below, the table has at most 15."""
    table = overview_table(overview_of(frame))
    widths = [max(len(column), *(len(row[column]) for row in table.texts)) for column in table.columns]
    assert sum(width + 2 for width in widths) <= 100
    assert len(table.rows) <= 15


@pytest.mark.parametrize("change", [{"paper_distance": math.nan}, {"draw": 1}])
def test_a_campaign_without_published_distances_has_no_overview(frame, change):
    assert overview_of(frame.assign(**change)) is None
    assert overview_of(frame.head(0)) is None


def test_a_campaign_on_several_creep_curves_has_no_overview(frame):
    """Its columns would have equal names."""
    assert overview_of(pandas.concat([frame, frame.assign(polach="wet")])) is None
