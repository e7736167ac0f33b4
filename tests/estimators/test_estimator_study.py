"""Recordings of the study of estimators are even, equal for all estimators, and judged by known errors."""

import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from railgrip.base.errors import InputError
from railgrip.campaign.work import work
from railgrip.studies.estimators.judge import CONSTANT, FORCE_BALANCE, errors_of, leaderboard, skill, truths_of
from railgrip.studies.estimators.recordings import DEMANDS, SEEDS, SENSORS, recording_cases, recording_of_case
from railgrip.studies.estimators.replay import LAGS, bound_of, replay, states
from railgrip.studies.estimators.study import ESTIMATORS, FAST, Estimators

CONSTANTS = (("adhesion", 0.05), ("pad_friction", 0.35))


@pytest.fixture(scope="module")
def short():
    """A recording of few samples: an ideal stop from a low speed on a dry rail."""
    case = recording_cases(48, SEEDS["test"])[9]
    stop = replace(case.stop, speed=5.0, friction=0.15, rail="even", fault="none", gradient="level", load="as believed")
    return replace(case, sensors="ideal", demand="full", over="time", stop=stop)


@pytest.mark.parametrize("count", [12, 48])
def test_every_value_of_the_further_axes_comes_equally_often(count):
    design = recording_cases(count, SEEDS["test"])
    for field, choices in (("sensors", SENSORS), ("demand", DEMANDS), ("over", ("time", "distance"))):
        assert set(Counter(getattr(case, field) for case in design).values()) == {count // len(choices)}


def test_the_sets_have_no_case_in_common():
    names = [case.stop.name for seed in SEEDS.values() for case in recording_cases(12, seed)]
    assert len(set(names)) == len(names)


def test_every_demand_is_recorded():
    for demand in DEMANDS:
        case = next(case for case in recording_cases(12, SEEDS["test"]) if case.demand == demand)
        recording = recording_of_case(case)
        assert recording.sizes["time"] > 100
        assert float(recording["reading_track_force"].max()) == 0.0


def test_errors_of_a_constant_are_those_of_its_definition(short):
    errors = errors_of((short, CONSTANT, CONSTANTS))
    recording = recording_of_case(short)
    truth = recording["group_adhesion"].values[recording["speed"].values > 10 / 3.6]
    assert errors.rmse["adhesion"] == pytest.approx(np.sqrt(np.mean((truth - 0.05) ** 2)), rel=1e-12)
    assert errors.bias == pytest.approx(0.05 - np.mean(truth), rel=1e-9)
    assert np.isnan(errors.coverage["adhesion"])
    total, count = truths_of(short)["adhesion"]
    assert total / count == pytest.approx(np.mean(truth), rel=1e-12)


def test_filters_that_differ_by_their_linearisation_agree_on_the_train(short):
    """Outputs of the prediction are linear but for the running resistance, and its derivatives nearly so."""
    reference = replay(short, "fmu").mean
    for kind in ("python", "iterated", "unscented", "cubature"):
        # The curvature of the prediction within 10 ms, far below the deviation of adhesion of 0.01.
        assert replay(short, kind).mean == pytest.approx(reference, abs=1e-5)


def test_all_estimators_get_the_same_readings_and_are_ranked(short):
    results = {name: [errors_of((short, name, CONSTANTS))] for name in (CONSTANT, FORCE_BALANCE, *FAST)}
    assert len({cases[0].digest for cases in results.values()}) == 1
    rows = leaderboard(results).rows
    assert [row["estimator"] for row in rows] == sorted(results, key=lambda name: results[name][0].rmse["adhesion"])
    assert skill(results[FORCE_BALANCE], results[FORCE_BALANCE]) == 0.0
    assert set(LAGS) <= set(results) <= {CONSTANT, FORCE_BALANCE, *ESTIMATORS}


def test_the_smoother_is_surer_than_the_filter_and_the_bound_positive(short):
    filtered, smoothed = replay(short, "fmu"), replay(short, "smoother")
    assert np.all(smoothed.variance <= filtered.variance * (1.0 + 1e-6))
    assert np.all(bound_of(short) > 0.0)
    assert len(bound_of(short)) == len(states())


@pytest.mark.usefixtures("in_process")
def test_a_small_run_writes_page_tables_and_json(tmp_path):
    study = Estimators(estimator=["fmu"], count=2)
    with work("estimators", tmp_path, workers=1) as job:
        page = study.page(job)
    path = page.write(tmp_path)
    assert "posterior Cramér-Rao bound" in path.read_text(encoding="utf-8")
    rows = json.loads((tmp_path / "estimators.json").read_text(encoding="utf-8"))
    assert {row["estimator"] for row in rows} == {CONSTANT, FORCE_BALANCE, "fmu"}
    assert (tmp_path / "leaderboard.csv").is_file()


def test_an_unknown_estimator_is_refused_with_the_next_name(tmp_path):
    with work("estimators", tmp_path) as job, pytest.raises(InputError, match="did you mean 'unscented'"):
        Estimators(estimator=["unscentd"]).page(job)
    with work("estimators", tmp_path) as job, pytest.raises(InputError, match="--write"):
        Estimators(estimator=["fmu"], write=True).page(job)
