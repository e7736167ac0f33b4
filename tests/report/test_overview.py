"""The overview of a campaign: published and simulated distances on one screen."""

import math

import pandas
import pytest

from railgrip.report.campaign_figures import overview_figure
from railgrip.report.distances import caveats_of, headline, meaning_of, overview_of, overview_table
from railgrip.report.frame import StatedDistance, frame_of
from railgrip.report.results import read_results

# Schwarz, Posielek and Goetjes (2021), Table 1.
PUBLISHED = {
    "slip_two_state": {"trapezoid": 382.9, "sine sweep": 316.2, "random": 339.6},
    "adhesion_literal": {"trapezoid": 333.4, "sine sweep": 286.6, "random": 309.6},
}


KEPT = {"slip_two_state", "slip_three_state_read", "adhesion_literal", "adhesion_based", "ideal_bound"}


def kept(stop):
    return stop.variants["controller"] in KEPT


@pytest.fixture(scope="module")
def frame(folder):
    return frame_of(read_results(folder))


def at(frame, controller, case, equipment="ideal"):
    named = {"controller": controller, "scenario": case.replace(" ", "_"), "case": f"equipment {equipment}"}
    return next(frame[(frame[[*named]] == [*named.values()]).all(axis=1)].itertuples())


def test_published_distances_precede_those_of_the_same_law(frame):
    overview = overview_of(frame)
    assert list(overview["place"].cat.categories) == ["trapezoid", "sine sweep", "random"]
    lines = overview.drop_duplicates(["controller", "origin"])
    assert list(zip(lines["controller"], lines["origin"], strict=True)) == [
        *(("slip_two_state", origin) for origin in ("published", "ideal", "service")),
        *(("slip_three_state_read", origin) for origin in ("ideal", "service")),
        *(("adhesion_literal", origin) for origin in ("published", "ideal", "service")),
        *(("adhesion_based", origin) for origin in ("ideal", "service")),
        ("ideal_bound", "ideal"),
    ]
    assert len(overview) == 3 * len(lines)
    for row in overview.itertuples():
        if row.origin == "published":
            metres = PUBLISHED[row.controller][row.place]
            change = metres / PUBLISHED["slip_two_state"][row.place] - 1
        else:
            metres = at(frame, row.controller, row.place, row.origin).distance
            change = metres / at(frame, "slip_two_state", row.place, row.origin).distance - 1
        assert row.distance == metres
        expected = math.nan if row.controller == "slip_two_state" else change
        assert row.change == pytest.approx(expected, nan_ok=True)


def test_distance_range_and_lock_of_a_line_are_of_the_same_runs(frame):
    """The lock of the single run, 17.25 s, is not that of the repeats."""
    changed, place = frame.copy(), at(frame, "adhesion_literal", "trapezoid").Index
    changed.at[place, "stated"] = StatedDistance((280.0, 300.0, 324.0), 12.3)
    changed.at[place, "longest_lock"] = 17.25
    texts = [list(row.values()) for row in overview_table(overview_of(changed)).texts]
    place = next(number for number, row in enumerate(texts) if "ABC (paper), published" in row[0])
    assert texts[place + 1][1].startswith("300.0 m")
    assert texts[place + 2] == ["– – range [m], longest lock", "280.0–324.0, 12 s", "", ""]


def test_a_stop_without_standstill_has_no_distance_and_no_change(frame):
    changed = frame.copy()
    changed.at[at(frame, "adhesion_based", "random").Index, "stated"] = StatedDistance((math.inf,))
    changed.at[at(frame, "adhesion_based", "random").Index, "stated_vs_sbc"] = math.inf
    row = next(
        row for row in overview_table(overview_of(changed)).texts if row["braking distance"].startswith("peak seeking")
    )
    assert row["random"] == "no stop"
    overview_figure(overview_of(changed))


def test_stops_with_lots_of_sensors_are_stated_as_medians_and_compared_lot_by_lot():
    """Of three lots the middle one is 10 % shorter than the same lot of the other; medians would differ by 5 %."""
    own, other = StatedDistance((90.0, 95.0, 120.0), are_lots=True), StatedDistance((100.0, 80.0, 133.0), are_lots=True)
    assert own.median == 95.0
    assert own.ends == (90.0, 120.0)
    assert own.change_against(other) == pytest.approx(120 / 133 - 1)
    assert StatedDistance((95.0,)).change_against(other) == pytest.approx(-0.05)


def test_a_reader_learns_what_was_fitted_tuned_and_published(frame):
    overview = overview_of(frame)
    sentences = caveats_of(overview, ["A. Author (2021), Table 1"])
    assert sentences[0] == "Published distances: A. Author (2021), Table 1."
    assert "friction of these scenarios was fitted" in sentences[1]
    assert len(sentences) == 2
    without = overview[overview["reference"] != "best tuned"].assign(fitted=False)
    assert caveats_of(without, []) == [
        "No SBC with tuned thresholds was run: what a law gains over one is not known here."
    ]
    assert meaning_of(overview).startswith("SBC: slip-based control; ABC: adhesion-based control.")


def test_the_headline_is_of_each_equipment_and_of_common_stops(frame):
    """Without two of its three stops, on which it is shorter than any other law, peak seeking is compared on one."""
    named = frame.assign(breaks=[[]] * len(frame))
    text = headline(named)
    assert text.startswith(
        "Against slip-based control (SBC) with the published, untuned thresholds of 10 and 15 %, with"
    )
    assert text.count("in the median of 3 stops") == 2
    lacking = named[(named["controller"] != "adhesion_based") | (named["scenario"] == "random")]
    assert headline(lacking).count(" in one stop") == 2
    assert "stops that not all of them have are not compared." in headline(lacking)


@pytest.mark.parametrize("change", [{"paper_distance": math.nan}, {"draw": 1}])
def test_a_campaign_without_published_distances_has_no_overview(frame, change):
    assert overview_of(frame.assign(**change)) is None
    assert overview_of(frame.head(0)) is None


def test_a_campaign_on_several_creep_curves_has_no_overview(frame):
    """Its columns would have equal names."""
    assert overview_of(pandas.concat([frame, frame.assign(polach="wet")])) is None
