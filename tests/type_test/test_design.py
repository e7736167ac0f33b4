"""The cases of a type test are balanced over every axis, the same for everyone, and allow a standstill."""

from collections import Counter

import pytest

from railgrip.base.errors import ScenarioError
from railgrip.base.units import GRAVITY
from railgrip.scenario.file import merge
from railgrip.scenario.load import scenario_of
from railgrip.studies.type_test.case_set import case_named
from railgrip.studies.type_test.design import (
    CASES,
    FRICTION,
    MAX_DURATION,
    SEED,
    SMALL,
    SPEED,
    TRAINING_SEED,
    VALIDATION_SEED,
    cases,
)
from railgrip.studies.type_test.entrants import train_of


@pytest.mark.parametrize("count", [SMALL, CASES, 12])
@pytest.mark.parametrize("axis", ["curve", "rail", "load", "radius", "pads", "gradient"])
def test_every_value_of_an_axis_is_equally_frequent(count, axis):
    counts = Counter(getattr(case, axis) for case in cases(count)).values()
    assert max(counts) - min(counts) <= 1


def test_half_of_the_cases_have_no_fault_and_faults_are_equally_frequent():
    counts = Counter(case.fault for case in cases(CASES))
    assert counts.pop("none") == CASES / 2
    assert max(counts.values()) - min(counts.values()) <= 1


def test_friction_is_uniform_on_a_logarithmic_scale_and_speed_reaches_its_bounds():
    all_cases = cases(CASES)
    below = sum(case.friction < (FRICTION[0] * FRICTION[1]) ** 0.5 for case in all_cases)
    assert abs(below - CASES / 2) <= 1
    assert min(case.speed for case in all_cases) == pytest.approx(SPEED[0], rel=0.02)
    assert max(case.speed for case in all_cases) == pytest.approx(SPEED[1], rel=0.02)


def test_no_case_is_too_fast_to_stop():
    for case in cases(CASES):
        assert FRICTION[0] <= case.friction <= FRICTION[1]
        assert case.speed <= 0.6 * case.friction * GRAVITY * MAX_DURATION + 0.01
        assert case.slope > -0.3 * case.friction


def test_a_seed_gives_the_same_cases_and_sets_share_none():
    assert cases(CASES) == cases(CASES)
    points = [
        {(case.friction, case.speed, case.lot) for case in cases(CASES, seed)}
        for seed in (SEED, VALIDATION_SEED, TRAINING_SEED)
    ]
    assert sum(map(len, points)) == len(set.union(*points))


def test_a_case_is_found_by_its_name():
    for case in cases(SMALL)[::7]:
        assert case_named(case.name) == case
    for wrong in ("1", "25of24-15595", "0of0-1", "x"):
        with pytest.raises(ScenarioError, match="there is no such case; it is named like 01of24-15595"):
            case_named(wrong)


def test_a_case_states_what_is_unknown_to_the_controller():
    case = next(case for case in cases(CASES) if case.load == "tare" and case.radius == "unequal" and case.slope)
    truth = case.tables(4)["truth"]
    assert truth["load"] == 0.8
    assert truth["wheel_radius"] == [1.005, 0.995, 1.005, 0.995]
    assert truth["gradient"] == case.slope


def test_a_train_file_is_tested_with_a_filter_for_any_train(tmp_path):
    named = train_of("tram")
    assert named["vehicle"] == {"train": "tram"}
    assert named["estimator"]["kind"] == "decentralised"
    scenario = scenario_of(merge(named, {"name": "train"}), directory=tmp_path, origin="train")
    assert scenario.actuation.kind == "pneumatic"
    with pytest.raises(ScenarioError, match="--train trm: is neither"):
        train_of("trm")
