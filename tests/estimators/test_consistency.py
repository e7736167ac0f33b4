import math

import numpy as np
import pytest

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import GaussianEstimate
from railgrip.estimators.consistency import FAR, WINDOW, delay, loss_step, nis_ratio


def test_delay_of_a_first_order_lag_is_its_logarithm():
    """An estimate with time constant T is within d of a step h after T ln(h/d)."""
    time = np.arange(3000) * 1e-3
    truth = np.where(time >= 1.0, 0.05, 0.12)
    estimate = np.where(time >= 1.0, 0.05 + 0.07 * np.exp(-(time - 1.0) / 0.05), 0.12)
    expected = 0.05 * math.log(0.07 / 0.02)
    assert delay(time, truth, estimate, 1.0, 0.02) == pytest.approx(expected, abs=1e-3)  # one sample
    assert delay(time, truth, truth, 1.0, 0.02) == 0.0
    assert delay(time, truth, np.full(3000, 0.12), 1.0, 0.02) == math.inf


def test_delay_counts_to_the_last_time_outside_the_limit():
    time = np.arange(10) * 0.1
    estimate = np.array([0, 0, 0, 1, 1, 0, 1, 1, 1, 1.0])
    assert delay(time, np.ones(10), estimate, 0.2, 0.5) == pytest.approx(0.4)


def test_arguments_without_a_meaning_are_refused_with_a_sentence():
    with pytest.raises(EstimatorError, match=r"before the step at 5\.0 s"):
        delay(np.arange(3.0), np.zeros(3), np.zeros(3), 5.0, 0.1)
    with pytest.raises(EstimatorError, match=r"a mean of 2 states requires a covariance of shape \(2, 2\)"):
        GaussianEstimate(mean=np.zeros(2), covariance=np.eye(3))


def test_the_nis_ratio_of_a_consistent_filter_is_one_for_any_readings():
    """Chi-square draws whose degrees change from step to step; 1e5 of them determine the median to 1 %."""
    rng = np.random.default_rng(1)
    degrees = rng.choice([0, 1, 2, 17], 100_000)
    squared = np.where(degrees > 0, rng.chisquare(np.maximum(degrees, 1)), 0.0)
    assert nis_ratio(squared, degrees) == pytest.approx(1.0, abs=0.02)
    assert nis_ratio(4.0 * squared, degrees) == pytest.approx(4.0, abs=0.08)
    assert nis_ratio([0.0, 0.0], [0, 0]) is None


def test_a_filter_is_lost_once_most_of_a_window_is_ten_deviations_off():
    squared = np.random.default_rng(2).chisquare(2, 1000)
    degrees = np.full(1000, 2)
    assert loss_step(squared, degrees) is None
    # Nine deviations may be due to tuning, twenty may not: 20² times the median is beyond 10² times the 99.9 %
    # quantile.
    assert loss_step(81.0 * squared, degrees) is None
    gone = np.where(np.arange(1000) < 400, squared, 40.0**2 * (1.0 + squared))
    assert loss_step(gone, degrees) == 400 + WINDOW // 2
    assert loss_step(np.where(np.arange(1000) < 400, squared, np.nan), degrees) == 400 + WINDOW // 2


def test_outliers_and_a_poor_start_do_not_make_a_filter_lost():
    squared = np.random.default_rng(3).chisquare(3, 1000)
    squared[:40] = 1e9
    squared[::7] = 1e12
    assert loss_step(squared, np.full(1000, 3)) is None


def test_a_filter_that_omits_its_readings_is_lost():
    """An outlier gate keeps NIS small; the share of omitted readings reveals the loss."""
    used = np.where(np.arange(600) < 300, 5, 1)
    assert loss_step(np.ones(600), used, np.full(600, 5)) == 300 + WINDOW // 2
    assert loss_step(np.ones(600), used) is None


def test_a_recording_shorter_than_a_window_is_judged_as_a_whole():
    assert loss_step([FAR**4] * 3, [1, 1, 1]) == 2
    assert loss_step([], []) is None
