"""The table of distances: rows, reductions and published values."""

import json
from dataclasses import replace
from math import isnan

import pytest
from synthetic_runner import DECELERATION, run_stop

from railgrip.base.errors import RecordError
from railgrip.report.distances import write_table
from railgrip.report.frame import frame_of
from railgrip.report.results import read_results
from railgrip.report.stop import write_stop


def kept(stop):
    return stop.variants["scenario"] == "trapezoid"


def rows_of(folder):
    return list(frame_of(read_results(folder)).itertuples())


def test_reductions_are_relative_to_sbc_in_the_same_conditions(folder):
    rows = {
        (row.actuation, row.controller): row
        for row in frame_of(read_results(folder)).itertuples()
        if "instant" not in row.case
    }
    expected = 1 - DECELERATION["slip_two_state"] / DECELERATION["adhesion_based"]
    for actuation in ("ideal", "pneumatic"):
        # 1e-3: stops end on a sample of 10 ms
        assert rows[actuation, "adhesion_based"].reduction_vs_sbc == pytest.approx(expected, abs=1e-3)
        assert isnan(rows[actuation, "slip_two_state"].reduction_vs_sbc)
    assert rows["ideal", "adhesion_literal"].paper_distance == 333.4
    assert rows["ideal", "adhesion_literal"].paper_reduction == pytest.approx(0.129, abs=5e-4)
    assert isnan(rows["pneumatic", "adhesion_literal"].paper_distance)
    assert isnan(rows["ideal", "adhesion_based"].paper_distance)  # the paper does not have this law


def test_similar_stops_are_distinguished_and_compared_in_their_own_conditions(tmp_path, write_campaign):
    """An axis without a column, the start speed: each ABC has its own SBC, and the table distinguishes them."""
    text = """
name = "speeds"
scenarios = ["{library}/trapezoid.toml"]
sweep = {{ "start.speed" = ["80 km/h", "40 km/h"] }}
[axes.controller]
sbc = {{ controller.kind = "slip_two_state", estimator.kind = "none" }}
abc = {{ controller.kind = "adhesion_based" }}
"""
    write_campaign(tmp_path, text=text)
    rows = rows_of(tmp_path)
    assert len(rows) == 4
    assert {row.label for row in rows} == {"trapezoid, start.speed 80 km/h", "trapezoid, start.speed 40 km/h"}
    by_speed = {row.case: row for row in rows if row.controller == "adhesion_based"}
    expected = 1 - DECELERATION["slip_two_state"] / DECELERATION["adhesion_based"]
    for row in by_speed.values():
        # 4e-3: at 40 km/h a sample of 10 ms is four times the share of the distance that it is at 80 km/h
        assert row.reduction_vs_sbc == pytest.approx(expected, abs=4e-3)


def test_all_creep_curves_of_a_rail_are_named(tmp_path, write_campaign):
    text = """
name = "leaves"
scenarios = ["{library}/plain.toml"]
[axes.rail.leaves]
adhesion.patch = [{{ begin = "20 m", length = "8 m", mu0 = 0.03, polach = "leaf" }}]
adhesion.polach_of_wheelset = ["dry", "dry", "dry", "soap", "dry", "dry"]
"""
    write_campaign(tmp_path, text=text)
    assert [row.polach for row in rows_of(tmp_path)] == ["dry, soap, leaf"]


def test_a_stop_without_standstill_has_no_distance_and_no_reduction(tmp_path, write_campaign):
    write_campaign(
        tmp_path, lambda stop: stop.name in {"trapezoid-ideal-slip_two_state", "trapezoid-ideal-adhesion_based"},
        overrides=["description=slide"],
    )  # fmt: skip
    rows = rows_of(tmp_path)
    assert [isnan(row.distance) for row in rows] == [True, True]
    assert [isnan(row.reduction_vs_sbc) for row in rows] == [True, True]
    assert {row.outcome for row in rows} == {"horizon"}
    assert "none: horizon" in write_table(read_results(tmp_path), tmp_path)[1].read_text(encoding="utf-8")


def test_absent_results_and_those_of_another_scenario_are_missing(tmp_path, write_campaign):
    campaign = write_campaign(
        tmp_path, lambda stop: stop.name in {f"random-ideal-slip_{n}_state" for n in ("two", "three")}
    )
    first, second = (stop.name for stop in campaign.stops)
    (tmp_path / first / "stop.json").unlink()
    write_stop(run_stop(campaign.stops[0].scenario), tmp_path / second)
    results = read_results(tmp_path)
    assert results.stops == ()
    assert set(results.missing) == {first, second}


@pytest.mark.parametrize("content", [None, "{", "[]", '{"name": 1}'])
def test_a_folder_without_a_campaign_is_refused(tmp_path, content):
    if content is not None:
        (tmp_path / "campaign.json").write_text(content, encoding="utf-8")
    with pytest.raises(
        RecordError, match=r"campaign\.json: (there is no such|is not JSON|a table in JSON|is not the descr)"
    ):
        read_results(tmp_path)


def test_fmus_of_another_compiler_are_named_under_the_table(folder, tmp_path):
    results = read_results(folder)
    ours = {"TwoPartTrain.fmu": "railgrip (rumoca 0.9)"}
    theirs = {"TwoPartTrain.fmu": "OpenModelica v1.27.0", "python": "3.11"}

    def named(versions):
        stops = tuple(replace(stop, versions=versions if stop is results.stops[0] else ours) for stop in results.stops)
        as_json, as_markdown = write_table(replace(results, stops=stops), tmp_path)
        return json.loads(as_json.read_text())["fmus"][stops[0].name], as_markdown.read_text()

    assert named(ours)[0] == ours
    assert "was made by" not in named(ours)[1]
    assert named(theirs)[0] == {"TwoPartTrain.fmu": "OpenModelica v1.27.0"}
    sentence = f"TwoPartTrain.fmu was made by OpenModelica v1.27.0 in 1 of {len(results.stops)} stops."
    assert sentence in named(theirs)[1]
    _, as_markdown = write_table(results, tmp_path, ["trapezoid: 1.0 % off."])
    assert "trapezoid: 1.0 % off." in as_markdown.read_text()
