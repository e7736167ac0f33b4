import numpy as np
import pytest

from railgrip.errors import EstimationError
from railgrip.trace.samples import period_of, recording_of, samples, truth_of


def recorded(**changes):
    signals = {"speed": (np.linspace(20.0, 19.0, 5), "m/s"), "pad_force": (np.zeros(5), "N")} | changes
    return recording_of(signals, period=0.1, truth={"v": (np.linspace(20.0, 19.0, 5), "m/s")}, name="short")


def test_time_is_counted_from_the_start():
    late = recording_of({"speed": (np.zeros(4), "m/s")}, period=0.1, start=3.0)
    assert late["time"].values.tolist() == [3.0 + k * 0.1 for k in range(4)]
    assert period_of(late) == 0.1


def test_columns_come_in_the_order_asked_for():
    columns = samples(recorded(), ["pad_force", "speed"], ["N", "m/s"])
    assert columns.shape == (5, 2)
    assert columns[:, 1].tolist() == np.linspace(20.0, 19.0, 5).tolist()


def test_a_missing_signal_is_named_with_those_that_are_there():
    with pytest.raises(EstimationError, match=r"'short' has no signal wheelset_speed; it has speed, pad_force\."):
        samples(recorded(), ["wheelset_speed"], ["rad/s"])


def test_a_signal_that_measures_something_else_is_refused():
    with pytest.raises(EstimationError, match=r"speed is in 'bar', the prediction wants 'm/s'"):
        samples(recorded(speed=(np.zeros(5), "bar")), ["speed"], ["m/s"])


def test_samples_come_in_the_unit_asked_for():
    assert samples(recorded(speed=(np.full(5, 36.0), "km/h")), ["speed"], ["m/s"])[:, 0] == pytest.approx(10.0)


def test_a_gap_in_time_is_told_where_it_is():
    gap = recorded().isel(time=[0, 1, 3, 4])
    with pytest.raises(EstimationError, match=r"uneven, 0\.2 s after 0\.1 s where 0\.1 s is the rule"):
        period_of(gap)


def test_time_that_goes_backwards_is_refused():
    with pytest.raises(EstimationError, match=r"uneven, -0\.1 s after 0\.2 s"):
        period_of(recorded().isel(time=[0, 1, 2, 1, 2]))


def test_signals_of_different_lengths_are_refused():
    with pytest.raises(EstimationError, match=r"one sample at every instant each, got a \(3,\), b \(4,\)"):
        recording_of({"a": (np.zeros(3), "1"), "b": (np.zeros(4), "1")}, period=0.1)


def test_only_what_a_simulation_tells_is_known():
    assert truth_of(recorded(), "v")[0] == 20.0
    with pytest.raises(EstimationError, match="does not know the true mu_b"):
        truth_of(recorded(), "mu_b")
