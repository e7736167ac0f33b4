"""Filters on recordings: compared with closed forms and reference filters, and with invalid data."""

from dataclasses import replace

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from scipy.linalg import expm

from railgrip.base.errors import EstimationError, EstimatorError
from railgrip.estimation.judgement import judge
from railgrip.estimation.models import of_class, units_of
from railgrip.estimation.run import Settings, by_name, estimate
from railgrip.recording.samples import recording_of

PERIOD = 0.01
EQUATION_20 = {"w": 10.0, "v": 1e-5, "mu_b": 1e-3, "alpha": 1e-1}
READINGS_20 = {"wheelset_speed": 1e-9, "speed": 1e-7}
SETTINGS = Settings(
    process={name: variance / PERIOD for name, variance in EQUATION_20.items()},
    readings=READINGS_20,
    start={"mu_b": 0.35, "alpha": 0.0},
    start_deviation={"w": 0.3, "v": 0.1, "mu_b": 0.04, "alpha": 0.02},
)
MODEL = "RollerRigPrediction"
RESISTANCE = 0.0004 / 0.46 + 1 / np.sqrt((0.46 / (0.0018 * 0.065)) ** 2 * (1 + 0.0018**2) - 1)
"""Rolling and bearing resistance of the rig, relative to its load."""


def braked(samples=60, force=2e4, alpha=0.08, mu_b=0.35, seed=3):
    """Return the closed form of a sliding rig with constant force, adhesion and friction, and noisy readings."""
    time = np.arange(samples) * PERIOD
    rate = (0.46 * 98.1e3 * (alpha - RESISTANCE) - 2 * mu_b * 0.25 * force) / 130
    w, v = 60.0 + rate * time, 30.0 - alpha * 98.1e3 / 20e3 * time
    noise = np.random.default_rng(seed).standard_normal((2, samples))
    return recording_of(
        {
            "pad_force": (np.full(samples, force), "N"),
            "wheelset_speed": (w + 3.2e-5 * noise[0], "rad/s"),
            "speed": (v + 3.2e-4 * noise[1], "m/s"),
        },
        period=PERIOD,
        truth={
            "w": (w, "rad/s"),
            "v": (v, "m/s"),
            "mu_b": (np.full(samples, mu_b), "1"),
            "alpha": (np.full(samples, alpha), "1"),
        },
    )


@pytest.fixture(scope="module")
def undragged():
    return of_class(MODEL).prediction({"A_drag": 0.0})


def test_without_drag_the_filter_is_the_kalman_filter_with_q_and_r_as_printed(undragged):
    """Without drag the rig is linear in its states; Q of equation (20) is added in every step."""
    recording = braked()
    estimates = estimate(recording, undragged, SETTINGS, units=units_of(MODEL))
    force = 2e4
    A = np.zeros((4, 4))
    A[0] = 0.0, 0.0, -2 * 0.25 * force / 130, 0.46 * 98.1e3 / 130
    A[1] = 0.0, 0.0, 0.0, -98.1e3 / 20e3
    y = np.stack([recording["reading_wheelset_speed"].values, recording["reading_speed"].values], axis=1)
    reference = KalmanFilter(dim_x=4, dim_z=2, dim_u=1)
    reference.F, reference.H = expm(A * PERIOD), np.eye(2, 4)
    reference.B = np.array([[-0.46 * 98.1e3 / 130 * RESISTANCE * PERIOD], [0.0], [0.0], [0.0]])
    reference.Q, reference.R = np.diag(list(EQUATION_20.values())), np.diag(list(READINGS_20.values()))
    reference.x, reference.P = np.array([*y[0], 0.35, 0.0]), np.diag([0.3, 0.1, 0.04, 0.02]) ** 2
    for k in range(1, len(y)):
        reference.predict(u=np.ones(1))
        reference.update(y[k])
        assert estimates["innovation"].values[k] == pytest.approx(reference.y, abs=1e-9)
        # R is ten orders of magnitude below Q, so the update cancels nine of sixteen digits.
        assert estimates["mean"].values[k] == pytest.approx(reference.x, rel=1e-6, abs=1e-7)
        assert estimates["sd"].values[k] == pytest.approx(np.sqrt(np.diag(reference.P)), rel=5e-6, abs=1e-12)


def test_inputs_may_be_held_or_averaged(undragged):
    """For a ramp of the pad force, held inputs are delayed by half a period, averaged inputs are not."""
    recording = braked()
    ramp = recording["reading_pad_force"].values + 1e5 * recording["time"].values
    rate = np.gradient(recording["reading_wheelset_speed"].values, PERIOD).mean()
    time = recording["time"].values
    w = 60.0 + rate * time - 2 * 0.35 * 0.25 / 130 * 1e5 * time**2 / 2
    recording["reading_pad_force"].values[:] = ramp
    recording["reading_wheelset_speed"].values[:] = w
    sharp = replace(SETTINGS, process={"w": 1e-9, "v": 1e-9, "mu_b": 1e-3, "alpha": 1e-6})
    errors = {}
    for between in ("held", "mean"):
        estimates = estimate(recording, undragged, replace(sharp, between=between))
        errors[between] = abs(judge(recording, estimates, "mu_b", time > 0.3).bias)
    assert errors["mean"] < 0.2 * errors["held"]


def test_a_missing_reading_is_omitted_and_a_missing_input_refused(undragged):
    recording = braked()
    recording["reading_speed"].values[20:30] = np.nan
    estimates = estimate(recording, undragged, SETTINGS)
    assert estimates["readings"].values[20:30].tolist() == [1.0] * 10
    assert np.isnan(estimates["innovation"].values[20:30, 1]).all()
    assert np.isfinite(estimates["mean"].values).all()
    recording["reading_pad_force"].values[7] = np.nan
    with pytest.raises(EstimationError, match=r"input pad_force is not a number at 0\.070 s"):
        estimate(recording, undragged, SETTINGS)


def test_a_filter_that_diverges_ends_with_a_reason(undragged):
    recording = braked()
    recording["reading_wheelset_speed"].values[30] = 1e300
    recording["reading_wheelset_speed"].values[31] = -1e308
    recording["reading_wheelset_speed"].values[32] = 1e308
    estimates = estimate(recording, undragged, SETTINGS)
    assert "At 0.3" in estimates.attrs["ended"]
    assert np.isnan(estimates["mean"].values[-1]).all()


@pytest.mark.parametrize("limit", [None, 5.0])
def test_a_lost_filter_is_reported_with_the_instant(undragged, limit):
    """From 1.5 s the noise of both sensors is far larger; an outlier limit does not hide it.

    Before, the filter is consistent, so nothing is reported.
    """
    honest = replace(
        SETTINGS,
        process={"w": 1e-12, "v": 1e-12, "mu_b": 1e-14, "alpha": 1e-14},
        readings={"wheelset_speed": 3.2e-5**2, "speed": 3.2e-4**2},
        outlier_limit=limit,
    )
    recording = braked(samples=300)
    estimates = estimate(recording, undragged, honest)
    assert estimates.attrs["ended"] == ""
    assert estimates.attrs["nis_ratio"] == pytest.approx(1.0, abs=0.25)
    for name in ("reading_wheelset_speed", "reading_speed"):
        recording[name].values[150:] += 0.3 * np.random.default_rng(4).standard_normal(150)
    estimates = estimate(recording, undragged, honest)
    assert estimates.attrs["ended"].startswith("Filter: lost;")
    assert "At 2.0" in estimates.attrs["ended"]
    assert np.isfinite(estimates["mean"].values).all()


def test_missing_and_unknown_names_are_refused(undragged):
    with pytest.raises(
        EstimationError, match=r"\[noise\] process lacks group_adhesion; it has wheelset_speed, speed, pad_friction"
    ):
        estimate(braked(), undragged, replace(SETTINGS, process={"w": 1.0, "v": 1.0, "mu_b": 1.0}))
    with pytest.raises(EstimationError, match=r"\[noise\] readings has acceleration, the model has wheelset_speed"):
        estimate(braked(), undragged, replace(SETTINGS, readings=READINGS_20 | {"acceleration": 1.0}))
    with pytest.raises(EstimationError, match=r"\[start\] mean lacks pad_friction"):
        estimate(braked(), undragged, replace(SETTINGS, start={"alpha": 0.0}))
    unread = braked()
    unread["reading_speed"][:] = np.nan
    with pytest.raises(EstimationError, match=r"speed begins at .* of speed, .* write speed in \[start\] mean"):
        estimate(unread, undragged, SETTINGS)
    with pytest.raises(EstimatorError, match="not positive definite"):
        estimate(braked(), undragged, replace(SETTINGS, readings={"wheelset_speed": 0.0, "speed": 1.0}))
    with pytest.raises(EstimationError, match="RollerRigPrediction has no parameter mass"):
        of_class(MODEL).prediction({"mass": 1.0})
    with pytest.raises(EstimationError, match="RollerRigPrediction has no output yaw; it has wheelset_speed, speed"):
        of_class(MODEL).prediction({}, ("speed", "yaw"))


def test_an_element_takes_precedence_over_its_array():
    assert by_name("start", {"w": 1.0, "w[2]": 3.0}, ("w[1]", "w[2]")).tolist() == [1.0, 3.0]
