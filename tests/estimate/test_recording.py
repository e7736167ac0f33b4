"""Recordings as datasets: time, units, truth, and messages about invalid recordings."""

import numpy as np
import pytest

from railgrip.base.errors import EstimationError
from railgrip.recording.samples import period_of, recording_of, samples, truth_of


def recorded(**changes):
    signals = {"speed": (np.linspace(20.0, 19.0, 5), "m/s"), "pad_force": (np.zeros(5), "N")} | changes
    return recording_of(signals, period=0.1, truth={"v": (np.linspace(20.0, 19.0, 5), "m/s")}, name="short")


def test_time_is_counted_from_the_start():
    late = recording_of({"speed": (np.zeros(4), "m/s")}, period=0.1, start=3.0)
    assert late["time"].values.tolist() == [3.0 + k * 0.1 for k in range(4)]
    assert period_of(late) == 0.1


def test_columns_are_in_the_requested_order():
    columns = samples(recorded(), ["pad_force", "speed"], ["N", "m/s"])
    assert columns.shape == (5, 2)
    assert columns[:, 1].tolist() == np.linspace(20.0, 19.0, 5).tolist()


@pytest.mark.parametrize(
    ("change", "names", "sentence"),
    [
        ({}, ["wheelset_speed"], r"'short' has no signal wheelset_speed; it has speed, pad_force\."),
        ({"speed": (np.zeros(5), "bar")}, ["speed"], r"speed is in 'bar', the prediction needs 'm/s'"),
    ],
)
def test_a_missing_signal_or_another_quantity_is_refused(change, names, sentence):
    with pytest.raises(EstimationError, match=sentence):
        samples(recorded(**change), names, ["m/s"])


def test_samples_are_converted_to_the_given_unit():
    assert samples(recorded(speed=(np.full(5, 36.0), "km/h")), ["speed"], ["m/s"])[:, 0] == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ([0, 1, 3, 4], r"uneven, 0\.2 s after 0\.1 s where 0\.1 s is the rule"),
        ([0, 1, 2, 1, 2], r"uneven, -0\.1 s after 0\.2 s"),
    ],
)
def test_an_uneven_grid_is_refused(rows, sentence):
    with pytest.raises(EstimationError, match=sentence):
        period_of(recorded().isel(time=rows))


def test_signals_of_different_lengths_are_refused():
    with pytest.raises(EstimationError, match=r"one sample per instant, got a \(3,\), b \(4,\)"):
        recording_of({"a": (np.zeros(3), "1"), "b": (np.zeros(4), "1")}, period=0.1)


def test_only_recorded_truth_is_available():
    assert truth_of(recorded(), "v")[0] == 20.0
    with pytest.raises(EstimationError, match="does not have the true mu_b"):
        truth_of(recorded(), "mu_b")
