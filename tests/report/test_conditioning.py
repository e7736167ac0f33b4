"""A distance that depends on rounding is printed, accepted and compared as a range."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conditioning import campaign_of, conditioning_of, merged, repeats_of, with_refinement
from project_files import BASELINES
from synthetic import stop_of
from validation import medians_table, tolerances_table
from written_campaigns import CAMPAIGNS

from railgrip.base.errors import ScenarioError
from railgrip.campaign.run import write_description
from railgrip.report.baseline import (
    AcceptedValue,
    Baseline,
    Finding,
    Findings,
    accept,
    compare,
    load_baseline,
    write_baseline,
)
from railgrip.report.frame import STALE, frame_of, range_text
from railgrip.report.results import read_results
from railgrip.report.stop import write_stop
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.conditioning import ConditioningFile, RepeatedDistances, read_conditioning, text_of

CHAOTIC = RepeatedDistances(digest="d", distances=(280.0, 300.0, 324.0, None))
FIRM = RepeatedDistances(digest="d", distances=(280.0, 280.001, 280.002))


def test_repeats_without_standstill_are_infinite():
    assert (CHAOTIC.lowest, CHAOTIC.median, CHAOTIC.highest) == (280, 312, float("inf"))
    assert CHAOTIC.spreads
    assert not FIRM.spreads


@pytest.mark.parametrize(
    ("digest", "distance", "text"),
    [
        ("d", 280.001, "280.0 m (280.0 – 280.0)"),
        ("e", 280.001, STALE),  # another scenario
        ("d", 281.0, STALE),  # another controller: the digest does not include it, the distance differs
        ("d", None, STALE),
    ],
)
def test_repeats_of_another_stop_are_called_stale(digest, distance, text):
    assert range_text(FIRM, digest, distance) == text
    assert range_text(None, digest, distance) == ""


def test_a_range_is_printed_as_long_as_the_distance_is_in_it():
    repeats = RepeatedDistances(digest="d", distances=(280.0, 300.0, 324.0), compilers={"openmodelica": (290.0,)})
    assert range_text(repeats, "d", 330.0) == "300.0 m (280.0 – 324.0)"
    assert range_text(repeats, "d", 336.0) == STALE  # beyond a quarter of the range


def test_the_stops_of_a_campaign_are_repeated_and_printed_next_to_their_distances(tmp_path, write_campaign):
    campaign = write_campaign(tmp_path, lambda stop: stop.name == "trapezoid-ideal-adhesion_based")
    (stop,) = campaign.stops
    repeats = {stop.name: repeats_of(stop, count=3, lots=4, relative=1e-7)}
    again = campaign_of(campaign, repeats)
    nudges = [one.scenario.vehicle.nudge for one in repeats[stop.name][0]]
    assert repeats[stop.name][1] == []  # ideal sensors have no errors
    assert [(nudge.seed, nudge.relative) for nudge in nudges] == [(1, 1e-7), (2, 1e-7), (3, 1e-7)]
    assert not any(one.keep_trace for one in again.stops)
    for number, one in enumerate(again.stops):
        write_stop(stop_of(one.scenario, 0.95 + 0.01 * (number - 1)), tmp_path / "again" / one.name, keep_trace=False)
    conditioning = conditioning_of(campaign, repeats, tmp_path / "again", 1e-7)
    assert conditioning.stops[stop.name].spreads
    path = tmp_path / "conditioning.json"
    path.write_text(text_of(conditioning), encoding="utf-8")
    assert read_conditioning(path) == conditioning
    write_description(replace(campaign, conditioning=path), tmp_path)
    (repeated,) = frame_of(read_results(tmp_path))["repeated"]
    assert repeated.startswith(f"{conditioning.stops[stop.name].median:.1f} m (")


def test_a_stop_with_erroneous_sensors_is_repeated_with_other_lots_on_the_same_rail(tmp_path, write_campaign):
    campaign = write_campaign(tmp_path, lambda stop: stop.name == "trapezoid-service-slope_seeking")
    (stop,) = campaign.stops
    repeats = perturbed, lots = repeats_of(stop, count=1, lots=2, relative=1e-7)
    assert [lot.scenario.sensors.seed for lot in lots] == [1, 2]
    assert [lot.scenario.seed for lot in lots] == [stop.scenario.seed] * 2
    assert len({one.name for one in (*perturbed, *lots)}) == 3
    for number, one in enumerate((*perturbed, *lots)):
        write_stop(stop_of(one.scenario, 0.95 + 0.01 * number), tmp_path / one.name, keep_trace=False)
    first, second = conditioning_of(campaign, {stop.name: repeats}, tmp_path, 1e-7).stops[stop.name].lots
    assert first != second


def test_the_effect_of_a_divided_step_is_compared_with_that_of_rounding():
    """Compared with draws: 95 % of medians of 5 and of 20 normal draws differ by less than the stated noise."""
    draws = np.random.default_rng(1).normal(300.0, 1.0, (2000, 25))
    repeats = [
        RepeatedDistances(digest="d", distances=tuple(sorted(row[:20])), steps={2: tuple(row[20:])})
        for row in draws.tolist()
    ]
    within = [abs(each.moved_by_step(2)) < each.noise_of_step(2) for each in repeats]
    assert np.mean(within) == pytest.approx(0.95, abs=0.02)
    moved = RepeatedDistances(digest="d", distances=(299.0, 300.0, 301.0), steps={2: (303.0,), 4: (None,)})
    assert moved.moved_by_step(2) == pytest.approx(0.01)
    assert moved.moved_by_step(4) == np.inf


def test_new_repeats_keep_the_distances_at_divided_steps_of_the_same_stop():
    """The tolerance is that of a smooth distance, 0.02 m."""
    kept = {"steps": {2: (280.1,), 4: (280.2,)}, "compilers": {"openmodelica": (280.0, 280.4)}}
    before = {"one": FIRM.model_copy(update=kept)}
    again = FIRM.model_copy(update={"distances": (280.0, 280.011, 280.02)})
    assert merged({"one": again, "two": FIRM}, before, "native") == {
        "one": again.model_copy(update=kept), "two": FIRM,
    }  # fmt: skip
    for other in (again.model_copy(update={"digest": "e"}), FIRM.model_copy(update={"distances": (281.0,)})):
        assert merged({"one": other}, before, "native") == {"one": other}


def test_distances_of_another_compiler_are_added_to_the_repeats_of_the_same_stop():
    before, again = {"one": FIRM}, FIRM.model_copy(update={"distances": (280.0, 290.0)})
    (after,) = merged({"one": again}, before, "openmodelica").values()
    assert after == FIRM.model_copy(update={"compilers": {"openmodelica": (280.0, 290.0)}})
    assert after.ends_of("openmodelica") == (280.0, 290.0)
    for other in ({}, {"one": FIRM.model_copy(update={"digest": "e"})}):
        with pytest.raises(ScenarioError, match="one: there are no repeats with FMUs of the built-in compiler"):
            merged({"one": again}, other, "openmodelica")


@pytest.fixture
def refined(tmp_path, write_campaign):
    """Return a function that refines the repeats of the first of the stops; a case has the distance of a function."""
    campaign = write_campaign(tmp_path, lambda stop: stop.name.startswith("trapezoid-ideal-"))
    stop, *others = campaign.stops
    repeated = RepeatedDistances(digest=stop.scenario.digest(), distances=(300.0, 301.0, 302.0))
    before = ConditioningFile(relative=1e-7, stops={stop.name: repeated})

    def refine(of, distance):
        seen = []

        def run(function, cases):
            seen.extend(cases)
            return [distance(case) for case in cases]

        found, without = with_refinement(campaign, before, SimpleNamespace(map=run), of=of, count=2)
        assert found[stop.name].distances == repeated.distances
        return stop, others, found, without, seen

    return refine


def test_a_divided_step_keeps_the_periods_of_all_other_parts(refined):
    """Stops whose repeats belong to another scenario get none."""
    stop, others, divided, without, seen = refined("steps", lambda case: float(round(1e4 * case.periods.communication)))
    assert divided[stop.name].steps == {2: (50.0, 50.0), 4: (25.0, 25.0)}
    assert without.keys() == {other.name for other in others}
    assert all("controller.kind" not in reason and reason for reason in without.values())
    for case in seen:
        assert {name: getattr(case.periods, name) for name in ("estimator", "controller", "trace")} == {
            name: getattr(stop.scenario.periods, name) for name in ("estimator", "controller", "trace")
        }
    assert [case.vehicle.nudge.seed for case in seen] == [1, 2, 1, 2]


def test_a_missing_conditioning_file_is_reported_with_the_command_that_creates_it(tmp_path):
    with pytest.raises(ScenarioError, match=r"there is no such file; correct the path; `make conditioning`"):
        read_conditioning(tmp_path / "gone.json")


def finding(value, repeated=None):
    return Findings(
        values=(Finding(name="x", value=value, unit="m", repeated=repeated, longest_lock=18.9, valve_strokes=40),)
    )


def test_a_chaotic_stop_is_kept_within_the_range_of_its_repeats(tmp_path):
    repeats = RepeatedDistances(digest="d", distances=(280.0, 300.0, 320.0))
    before = Baseline(campaign="c", accepted={"x": AcceptedValue(value=319, unit="m", tolerance=0.3, reason="First.")})
    after = accept(before, finding(319.0, repeats), "A range.")
    stop = after.accepted["x"]
    assert (stop.value, stop.lowest, stop.highest, stop.tolerance) == (300, 280, 320, 10)
    assert (stop.longest_lock, stop.valve_strokes) == (18.9, 40)
    states = {value: compare(after, finding(value))[0].state for value in (269.9, 270.1, 310.0, 329.9, 330.1)}
    assert states == {269.9: "moved", 270.1: "kept", 310.0: "kept", 329.9: "kept", 330.1: "moved"}
    write_baseline(after, tmp_path / "b.toml")
    assert load_baseline(tmp_path / "b.toml") == after
    # Without known repeats it stays a range; repeats that no longer vary make it a number.
    assert accept(after, finding(310.0), "Again.").accepted["x"].is_range
    # A range follows its repeats, also where the distance is within the one that was accepted.
    wider = RepeatedDistances(digest="d", distances=(270.0, 300.0, 340.0))
    moved = accept(after, finding(310.0, wider), "The solver is another one.").accepted["x"]
    assert (moved.value, *moved.ends, moved.reason) == (300.0, 270.0, 340.0, "The solver is another one.")
    # Repeats within 2 cm give the tolerance of a smooth stop, 2 cm instead of 0.1 %.
    firm = accept(after, finding(280.0, FIRM), "No longer chaotic.").accepted["x"]
    assert (firm.is_range, firm.value, firm.tolerance) == (False, 280.0, 0.02)


def test_the_conditioning_of_table_1_belongs_to_its_stops_or_is_stale():
    """Committed repeats are printed with a distance only if scenario and distance are those that were repeated.

    Accepted ranges are those of the repeats: one stop has one distance on all pages.
    """
    campaign = load_campaign(CAMPAIGNS / "table1.toml")
    accepted = load_baseline(BASELINES / "table1.toml").accepted
    repeats_of = read_conditioning(campaign.conditioning).stops
    digests = {stop.name: stop.scenario.digest() for stop in campaign.stops}
    assert set(repeats_of) <= set(digests)
    for name, one in repeats_of.items():
        assert len(one.distances) >= 20
        assert digests[name] == one.digest or range_text(one, digests[name], one.median) == STALE
        assert range_text(one, digests[name], 0.5 * one.lowest) == STALE
        assert one.spreads == accepted[name].is_range
        if one.spreads:
            known = (accepted[name].value, *accepted[name].ends)
            assert known == pytest.approx((one.median, one.lowest, one.highest), abs=1e-3)


def test_the_error_over_the_tolerance_is_against_the_tightest_one():
    repeated = RepeatedDistances(
        digest="d", distances=(303.0,), tolerances={1e-4: (309.0,), 1e-8: (299.0, 300.0, 301.0), 1e-6: (None,)}
    )
    assert repeated.error_at(None)[0] == pytest.approx(0.01)
    assert repeated.error_at(1e-4)[0] == pytest.approx(0.03)
    assert repeated.error_at(1e-6)[0] == np.inf
    # √(π/2 (1 + 1/3)) standard errors of a normal draw, whose variance is the mean of both: 1² and none.
    assert repeated.error_at(None)[1] == pytest.approx(1.96 * np.sqrt(0.5 * np.pi * (4 / 3)) * np.sqrt(0.5) / 300.0)


def test_the_tables_of_tolerances_and_compilers_have_medians_and_ranges_of_all_stops(tmp_path, write_campaign):
    campaign = write_campaign(tmp_path, lambda stop: stop.name.startswith("trapezoid-ideal-"))
    tolerances = {1e-4: (312.0, None), 1e-6: (299.0, 300.0, 301.0)}
    others = {"openmodelica": tuple(305.0 + k for k in range(10))}
    stop = RepeatedDistances(digest="d", distances=(303.0, 303.0), tolerances=tolerances, compilers=others)
    (tmp_path / "c.json").write_text(text_of(ConditioningFile(relative=1e-5, stops={campaign.stops[0].name: stop})))
    campaign = replace(campaign, conditioning=tmp_path / "c.json")
    (row,) = medians_table(campaign).rows
    # Of ten values the second and the second to last are the interval; two have none, but a range.
    assert [row["built-in compiler"], row["OpenModelica"]] == ["303.0 m [303.0, 303.0]", "309.5 m [306.0, 313.0]"]
    assert row["difference"] == "**+0.99 %**"
    (row,) = tolerances_table(campaign).rows
    assert row["tightest"] == 300.0
    assert row["range"] == "299.0 – inf m"
    assert row["as in the recipe"].strip("*").startswith("+1.00 ± ")


def test_a_stop_is_repeated_at_other_tolerances(tmp_path, refined):
    stop, _, found, _, seen = refined("tolerances", lambda case: -np.log10(case.vehicle.parameters["_tolerance"].entry))
    assert found[stop.name].tolerances == {10.0**-k: (float(k), float(k)) for k in (4, 6, 7)}
    assert len({case.digest() for case in seen}) == 6
    (tmp_path / "written.json").write_text(text_of(ConditioningFile(relative=1e-7, stops=found)))
    assert read_conditioning(tmp_path / "written.json").stops == found
