"""A comparison lists differences of scenario and result, with units and signs, and their place."""

import json
import math
from dataclasses import replace

import pandas
import pytest
from pages import figures_of, needs_nothing_else
from synthetic_runner import DECELERATION
from synthetic_runner import stop_with as stop

import railgrip as rg
from railgrip.base.errors import RecordError
from railgrip.report.comparison import _change_sentences, compare, flat
from railgrip.report.results import read_results
from railgrip.report.stop import write_stop
from railgrip.scenario.keys import units_of_keys
from railgrip.scenario.outcome import Outcome

SPEED = 80 / 3.6


@pytest.fixture(scope="module")
def slip():
    return stop("controller.kind=slip_two_state")


@pytest.fixture(scope="module")
def adhesion():
    return stop("controller.kind=adhesion_based")


def rows(table, key):
    return {row[key]: row for row in table.rows}


def test_each_differing_key_of_the_scenario_has_its_unit(slip):
    other = stop("controller.kind=slip_two_state", "start.speed=100 km/h", "seed=7")
    question = rows(compare(slip, other).question, "key")
    assert set(question) == {"start.speed", "seed", "scenario digest"}
    assert question["start.speed"] == {"key": "start.speed", "A": "22.2222", "B": "27.7778", "unit": "m/s"}
    assert (question["seed"]["A"], question["seed"]["B"]) == ("2021", "7")


def test_versions_and_parts_belong_to_the_scenario(slip, adhesion, tmp_path):
    other = replace(
        slip, versions={"railgrip": "1"}, fmus={"Plant.fmu": "1" * 64}, classes={"controller": {"class": "Mine"}}
    )
    write_stop(other, tmp_path / "other")
    for changed in (other, tmp_path / "other", tmp_path / "other" / "stop.json"):
        question = rows(compare(slip, changed).question, "key")
        assert set(question) == {"versions.railgrip", "fmus.Plant.fmu", "classes.controller.class"}
        assert question["classes.controller.class"]["A"] == "–"


def test_each_differing_figure_of_the_result_has_unit_and_sign(slip, adhesion):
    comparison = compare(slip, adhesion)
    a, b = DECELERATION["slip_two_state"], DECELERATION["adhesion_based"]
    distance = rows(comparison.answer, "figure")["distance"]
    expected = SPEED**2 / 2 * (1 / b - 1 / a)
    assert distance["B − A"] == pytest.approx(expected, rel=1e-3)
    assert distance["B − A [%]"] == pytest.approx(100 * (a / b - 1), rel=1e-3)
    assert distance["unit"] == "m"
    assert comparison.along["B"].total == pytest.approx(distance["B − A"], abs=1e-9)
    assert sum(row["lost [m]"] for row in comparison.sections["B"].rows) == pytest.approx(distance["B − A"], abs=1e-9)
    assert comparison.sentences[0].startswith("B stops in 259.9")
    assert "longest_lock[1]" not in rows(comparison.answer, "figure"), "equal in both"
    assert "−" in str(comparison.overview)


def test_means_are_of_the_elements_that_all_stops_have(slip, adhesion):
    """The brakes of the first wheelset of B are isolated, and A was read from a plant without adhesion of groups."""
    nan, each = float("nan"), slip.metrics.utilisation_wheelset
    a = replace(slip, metrics=replace(slip.metrics, adhesion_peak=(nan,) * 4, utilisation_wheelset=(*each[:5], 0.1)))
    b = replace(adhesion, metrics=replace(adhesion.metrics, utilisation_wheelset=(nan, *each[1:])))
    overview = rows(compare(a, b).overview, "figure")
    used = overview["utilisation_wheelset, mean of 5 of 6"]
    assert used["A"] == pytest.approx((sum(each[1:5]) + 0.1) / 5)
    assert used["B"] == pytest.approx(sum(each[1:]) / 5)
    assert used["unit"] == ""
    assert "utilisation_wheelset, mean of 6" not in overview
    peak = overview["adhesion_peak, mean of 4"]
    assert math.isnan(peak["A"])
    assert peak["B"] == pytest.approx(sum(adhesion.metrics.adhesion_peak) / 4)


def test_a_stop_without_a_standstill_has_no_difference_of_distances(slip):
    comparison = compare(slip, stop("description=slide"))
    assert "no difference of braking distances, for B ended with horizon" in comparison.sentences[0]
    outcome = rows(comparison.answer, "figure")["outcome"]
    assert (outcome["A"], outcome["B"]) == ("standstill", "horizon")
    assert slip.outcome is Outcome.STANDSTILL


def test_the_same_stop_has_no_differences(slip):
    comparison = compare(slip, slip)
    assert not comparison.question
    assert not comparison.answer
    assert len(comparison.sentences) == 1


def test_without_a_trace_the_place_is_reported_as_unknown(slip, adhesion, tmp_path):
    write_stop(adhesion, tmp_path, keep_trace=False)
    comparison = compare(slip, tmp_path)
    assert not comparison.along
    assert comparison.sentences[-1] == f"Where along the track is not known: no samples were kept of {tmp_path}."
    assert comparison.write(tmp_path / "page").exists()


def test_three_stops_are_compared_with_the_first(slip, adhesion):
    comparison = rg.compare(slip, adhesion, stop("controller.kind=full_brake"))
    assert list(comparison.along) == ["B", "C"]
    assert comparison.along["C"].total > 0 > comparison.along["B"].total
    assert len(repr(comparison).splitlines()) == 3 + len(comparison.sentences)
    assert comparison._repr_html_().count("<table ") == 4


@pytest.mark.parametrize(
    ("results", "sentence"),
    [
        (("nowhere", "elsewhere"), "nowhere: has neither campaign.json nor stop.json; name the folder"),
        ((1, 2), "compare: 1 is neither a stop nor the folder of a result"),
        (("one",), "expects two to 26 results, got 1"),
    ],
)
def test_a_path_without_a_result_is_refused(results, sentence):
    with pytest.raises(RecordError, match=sentence):
        compare(*results)


def test_campaigns_are_compared_stop_by_stop(write_campaign, tmp_path, slip):
    campaign = write_campaign(tmp_path / "a", few)
    faster = write_campaign(tmp_path / "b", few, ["start.speed=100 km/h"])
    comparison = compare(tmp_path / "a", tmp_path / "b")
    distances = rows(comparison.answer, "stop")
    assert list(distances) == [one.name for one in campaign.stops] == [one.name for one in faster.stops]
    for row in distances.values():
        assert row["B − A [%]"] == pytest.approx(100 * ((100 / 80) ** 2 - 1), rel=0.01)
    question = rows(comparison.question, "key")
    assert question["start.speed"]["stops"] == len(distances)
    assert not any(key.startswith("controller") for key in question)
    before, after = ([one.braking_distance for one in read_results(tmp_path / name).stops] for name in "ab")
    metres, changes = comparison.plot().axes
    assert [list(line.get_xdata()) for line in metres.lines] == [before, after]
    assert list(changes.lines[0].get_xdata()) == [b - a for a, b in zip(before, after, strict=True)]
    with pytest.raises(RecordError, match="holds a campaign and another is a stop; name a stop of the campaign"):
        compare(tmp_path / "a", slip)


def test_the_median_change_of_campaigns_is_that_of_all_pairs(slip):
    """Of an even number it is between two of them, and a stop without standstill is endless, not left out."""
    pairs = {name: dict.fromkeys("AB", slip) for name in ("one", "two", "three", "four", "five", "six")}

    def sentence(first, second):
        distances = pandas.DataFrame({"A": first, "B": second}, list(pairs)[: len(first)], dtype=float)
        return _change_sentences(distances, pairs)[0]

    assert "1 longer, 1 shorter, from −10.0 % (one) to +5.0 % (two), median −2.5 %." in sentence([100, 100], [90, 105])
    without = sentence([100, 100, 100, None], [90, None, None, None])
    assert "over 4 stops: 2 longer, 1 shorter, from −10.0 % (one) to endless (two), median endless." in without
    six = sentence([100] * 6, [90, 105, 99, 101, 98, 102])
    assert six.endswith("median +0.0 % [−10.0 %, +5.0 %]; no difference shown.")
    assert sentence([100] * 6, [90, 95, 99, 91, 98, 92]).endswith("median −6.5 % [−10.0 %, −1.0 %].")
    assert sentence([100, None], [None, 100]) == "B against A: no stop came to a standstill in both."


def few(stop):
    return stop.variants["scenario"] == "trapezoid" and stop.variants["equipment"] == "ideal"


def test_the_command_prints_tables_or_json_and_writes_a_page(slip, adhesion, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    write_stop(slip, tmp_path / "runs" / "a")
    write_stop(adhesion, tmp_path / "runs" / "b")
    output = command("compare", "runs/a", "runs/b")
    assert output.code == 0, output.err
    assert "controller.kind" in output.out
    assert "mean_deceleration" in output.out
    page = tmp_path / "build/compare/a-b/index.html"
    assert list(figures_of(page)) == ["comparison"]
    assert needs_nothing_else(page)
    assert "Where B loses distance against A" in page.read_text(encoding="utf-8")
    output = command("compare", "runs/a", "runs/b", "--json")
    content = json.loads(output.out)
    assert output.code == 0
    assert content["results"] == {"A": "runs/a", "B": "runs/b"}
    assert content == json.loads((tmp_path / "build/compare/a-b/comparison.json").read_text(encoding="utf-8"))
    assert {row["figure"]: row["unit"] for row in content["answer"]}["distance"] == "m"
    assert command("compare", "runs/a", "runs/b", "--out", "runs/a").refuses("runs/a: holds a result with its own page")


def test_keys_of_lists_of_tables_are_counted_from_1():
    table = {"a": {"b": 1}, "phases": [{"pressure": 2.0}, {"pressure": "full"}], "none": None, "list": [1, 2]}
    assert flat(table) == {"a.b": 1, "phases[1].pressure": 2.0, "phases[2].pressure": "full", "list": [1, 2]}
    assert units_of_keys()["demand.phases.traction.force"] == "N"
