"""Detector of the rail condition, statistics over seeds, and the study with its cache."""

import math
import random

import numpy as np
import pytest
from scipy.stats import norm

from railgrip.base.errors import EstimatorError
from railgrip.campaign.work import work
from railgrip.estimators.rail import UNDECIDED, ConditionDetector, confusion
from railgrip.studies.lateral.judge import QUANTITIES
from railgrip.studies.lateral.run import NAMES, LateralCase
from railgrip.studies.lateral.study import LateralPlan, page_of
from railgrip.studies.lateral.tables import (
    confidence_of,
    frame_of,
    friction_errors,
    levels,
    median_interval,
    skill,
    typical,
)
from railgrip.studies.lateral.wheelset import DRY, PLANTS, WET, WORST, SurfaceTest

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
    result = median_interval([float(k) for k in range(1, 11)])
    assert (result.median, result.low, result.high) == (5.5, 2.0, 9.0)
    assert confidence_of(10) == pytest.approx(1 - 22 / 1024)


def test_runs_without_a_value_count_as_infinite():
    result = median_interval([1.0, 2.0, math.nan, math.nan, math.nan])
    assert math.isinf(result.median)
    assert math.isinf(result.high)
    assert result.low == 1.0


@pytest.mark.filterwarnings("ignore:overflow encountered")  # of a filter that diverges
@pytest.mark.usefixtures("in_process")
def test_a_repeated_study_reads_its_runs_from_the_cache_and_writes_a_page(tmp_path, monkeypatch):
    """Same results from the cache, one page, one figure for each plant: one of each kind of deviation."""
    for plant in PLANTS.keys() - {"paper", "softer", "service", "braking"}:
        monkeypatch.delitem(PLANTS, plant)
    never_run = 25.0 + 1e-3 * random.SystemRandom().random()
    short = SurfaceTest(name="change", changes=((0.0, DRY), (0.3, WET)), duration=0.6)
    plan = LateralPlan(tests=(short,), speeds=(never_run,), seeds=1)
    with work("lateral", workers=1) as own:
        page_of(plan, own)
        # The runs, the information of one run, and the figures, which are not cached.
        assert own.run_count == 2 * len(PLANTS) + 1
        page = page_of(plan, own).write(tmp_path)
        assert own.run_count == 3 * len(PLANTS) + 1
    text = page.read_text(encoding="utf-8")
    assert "well posed, track unknown" in text
    assert len(list(tmp_path.glob("*.png"))) == len(PLANTS) + 2  # creep curves and first change of the surface
    assert (tmp_path / "errors.csv").read_text(encoding="utf-8").count("\n") == 1 + len(PLANTS) * 3 * 5


def test_the_page_names_the_conditions_that_a_filter_estimates_wrongly():
    right, wrong = (
        (case("paper"), levels_of(0.46)),
        (case("softer"), levels_of(0.11)),
    )
    sentences = {sentence for _, _, sentence in levels(frame_of([right, wrong]))}
    assert sentences == {
        "Tells μ0 within 0.05 rms in dry, worst.",
        "Tells μ0 within 0.05 rms in worst; takes dry, 0.46, for 0.11.",
    }
    ((*_, sentence),) = levels(frame_of([(case("paper"), levels_of(1e37))]))
    assert sentence.endswith("in worst; is lost in dry.")


def test_errors_are_relative_to_those_of_the_best_constant():
    errors = {name: {quantity: {"rmse": 3.0} for quantity in QUANTITIES} for name in NAMES}
    errors["reconstruction"]["creep"] = {"rmse": None}
    measures = {"errors": errors, "constant": dict.fromkeys(QUANTITIES, 2.0)}
    table = skill(frame_of([(case("paper"), measures)]), speed=25.0)
    assert [row["quantity"] for row in table.texts] == ["lateral velocity", "yaw rate", "creep", "creep force"]
    assert {row["well posed, track known"] for row in table.texts} == {"1.5"}
    assert [row["reconstruction"] for row in table.texts] == ["1.5", "1.5", "∞", "1.5"]


def test_errors_of_friction_are_listed_by_condition():
    (row,) = friction_errors(frame_of([(case("softer"), levels_of(0.11))]), speed=25.0).texts
    assert (row["dry 0.46"], row["worst 0.1"]) == ("0.35", "0.001")


def test_a_typical_run_has_the_median_error_and_diverged_runs_count_as_the_worst():
    errors = {1: 5.0, 2: None, 3: 1.0, 4: 7.0, 5: 2.0}
    frame = frame_of(
        (case("paper", seed), {"errors": {"reconstruction": {"creep_force": {"rmse": error}}}})
        for seed, error in errors.items()
    )
    assert typical(frame).case.seed == 1
    assert typical(frame[:4]).case.seed == 1  # the lower of 5 and 7


def case(plant, seed=1):
    test = SurfaceTest(name="change", changes=((0.0, DRY), (0.3, WORST)), duration=0.6)
    return LateralCase(test=test, speed=25.0, plant=plant, seed=seed)


def levels_of(dry):
    return {"levels": {"known_track": {"dry": (dry, abs(0.46 - dry)), "worst": (0.1, 0.001)}}}
