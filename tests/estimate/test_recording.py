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


def test_columns_have_the_order_of_the_names():
    columns = samples(recorded(), ["pad_force", "speed"], ["N", "m/s"])
    assert columns.shape == (5, 2)
    assert columns[:, 1].tolist() == np.linspace(20.0, 19.0, 5).tolist()


def test_samples_are_converted_to_the_requested_unit():
    assert samples(recorded(speed=(np.full(5, 36.0), "km/h")), ["speed"], ["m/s"])[:, 0] == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("read", "sentence"),
    [
        (
            lambda: samples(recorded(), ["wheelset_speed"], ["rad/s"]),
            r"'short' has no signal wheelset_speed; it has speed, pad_force\.",
        ),
        (
            lambda: samples(recorded(speed=(np.zeros(5), "bar")), ["speed"], ["m/s"]),
            r"speed is in 'bar', the prediction wants 'm/s'",
        ),
        (
            lambda: period_of(recorded().isel(time=[0, 1, 3, 4])),
            r"uneven, 0\.2 s after 0\.1 s where 0\.1 s is the rule",
        ),
        (lambda: period_of(recorded().isel(time=[0, 1, 2, 1, 2])), r"uneven, -0\.1 s after 0\.2 s"),
        (
            lambda: recording_of({"a": (np.zeros(3), "1"), "b": (np.zeros(4), "1")}, period=0.1),
            r"one sample at every instant each, got a \(3,\), b \(4,\)",
        ),
        (lambda: truth_of(recorded(), "mu_b"), "does not know the true mu_b"),
    ],
)
def test_signals_that_are_missing_or_do_not_fit_are_refused(read, sentence):
    with pytest.raises(EstimationError, match=sentence):
        read()


def test_a_simulation_knows_the_truth():
    assert truth_of(recorded(), "v")[0] == 20.0
