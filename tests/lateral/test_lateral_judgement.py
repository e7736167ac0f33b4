"""Detector of the rail condition, and figures over the seeds."""

import math

import lateral_runs
import numpy as np
import pytest
from scipy.stats import norm

from railgrip.base.errors import EstimatorError
from railgrip.estimation.lateral.run import NAMES
from railgrip.estimation.lateral.run_measures import QUANTITIES
from railgrip.estimators.rail import UNDECIDED, ConditionDetector, confusion

LEVELS = {"dry": 0.46, "wet": 0.30, "poor": 0.20, "worst": 0.10}


def detector(**changes):
    return ConditionDetector(**{"levels": LEVELS, "confidence": 0.9, "hold": 0.003, "model_deviation": 0.0, **changes})


def test_probabilities_are_those_of_a_gaussian_between_midpoints():
    shares = detector().probabilities(np.array([0.28]), np.array([0.05]))[0]
    exact = [norm.sf((0.38 - 0.28) / 0.05), None, None, norm.cdf((0.15 - 0.28) / 0.05)]
    assert shares[0] == pytest.approx(exact[0], rel=1e-12)
    assert shares[3] == pytest.approx(exact[3], rel=1e-12)
    assert shares.sum() == pytest.approx(1.0, rel=1e-15)


def test_a_condition_is_reported_after_the_hold_time_and_kept_while_uncertain():
    mean = np.array([0.46] * 5 + [0.38] * 3 + [0.10] * 5)
    labels = detector().labels(mean, np.full(13, 0.01), 1e-3)
    assert labels.tolist() == [UNDECIDED] * 2 + [0] * 3 + [0] * 3 + [0] * 2 + [3] * 3


def test_an_estimate_of_nan_reports_no_condition():
    labels = detector(hold=0.0).labels(np.array([np.nan, 0.2]), np.array([np.nan, 0.001]), 1e-3)
    assert labels.tolist() == [UNDECIDED, 2]


def test_the_detector_waits_longer_with_model_errors():
    exact, uncertain = (
        detector(hold=0.0, model_deviation=d).labels(np.array([0.22]), np.array([1e-4]), 1e-3) for d in (0.0, 0.05)
    )
    assert (exact[0], uncertain[0]) == (2, UNDECIDED)


def test_confusion_counts_every_sample_once():
    counts = confusion(np.array([0, 0, 1, 3]), np.array([0, UNDECIDED, 2, 3]), 4)
    assert counts.sum() == 4
    assert (counts[0, 0], counts[0, 4], counts[1, 2], counts[3, 3]) == (1, 1, 1, 1)


@pytest.mark.parametrize("wrong", [{"confidence": 0.3}, {"levels": {"dry": 0.4}}, {"hold": -1.0}])
def test_a_detector_that_cannot_decide_is_refused(wrong):
    with pytest.raises(EstimatorError, match="ConditionDetector"):
        detector(**wrong)


def test_the_interval_of_ten_seeds_is_second_to_ninth():
    """Binomial: the median of ten is between the second and the ninth value with 1 − 22/1024."""
    found = lateral_runs.interval([float(k) for k in range(1, 11)], "rmse")
    assert found == {"rmse": 5.5, "rmse low": 2.0, "rmse high": 9.0}


def test_runs_without_a_value_count_as_infinite():
    found = lateral_runs.interval([1.0, 2.0, math.nan, None, None], "rmse")
    assert found == {"rmse": math.inf, "rmse low": 1.0, "rmse high": math.inf}


def run_with(rmse, **others):
    """Measures of a run, in which the reconstruction has some error of creep and force, and the others have 3."""
    errors = {name: {key: {"rmse": 3.0} for key in QUANTITIES} for name in NAMES}
    errors["reconstruction"] |= {key: {"rmse": rmse} for key in ("creep", "creep_force")}
    sizes = dict.fromkeys(QUANTITIES, 2.0)
    nothing = dict.fromkeys(NAMES)
    unknown = {"levels": {}, "spike": nothing, "lost": nothing, "nis": nothing}
    return {"errors": errors, "constant": sizes, "size": sizes, **unknown, **others}


@pytest.fixture
def runs(monkeypatch):
    """Runs of the seeds from 1 on, which a test fills."""
    found = []
    monkeypatch.setattr(lateral_runs, "_runs", lambda *_: found)
    return found


def test_errors_are_relative_to_those_of_the_best_constant(runs):
    runs += [run_with(None)]
    ratios = {(row["quantity"], row["filter"]): row["ratio"] for row in lateral_runs.skill_rows("dry", 1, 1.0)}
    assert len(ratios) == 4 * len(NAMES)
    assert {key for key, ratio in ratios.items() if math.isinf(ratio)} == {
        ("creep", "reconstruction"), ("creep force", "reconstruction")
    }  # fmt: skip
    assert {ratio for ratio in ratios.values() if math.isfinite(ratio)} == {1.5}


def test_errors_of_friction_are_listed_by_condition(runs):
    levels = {"known_track": {"dry": (0.11, 0.35), "worst": (0.1, 0.001)}, "unknown_track": {}}
    runs += [run_with(1.0, levels=levels)]
    known, unknown = lateral_runs.friction_rows("softer", 1, 1.0)
    assert (known["dry 0.46"], known["wet 0.3"], known["worst 0.1"]) == (0.35, math.inf, 0.001)
    assert math.isinf(unknown["dry 0.46"])


def test_lost_filters_are_counted_and_the_first_instant_is_given(runs):
    lost = {"reconstruction": 2.5, "known_track": None, "unknown_track": None}
    nis = dict.fromkeys(NAMES, 1.0)
    runs += [run_with(1.0, lost=lost | {"known_track": at}, nis=nis) for at in (None, 3.0, 0.5)]
    rows = lateral_runs.innovation_rows("paper", 3, 1.0)
    assert [row["lost"] for row in rows] == [3, 2, 0]
    assert [row["first"] for row in rows] == pytest.approx([2.5, 0.5, math.nan], nan_ok=True)
    assert [row["NIS"] for row in rows] == [1.0, 1.0, 1.0]


@pytest.mark.parametrize(("errors", "seed"), [((5.0, None, 1.0, 7.0, 2.0), 1), ((5.0, None, 1.0, 7.0), 1)])
def test_a_typical_run_has_the_median_error_and_diverged_runs_count_as_the_worst(runs, errors, seed):
    """Of an even number the lower of the two in the middle."""
    runs += [run_with(error) for error in errors]
    assert lateral_runs.typical_row("dry", len(errors), 1.0) == {"seed": seed, "error": 5.0}


@pytest.mark.usefixtures("own_results", "in_process")
def test_runs_of_a_study_share_their_results():
    """One seed of a short transition, with each kind of rows."""
    size = {"seeds": 1, "duration": 1.0}
    (row, _, _) = lateral_runs.longitudinal_rows("braking", **size)
    assert 0.01 < row["rms creep"] < 1.0
    begin = lateral_runs._runs.cache_info().misses
    assert len(lateral_runs.friction_rows("braking", **size)) == 2
    assert lateral_runs._runs.cache_info().misses == begin
    before, *_ = lateral_runs.spike_rows(lateral_runs.TRANSITION, **size)
    assert before["before low"] == before["before"] == before["before high"]
