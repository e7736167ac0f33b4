"""Baselines keep distances, say what moved, and move only for a reason."""

from dataclasses import replace

import pytest

from harness.record.outcome import Outcome
from harness.scenario.error import ScenarioError
from harness.verdict.baseline import (
    Accepted,
    Baseline,
    accepted,
    compare,
    comparison_rows,
    load_baseline,
    write_baseline,
)
from harness.verdict.results import read_results

TWO = {"trapezoid-ideal-slip_two_state", "trapezoid-ideal-full_brake"}
SBC, FULL = "trapezoid-ideal-slip_two_state", "trapezoid-ideal-full_brake"


@pytest.fixture(scope="module")
def results(tmp_path_factory, write_campaign):
    directory = tmp_path_factory.mktemp("baseline")
    write_campaign(directory, lambda stop: stop.name in TWO)
    return read_results(directory)


def distance(results, name):
    return next(stop.record.metrics.distance for stop in results.stops if stop.name == name)


def baseline(**distances):
    stops = {
        name.replace("__", "-"): Accepted(distance=value, tolerance=0.5, reason="First.")
        for name, value in distances.items()
    }
    return Baseline(campaign="c.toml", stops=stops)


def states(comparisons):
    return {comparison.stop: comparison.state for comparison in comparisons}


def test_what_moved_appeared_or_went_is_said_first(results):
    before = Baseline(
        campaign="c.toml",
        stops={
            SBC: Accepted(distance=distance(results, SBC) + 0.6, tolerance=0.5, reason="First."),
            "gone": Accepted(distance=100, tolerance=1, reason="First."),
        },
    )
    comparisons = compare(before, results)
    assert states(comparisons) == {SBC: "moved", FULL: "new", "gone": "gone"}
    assert next(c.change for c in comparisons if c.stop == SBC) == pytest.approx(-0.6)
    assert {row["state"] for row in comparison_rows(comparisons)} == {"moved", "new", "gone"}


def test_a_distance_inside_its_tolerance_is_kept(results):
    stops = {
        name: Accepted(distance=distance(results, name) + shift, tolerance=0.5, reason="First.")
        for name, shift in ((SBC, 0.49), (FULL, -0.49))
    }
    assert set(states(compare(Baseline(campaign="c", stops=stops), results)).values()) == {"kept"}


def test_accepting_moves_only_what_moved_and_keeps_the_relative_tolerance(results):
    found = distance(results, SBC)
    kept = Accepted(distance=distance(results, FULL) + 0.1, tolerance=0.5, reason="First.")
    before = Baseline(
        campaign="c", stops={SBC: Accepted(distance=found / 2, tolerance=found / 200, reason="First."), FULL: kept}
    )
    after = accepted(before, results, "Heavier train.")
    assert after.stops[FULL] == kept
    assert after.stops[SBC].distance == pytest.approx(found, abs=1e-3)
    assert after.stops[SBC].tolerance == pytest.approx(found / 100, rel=0.05)  # written with two digits
    assert after.stops[SBC].reason == "Heavier train."


def test_a_new_stop_gets_the_tolerance_of_arithmetic(results):
    after = accepted(Baseline(campaign="c"), results, "New.")
    assert after.stops[SBC].tolerance == pytest.approx(1e-3 * distance(results, SBC), rel=0.05)


@pytest.mark.parametrize("reason", ["", "  "])
def test_nothing_is_accepted_without_a_reason(results, reason):
    with pytest.raises(ScenarioError, match="--reason is empty"):
        accepted(Baseline(campaign="c"), results, reason)


def test_a_stop_that_did_not_stand_cannot_be_accepted(results):
    sliding = replace(
        results, stops=tuple(replace(s, record=replace(s.record, outcome=Outcome.HORIZON)) for s in results.stops)
    )
    assert set(states(compare(Baseline(campaign="c"), sliding)).values()) == {"no standstill"}
    with pytest.raises(ScenarioError, match="did not come to a standstill"):
        accepted(Baseline(campaign="c"), sliding, "Why not.")


def test_a_stop_without_result_is_not_forgotten(results):
    before = Baseline(campaign="c", stops={"x": Accepted(distance=1, tolerance=1, reason="r")})
    with pytest.raises(ScenarioError, match="x has no result; run the campaign first"):
        accepted(before, replace(results, missing=("x",)), "Gone.")
    assert "x" not in accepted(before, results, "No longer planned.").stops


def test_a_baseline_file_says_what_was_written(tmp_path, results):
    after = accepted(Baseline(campaign="../c.toml"), results, 'A "quoted" reason – with a dash.')
    write_baseline(after, tmp_path / "b.toml")
    assert load_baseline(tmp_path / "b.toml") == after


def test_a_wrong_baseline_file_is_refused_with_its_key(tmp_path):
    path = tmp_path / "b.toml"
    path.write_text('campaign = "c.toml"\n[stops.x]\ndistance = 3\ntolerance = 0\n', encoding="utf-8")
    with pytest.raises(ScenarioError) as refusal:
        load_baseline(path)
    assert "b.toml: [stops.x] tolerance must be above 0 m, got 0." in str(refusal.value)
    assert "b.toml: [stops.x] has no 'reason'; it is wanted and has no default" in str(refusal.value)
