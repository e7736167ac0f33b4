import numpy as np
import pytest
import xarray

from railgrip.studies.roller_rig import excursions, outside_events
from railgrip.trace.samples import recording_of

PERIOD = 0.01


def protected(error, busy):
    """A recording whose protection works where `busy`, and an estimate that is off by `error`."""
    samples = len(error)
    recording = recording_of({"protecting": (busy, "1")}, period=PERIOD, truth={"alpha": (np.full(samples, 0.05), "1")})
    estimates = xarray.Dataset(
        {"mean": (("time", "state"), (0.05 + np.asarray(error))[:, None])},
        coords={"time": recording["time"], "state": ["alpha"]},
    )
    return recording, estimates


def test_an_event_lasts_a_tenth_of_a_second_longer_than_the_release():
    busy = np.zeros(100)
    busy[40:50] = 1.0
    recording, _ = protected(np.zeros(100), busy)
    outside = outside_events(recording, settled=0.1)
    assert not outside[:10].any()
    assert outside[10:40].all()
    assert not outside[40:60].any()
    assert outside[60:].all()


def test_excursions_are_counted_timed_and_told_apart():
    busy, error = np.zeros(100), np.full(100, 0.001)
    busy[40:50] = 1.0
    error[42:47] = -0.05  # in the event: 5 samples
    error[80] = 0.03  # outside
    counts = excursions(*protected(error, busy), settled=0.1)
    assert (counts["excursions"], counts["samples_outside"]) == (2, 1)
    assert counts["longest"] == pytest.approx(5 * PERIOD)
    assert counts["alpha_largest"] == pytest.approx(0.05)
    assert counts["alpha_outside"] == pytest.approx(0.03)
    assert not counts["kept"]


def test_a_short_excursion_in_an_event_is_allowed_and_a_long_one_is_not():
    busy = np.ones(100)
    for length, is_allowed in ((10, True), (11, False)):
        error = np.zeros(100)
        error[50 : 50 + length] = 0.05
        assert excursions(*protected(error, busy), settled=0.0)["kept"] is is_allowed


def test_an_estimate_that_ended_is_over_the_limit():
    error = np.zeros(100)
    error[50:] = np.nan
    assert not excursions(*protected(error, np.zeros(100)), settled=0.0)["kept"]
