"""The score of a stop follows from its figures by the definitions, and a leaderboard from the stops."""

import json
import math
from pathlib import Path

import numpy as np
import pandas
import pytest

from railgrip.base.errors import ScenarioError
from railgrip.report.limits import limits_of
from railgrip.report.stop import Stop
from railgrip.scenario.outcome import Outcome
from railgrip.studies.type_test.entrants import Entrant
from railgrip.studies.type_test.stop_frames import judgements, measure, plain_rows, summaries
from railgrip.trace.metrics import FIGURES, Metrics

EACH = {"longest_lock_fast", "locked_distance", "tread_energy", "actuations"}
LIMITS = limits_of()
TAKING_PART = {
    name: Entrant.model_validate({"description": name, "role": role, "tuned": tuned})
    for name, role, tuned in (
        ("dry", "reference", False), ("ideal_bound", "bound", False), ("slip_three_state", "baseline", False),
        ("tuned", "baseline", True), ("second", "baseline", True), ("mine", "entrant", False),
    )
}  # fmt: skip


def result(case, controller, distance, *, stands=True, speed=20.0, **figures):
    """A stop with standstill after `distance` that first slid at an adhesion of 0.06; other figures 0 unless given."""
    plain = {name: (0.0, 0.0) if name in EACH else 0.0 for name in FIGURES}
    metrics = Metrics(**(plain | {"distance": distance, "adhesion_at_slide": 0.06} | figures))
    variants = {"case": case, "controller": controller, "friction": "0.3", "curve": "dry"}
    stop = Stop(
        name=f"{case}-{controller}", variants=variants, digest="", metrics=metrics, versions={}, fmus={}, reason="",
        outcome=Outcome.STANDSTILL if stands else Outcome.HORIZON,
        inputs={"start": {"speed": speed}, "actuation": {"kind": "pneumatic"}},
    )  # fmt: skip
    return measure([stop])


def case(name, *, mine, tuned=300.0, second=330.0, **figures):
    distances = {"dry": 250.0, "ideal_bound": 270.0, "tuned": tuned, "second": second}
    return pandas.concat([
        *(result(name, who, far or 1.0, stands=far is not None) for who, far in distances.items()),
        result(name, "slip_three_state", 400.0, air_used=2.0, actuations=(100, 100)),
        result(name, "mine", mine or 1.0, stands=mine is not None, air_used=1.0, actuations=(200, 100), **figures),
    ])  # fmt: skip


def judged(stops):
    return judgements(stops, TAKING_PART, LIMITS)


def mine(stops):
    return next(stop for stop in judged(stops).itertuples() if stop.controller == "mine")


def board_of(stops):
    return {one.controller: one for one in summaries(judged(stops), TAKING_PART).itertuples()}


def test_a_distance_is_compared_with_dry_rail_bound_and_best_tuned_baseline():
    stop = mine(case("a", mine=315.0))
    assert stop.extension == pytest.approx(315 / 250 - 1)
    assert stop.over_bound == pytest.approx(315 / 270)
    assert stop.over_best == pytest.approx(315 / 300)
    build_up = 20.0 * LIMITS.build_up.time
    assert stop.k_wet == pytest.approx((250 - build_up) / (315 - build_up))


def test_each_clause_is_satisfied_up_to_its_limit():
    unlimited = {"locked_distance": None}  # no limit is known
    good = mine(case("a", mine=1.25 * 250, longest_lock_fast=(0.0, 0.4), utilisation=0.85, duration=30.0))
    assert (
        good.verdicts
        == {"stops": True, "extension": True, "lock": True, "reservoir": True, "utilisation": True} | unlimited
    )
    bad = mine(
        case("a", mine=1.26 * 250, longest_lock_fast=(0.41, 0.0), utilisation=0.84, duration=0.0, energy_residual=1)
    )
    assert {name for name, verdict in bad.verdicts.items() if verdict is False} == {"extension", "lock", "utilisation"}


def test_the_extension_is_evaluated_by_the_adhesion_at_the_first_slide():
    for adhesion, verdict in ((0.049, None), (0.05, False), (0.08, False), (0.081, None), (math.nan, None)):
        stops = pandas.concat([result("a", "dry", 250.0), result("a", "mine", 500.0, adhesion_at_slide=adhesion)])
        assert mine(stops).verdicts["extension"] is verdict


def test_all_controllers_of_a_case_are_evaluated_by_the_same_adhesion():
    """By the median, without the dry rail and the ideal bound; it also applies to a controller that never slides."""
    adhesions = {"dry": 0.3, "ideal_bound": 0.3, "tuned": 0.081, "second": 0.06, "slip_three_state": 0.07}
    stops = [
        result("a", name, 250.0 if name == "dry" else 500.0, adhesion_at_slide=adhesion)
        for name, adhesion in adhesions.items()
    ]
    stops.append(result("a", "mine", 500.0, adhesion_at_slide=math.nan))
    stops = judged(pandas.concat(stops))
    assert set(stops["first_adhesion"]) == {0.07}
    assert {verdicts["extension"] for verdicts in stops["verdicts"]} == {False}


def test_a_train_that_does_not_stop_fails_and_has_no_distance():
    stop = mine(case("a", mine=None))
    assert math.isnan(stop.distance_m)
    assert math.isnan(stop.over_best)
    assert stop.k_wet == 0.0
    assert stop.verdicts["stops"] is False
    assert stop.verdicts["extension"] is False


def test_a_reservoir_loses_the_air_that_the_compressor_does_not_supply():
    """p V is constant: 450 l at 8 bar that supply 0.9 m3 of free air lose two atmospheres."""
    supply = LIMITS.supply.model_copy(update={"delivery": 0.0})
    assert supply.remaining(0.9, 10.0) == pytest.approx(8e5 - 2 * 101325)
    assert supply.remaining(100.0, 10.0) == 0.0
    assert LIMITS.supply.remaining(0.1, 60.0) == 8e5  # it is not filled beyond its initial pressure


def test_the_leaderboard_has_the_quantiles_of_the_ratios():
    board = board_of(pandas.concat(case(str(n), mine=far) for n, far in enumerate((270.0, 285.0, 300.0, 345.0))))
    own = board["mine"]
    assert (own.median, own.p95, own.worst) == pytest.approx((0.95, 1.15, 1.15))
    assert (own.stops, own.cases) == (1.0, 4)
    assert own.over_bound == pytest.approx(285 / 270)
    assert (own.air, own.strokes) == pytest.approx((0.5, 1.5))
    assert board["tuned"].worst == 1.0
    assert list(board) == ["ideal_bound", "mine", "tuned", "second", "slip_three_state"]
    assert board["ideal_bound"].median == pytest.approx(270 / 300)  # the possible gain
    assert own.k_wet is not None
    assert own.k_wet_low is own.k_wet_high is None  # too few cases for an interval


def test_one_stop_without_end_makes_the_worst_ratio_undefined():
    own = board_of(pandas.concat(case(str(n), mine=far) for n, far in enumerate((270.0, 285.0, None))))["mine"]
    assert own.median == pytest.approx(0.95)
    assert own.worst is None
    assert own.stops == pytest.approx(2 / 3)
    assert own.kept["stops"] == pytest.approx(2 / 3)


def test_a_baseline_that_locks_longer_than_the_clause_allows_is_not_the_best():
    others = case("a", mine=315.0)
    locked = result("a", "tuned", 300.0, longest_lock_fast=(0.0, 0.41))
    others = pandas.concat([others[others["controller"] != "tuned"], locked])
    assert set(judged(others)["best_m"]) == {330.0}
    assert mine(others).over_best == pytest.approx(315 / 330)
    unlimited = LIMITS.model_copy(update={"lock": LIMITS.lock.model_copy(update={"limit": None})})
    assert set(judgements(others, TAKING_PART, unlimited)["best_m"]) == {300.0}


def test_a_case_is_not_compared_without_a_baseline_that_satisfies_the_lock_clause():
    locked = [
        result("b", who, 300.0, longest_lock_fast=(9.0, 0.0)) if who in ("tuned", "second") else result("b", who, 290.0)
        for who in ("dry", "tuned", "second", "mine")
    ]
    own = board_of(pandas.concat([case("a", mine=315.0), *locked]))["mine"]
    assert (own.cases, own.compared) == (2, 1)
    assert own.median == pytest.approx(315 / 300)
    assert own.median_interval == (None, None)  # one case has no interval


def test_intervals_of_median_and_quantile_contain_them_and_shrink_with_the_cases():
    widths = []
    for count in (100, 900):
        distances = 300.0 + np.random.default_rng(3).normal(0.0, 15.0, count)
        own = board_of(pandas.concat(case(str(n), mine=far) for n, far in enumerate(distances)))["mine"]
        for value, (low, high) in ((own.median, own.median_interval), (own.p95, own.p95_interval)):
            assert low < value < high
        widths.append(own.median_interval[1] - own.median_interval[0])
        # that of a median of many normal numbers is 2 × 1.96 × 1.2533 standard deviations over √n
        assert widths[-1] == pytest.approx(2 * 1.96 * 1.2533 * 0.05 / count**0.5, rel=0.6)
    assert widths[1] < widths[0]


def test_without_a_tuned_baseline_that_stops_nothing_is_compared():
    stop = mine(case("a", mine=300.0, tuned=None, second=None))
    assert math.isnan(stop.best_m)
    assert math.isnan(stop.over_best)


def test_an_invalid_limit_is_refused(tmp_path):
    text = (Path(limits_of.__code__.co_filename).parent / "library" / "limits.toml").read_text(encoding="utf-8")
    path = tmp_path / "own.toml"
    path.write_text(text.replace("limit = 0.4", "limit = 0.1"), encoding="utf-8")
    assert limits_of(path).lock.limit == 0.1
    path.write_text(text.replace("limit = 0.4", "limt = 0.4"), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"own.toml: \[lock\] has no key 'limt'; did you mean 'limit'"):
        limits_of(path)
    path.write_text(text.replace("volume = 0.45", "volume = -1"), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"\[supply\] volume"):
        limits_of(path)


def test_the_interval_of_k_wet_contains_the_quantile_of_equal_cases():
    own = board_of(pandas.concat(case(str(n), mine=300.0 + n) for n in range(40)))["mine"]
    values = sorted((250 - 10) / (300 + n - 10) for n in range(40))
    assert own.k_wet == pytest.approx(values[3])
    assert own.k_wet_low == pytest.approx(values[0], abs=0.01)
    assert own.k_wet_low < own.k_wet < own.k_wet_high


def test_json_has_no_nan():
    stop = plain_rows(judged(case("a", mine=300.0, utilisation=math.nan)))[-1]
    assert stop["controller"] == "mine"
    assert stop["utilisation"] is stop["verdicts"]["utilisation"] is None
    assert json.dumps(stop, allow_nan=False)
